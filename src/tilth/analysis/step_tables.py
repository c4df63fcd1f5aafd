# SPDX-License-Identifier: BSD-3-Clause
"""The files with one row per step: history.csv, boundaries.csv where a boundary moves, and
energies.csv with inertia."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from tilth.analysis.energies import ENERGY_KINDS, Energies
from tilth.analysis.motions import moment_unit, motion_columns, motion_values
from tilth.analysis.run_warnings import RunWarnings
from tilth.analysis.setup import Setup
from tilth.analysis.state import State
from tilth.analysis.step_result import StepResult
from tilth.analysis.tracker import Tracker, tracked_columns
from tilth.model import Model
from tilth.mpm.points import MaterialPoints
from tilth.output import HistoryWriter
from tilth.output.folder import BOUNDARIES, ENERGIES, HISTORY
from tilth.output.history import Mark, checked_history, headings


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
        folder: of the run; None in a process that writes no files.
        model: the whole model.
        initial: see `Tracker`.
        stored: what the files begin with; new files if None.

    Raises:
        AnalysisFailed: a file cannot be written.
    """

    def __init__(
        self,
        folder: Path | None,
        model: Model,
        initial: MaterialPoints,
        stored: StoredRows | None = None,
    ) -> None:
        stages = bool(model.stages)
        rows = stored or StoredRows(b"", b"", b"")
        self._model = model
        self._tracker = Tracker(model, initial)
        self._columns = {
            HISTORY: self._tracker.columns,
            BOUNDARIES: motion_columns(model),
            ENERGIES: energy_columns(model),
        }
        begin = {HISTORY: rows.history, BOUNDARIES: rows.boundaries, ENERGIES: rows.energies}
        self._files: dict[str, HistoryWriter] = {}
        if folder is not None:
            self._files = {
                name: HistoryWriter(folder / name, columns, begin[name], stages)
                for name, columns in self._columns.items()
                if columns or name == HISTORY
            }

    @property
    def headings(self) -> list[str]:
        """Headings of the tracked quantities, ``name [unit]``."""
        return headings(self._columns[HISTORY])

    def rows(
        self,
        time: float,
        setup: Setup,
        state: State,
        result: StepResult | None,
        energies: Energies,
        warnings: RunWarnings,
    ) -> dict[str, list[float]]:
        """Returns the values of a step by the names of the files; all processes call it.

        time: of the stage. energies: with those of this step. warnings: of the run.
        """
        found = {HISTORY: self._tracker.values(setup, state, result, energies)}
        if self._columns[BOUNDARIES]:
            found[BOUNDARIES] = motion_values(self._model, setup, state, result)
        if self._columns[ENERGIES]:
            values = energies.values(setup, state, time)
            warnings.contact_gives(values, energies.start)
            found[ENERGIES] = [values[kind] for kind in ENERGY_KINDS]
        return found

    def append(
        self,
        step: int,
        time: float,
        iterations: int,
        rows: Mapping[str, list[float]],
        stage: tuple[str, float],
    ) -> None:
        """Writes the rows of a step.

        time: total time. rows: see `rows`. stage: its name and the time in it.
        """
        for name, file in self._files.items():
            file.append(step, time, iterations, rows[name], stage)

    def marks(self) -> dict[str, Mark]:
        """Returns what a checkpoint keeps of the files."""
        none = Mark(0, 0)
        names = {"history": HISTORY, "boundaries": BOUNDARIES, "energy_rows": ENERGIES}
        return {
            key: self._files[name].mark if name in self._files else none
            for key, name in names.items()
        }

    def sync(self) -> None:
        """Waits until all rows are on the disk; also while another thread appends to them."""
        for table in self._files.values():
            table.sync()

    def close(self) -> None:
        """Closes the files."""
        for table in self._files.values():
            table.close()
