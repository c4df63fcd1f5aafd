# SPDX-License-Identifier: BSD-3-Clause
"""Boundaries of a step together: what they prescribe, their multipliers, their construction."""
