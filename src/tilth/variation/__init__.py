# SPDX-License-Identifier: BSD-3-Clause
"""Values of what varies from place to place: material parameters and horizons of layers."""
