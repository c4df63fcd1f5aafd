# SPDX-License-Identifier: BSD-3-Clause
"""The forces of the balance, each a term with the interface of `protocol.py`."""
