# SPDX-License-Identifier: BSD-3-Clause
"""Material points and the grid that they move through; the soil's answer to its motion."""
