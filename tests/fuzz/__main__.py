# SPDX-License-Identifier: BSD-3-Clause
"""Runs the random tests: `python tests/fuzz --help`."""

import os
import sys
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"  # processes are forked: there must be no threads yet
os.environ["MPLBACKEND"] = "agg"
sys.path.insert(0, str(Path(__file__).parents[1]))

from fuzz.command import main  # noqa: E402

sys.exit(main())
