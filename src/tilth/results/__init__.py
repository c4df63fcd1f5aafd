# SPDX-License-Identifier: BSD-3-Clause
"""The results of a run for Python: arrays on demand, tables, pictures."""
