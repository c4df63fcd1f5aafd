# SPDX-License-Identifier: BSD-3-Clause
"""Verification: closed forms, reference data and the problems that are held to them."""
