# SPDX-License-Identifier: BSD-3-Clause
"""Runs the metamorphic tests: `python -m tests.metamorphic --help`."""

import os
import sys
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ["MPLBACKEND"] = "agg"
sys.path.insert(0, str(Path(__file__).parents[1]))

from metamorphic.command import main

sys.exit(main())
