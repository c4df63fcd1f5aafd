# SPDX-License-Identifier: BSD-3-Clause
"""Contact of the soil with boundaries and rigid bodies: it can separate and slide."""
