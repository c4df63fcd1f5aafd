# SPDX-License-Identifier: BSD-3-Clause
"""The lines of the background grid, the keys of its nodes, and which process has them."""
