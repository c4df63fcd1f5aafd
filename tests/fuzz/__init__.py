# SPDX-License-Identifier: BSD-3-Clause
"""Seeded random tests: wrong case files and damaged run folders (`python tests/fuzz`)."""
