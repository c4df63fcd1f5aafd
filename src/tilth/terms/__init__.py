# SPDX-License-Identifier: BSD-3-Clause
"""The forces of the balance: each is a term behind one protocol (`protocol.py`)."""
