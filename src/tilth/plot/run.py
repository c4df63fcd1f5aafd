# SPDX-License-Identifier: BSD-3-Clause
"""What pictures of a run need of its folder: results, set-up, stages, motions of boundaries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.model.load_curve import LoadCurve
from tilth.output.folder import (
    BOUNDARIES,
    HISTORY,
    RESULTS,
    SETUP,
    read_declared,
    require_folder,
)
from tilth.output.history import read_history, read_stages
from tilth.output.snapshot import Snapshot
from tilth.output.vtkhdf import Results, read_results
from tilth.report.explorer.boundaries import boundaries_at
from tilth.report.setup_data import Setup
from tilth.report.setup_file import read_setup, read_staged_setup
from tilth.report.stage_marks import Span, stage_of
from tilth.report.stage_setups import StagedSetup


def results_of(folder: Path | str) -> Results:
    """Returns the results in the folder of a run; raises ``BadInput`` if there are none."""
    return read_results(require_folder(folder) / RESULTS)


@dataclass(frozen=True, eq=False)
class PlottedRun:
    """A run whose results are drawn."""

    folder: Path
    results: Results
    declared: Mapping[str, Any]
    """The model as nested mappings and lists; empty where the folder has none."""
    setup: Setup | StagedSetup | None
    stages: Sequence[Span]
    moving: Mapping[str, Floats]
    """Columns of boundaries.csv by heading."""

    @classmethod
    def of(cls, folder: Path | str) -> PlottedRun:
        """Returns the run in a folder; raises ``BadInput`` if there are no results."""
        folder, results = Path(folder), results_of(folder)
        declared: Mapping[str, Any] = {}
        setup: Setup | StagedSetup | None = None
        moving: Mapping[str, Floats] = {}
        with suppress(BadInput):
            declared = read_declared(folder)
        with suppress(BadInput):
            file = folder / SETUP
            setup = read_staged_setup(file) or read_setup(file, results.snapshot(0))
        with suppress(BadInput):
            moving = read_history(folder / BOUNDARIES)
        stages = read_stages(folder / HISTORY) if declared.get("stages") else []
        return cls(folder, results, declared, setup, stages, moving)

    @property
    def axis_names(self) -> tuple[str, str, str]:
        """Names of the axes; r instead of x in axisymmetry."""
        analysis = self.declared.get("analysis", {})
        axisymmetric = isinstance(analysis, Mapping) and analysis.get("kind") == "axisymmetric"
        return ("r" if axisymmetric else "x", "y", "z")

    @property
    def length_unit(self) -> str:
        """The unit of length, "" if not known."""
        return self.results.units.get("length", "")

    def boundaries(self, snapshot: Snapshot, low: Floats, high: Floats) -> list[dict[str, Any]]:
        """Returns the boundaries at an output inside a box, as ``boundaries_at`` does.

        In the plane also those along grid lines that hold the soil, unless stages change them.
        """
        box = (low, high)
        found = boundaries_at(self.setup, self.moving, snapshot.step, snapshot.time, box)
        if snapshot.dim == 2 and not self.declared.get("stages"):
            for declared in self.declared.get("boundaries", ()):
                with suppress(KeyError, TypeError, ValueError):
                    found += _on_grid_line(declared, low, high)
        return found

    def water(self, time: float) -> Floats | None:
        """Returns the vertices of the water's surface at a time [length], shape (k, 2)."""
        return None if self.setup is None else self.setup.water_at(time)

    def title(self, snapshot: Snapshot) -> str:
        """Returns the time of an output, its load factor if there is one, and its stage."""
        unit = self.results.units.get("time", "")
        parts = [f"time {snapshot.time:.4g} {unit}".strip()]
        if (factor := self.load_factor(snapshot.time)) is not None:
            parts.append(f"load factor {factor:.3g}")
        if self.stages:
            parts.append(f"stage {stage_of(self.stages, snapshot.time)[0]}")
        return ", ".join(parts)

    def load_factor(self, time: float) -> float | None:
        """Returns the factor of all loads at a time; None with stages or different factors."""
        with suppress(KeyError, TypeError, ValueError, IndexError):
            if self.declared.get("stages"):
                return None
            end = float(self.declared["schedule"]["end"])
            tables = [each.get("factor") or ((0.0, 0.0), (end, 1.0)) for each in self._loads()]
            factors = {round(LoadCurve(table).factor(time), 12) for table in tables}
            return factors.pop() if len(factors) == 1 else None
        return None

    def _loads(self) -> list[Mapping[str, Any]]:
        return list(self.declared.get("loads", ()))


def _on_grid_line(declared: Mapping[str, Any], low: Floats, high: Floats) -> list[dict[str, Any]]:
    """Returns the part of a roller or fixed boundary along a grid line that is in a box."""
    if declared["type"] != "plane" or declared["condition"] not in ("roller", "fixed"):
        return []
    axis, at = "xy".index(declared["axis"]), float(declared["at"])
    other = 1 - axis
    ends = (declared.get("range") or {}).get("xy"[other]) or (low[other], high[other])
    span = np.clip(np.asarray(ends, dtype=np.float64), low[other], high[other])
    if not low[axis] <= at <= high[axis] or span[0] == span[1]:
        return []
    place = np.full((1, 2, 2), at)
    place[0, :, other] = span
    return [{"name": str(declared["name"]), "kind": "boundary", "position": place}]
