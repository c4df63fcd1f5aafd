# SPDX-License-Identifier: BSD-3-Clause
"""Studies: many runs of one case with other values in it, and one table of what they give."""
