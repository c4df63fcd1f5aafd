# SPDX-License-Identifier: BSD-3-Clause
"""Contact of soil with rigid bodies and boundaries: separation, friction, adhesion."""
