# SPDX-License-Identifier: BSD-3-Clause
"""Results of a run in files for other programs: VTK, CSV, Gmsh, a state of ParaView."""
