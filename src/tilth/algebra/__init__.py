# SPDX-License-Identifier: BSD-3-Clause
"""Fields at nodes, their unknowns, and the matrix that couples them."""
