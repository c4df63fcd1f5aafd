# SPDX-License-Identifier: BSD-3-Clause
"""Metamorphic tests: random valid models, and what must hold of them whatever the result is."""
