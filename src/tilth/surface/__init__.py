# SPDX-License-Identifier: BSD-3-Clause
"""Tracked surfaces of bodies and the loads on them."""
