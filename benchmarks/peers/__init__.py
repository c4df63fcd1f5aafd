# SPDX-License-Identifier: BSD-3-Clause
"""tilth beside other codes."""
