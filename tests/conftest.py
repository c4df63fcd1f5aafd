# SPDX-License-Identifier: BSD-3-Clause
"""Settings of all tests; must come before the first import of tilth."""

import os

os.environ.setdefault("OMP_WAIT_POLICY", "passive")  # idle threads leave the cores to others
