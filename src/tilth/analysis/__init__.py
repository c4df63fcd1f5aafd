# SPDX-License-Identifier: BSD-3-Clause
"""A run from its declared model to its results: load steps, Newton's iteration, records."""
