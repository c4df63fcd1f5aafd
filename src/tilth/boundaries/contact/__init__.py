# SPDX-License-Identifier: BSD-3-Clause
"""Contact of soil with boundaries and rigid bodies."""
