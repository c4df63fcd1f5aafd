# SPDX-License-Identifier: BSD-3-Clause
"""Element tests: one material point along the paths of a laboratory, and their outputs."""
