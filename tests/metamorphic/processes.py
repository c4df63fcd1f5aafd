# SPDX-License-Identifier: BSD-3-Clause
"""Several processes compute the same."""

from __future__ import annotations

import copy
from collections.abc import Iterator

import numpy as np
from mpi_runs import run_model

from metamorphic.bounds import by_round_off
from metamorphic.compare import Scales
from metamorphic.subject import Subject
from tilth import Model

NUMBERS = (2, 3)
"""Processes, of which the smaller number is that of the cores."""


def processes(subject: Subject) -> Iterator[str]:
    """Runs of two and of three processes end at the same places as that of one, or are refused."""
    entries = copy.deepcopy(subject.entries)
    if entries["analysis"]["solver"] != "multigrid":
        entries["analysis"]["solver"] = "auto"  # direct solvers for one process are refused
    for number in NUMBERS:
        try:
            found = run_model(Model.from_dict(entries), number)
        except AssertionError as error:
            if "BadInput" not in str(error):
                raise
            return  # what several processes cannot compute is refused
        last, scale = subject.run.moments[-1], Scales.of(subject.run).length
        if found["position"].shape != last.position.shape:
            yield f"{number} processes: {len(found['iterations'])} steps"
            continue
        gap = float(np.abs(found["position"] - last.position).max()) / scale
        if gap > by_round_off(subject):
            yield f"{number} processes: difference {gap:.1e} of places"
