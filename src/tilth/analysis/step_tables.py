# SPDX-License-Identifier: BSD-3-Clause
"""The files with one row per step: history.csv, boundaries.csv where a boundary moves, and
energies.csv with inertia."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tilth.analysis.energies import ENERGY_KINDS, Energies
from tilth.analysis.motions import moment_unit, motion_columns, motion_values
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.analysis.tracker import Tracker, tracked_columns
from tilth.model import Model
from tilth.mpm.points import MaterialPoints
from tilth.output import HistoryWriter
from tilth.output.folder import BOUNDARIES, ENERGIES, HISTORY
from tilth.output.history import Mark, checked_history


@dataclass(frozen=True)
class StoredRows:
    """Headings and rows of the files up to a checkpoint.

    Attributes:
        history: of history.csv.
        boundaries: of boundaries.csv; empty if nothing moves.
        energies: of energies.csv; empty without inertia.
    """

    history: bytes
    boundaries: bytes
    energies: bytes

    @classmethod
    def read(
        cls,
        folder: Path,
        model: Model,
        last_step: int,
        history: Mark,
        boundaries: Mark,
        energies: Mark,
    ) -> StoredRows:
        """Reads the rows of the steps 0 to `last_step`; the marks are those of the checkpoint.

        Raises:
            BadInput: a file is not as the checkpoint expects it.
        """
        tracked = tracked_columns(model)
        moved, stages = motion_columns(model), bool(model.stages)
        of_energies = energy_columns(model)
        return cls(
            checked_history(folder / HISTORY, tracked, last_step, history, stages),
            checked_history(folder / BOUNDARIES, moved, last_step, boundaries, stages)
            if moved
            else b"",
            checked_history(folder / ENERGIES, of_energies, last_step, energies, stages)
            if of_energies
            else b"",
        )


def energy_columns(model: Model) -> list[tuple[str, str]]:
    """Returns names and unit labels of the columns of energies.csv; none without inertia."""
    if model.analysis.inertia is None:
        return []
    return [(kind, moment_unit(model)) for kind in ENERGY_KINDS]


class StepTables:
    """Writes the files row by row.

    Args:
        folder: of the run.
        model: the whole model.
        initial: see `Tracker`.
        stored: what the files begin with; new files if None.

    Raises:
        AnalysisFailed: a file cannot be written.
    """

    def __init__(
        self, folder: Path, model: Model, initial: MaterialPoints, stored: StoredRows | None = None
    ) -> None:
        stages = bool(model.stages)
        rows = stored or StoredRows(b"", b"", b"")
        self._model = model
        self._tracker = Tracker(model, initial)
        columns = self._tracker.columns
        self._history = HistoryWriter(folder / HISTORY, columns, rows.history, stages)
        self._boundaries: HistoryWriter | None = None
        if columns := motion_columns(model):
            file = folder / BOUNDARIES
            self._boundaries = HistoryWriter(file, columns, rows.boundaries, stages)
        self._energies: HistoryWriter | None = None
        if columns := energy_columns(model):
            file = folder / ENERGIES
            self._energies = HistoryWriter(file, columns, rows.energies, stages)

    def append(
        self,
        step: int,
        time: tuple[float, float],
        simulation: Simulation,
        result: StepResult | None,
        iterations: int,
        energies: Energies,
    ) -> None:
        """Writes the rows of a step.

        time: total time and that of the stage. energies: with those of this step.
        """
        stage = (simulation.model.stage.name, time[1])
        values = self._tracker.values(simulation, result, energies)
        self._history.append(step, time[0], iterations, values, stage)
        if self._boundaries is not None:
            values = motion_values(self._model, simulation, result)
            self._boundaries.append(step, time[0], iterations, values, stage)
        if self._energies is not None:
            found = energies.values(simulation, time[1])
            values = [found[kind] for kind in ENERGY_KINDS]
            self._energies.append(step, time[0], iterations, values, stage)

    def marks(self) -> dict[str, Mark]:
        """Returns what a checkpoint keeps of the files."""
        none = Mark(0, 0)
        return {
            "history": self._history.mark,
            "boundaries": none if self._boundaries is None else self._boundaries.mark,
            "energy_rows": none if self._energies is None else self._energies.mark,
        }

    def sync(self) -> None:
        """Waits until all rows are on the disk; also while another thread appends to them."""
        for table in self._tables():
            table.sync()

    def close(self) -> None:
        """Closes the files."""
        for table in self._tables():
            table.close()

    def _tables(self) -> list[HistoryWriter]:
        tables = self._history, self._boundaries, self._energies
        return [table for table in tables if table is not None]
