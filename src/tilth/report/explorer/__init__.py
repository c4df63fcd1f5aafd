# SPDX-License-Identifier: BSD-3-Clause
"""The interactive part of ``report.html``: curves, and the deformed body at all outputs."""
