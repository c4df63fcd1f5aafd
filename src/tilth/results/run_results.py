# SPDX-License-Identifier: BSD-3-Clause
"""`tilth.open`: the results of a run, read when they are asked for."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.model.overview import html_table
from tilth.output.folder import HISTORY, RESULTS, load_model, require_folder
from tilth.output.history import read_history, read_stages
from tilth.output.snapshot import Snapshot, SurfaceShape
from tilth.output.vtkhdf import read_results
from tilth.plot.names import output_at, require_field
from tilth.report.fields import field_unit, field_values
from tilth.results.meshes import blocks_of
from tilth.results.table import History

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from tilth.export.parts import Show
    from tilth.export.run import Format
    from tilth.export.source import Times
    from tilth.model import Model


def open(folder: Path | str) -> RunResults:
    """Opens the results in the folder of a run, also of one that is not finished.

    What a run writes later is seen after opening the folder again.

    Raises:
        BadInput: the folder is not that of a run, or has no outputs that can be read.
    """
    return RunResults(folder)


class RunResults:
    """The results of a run; every array is read when it is asked for.

    Where a method takes ``time`` and ``index``, give the time of an output, or its number (0 is the
    initial state, -1 the last one), or none of them for the last output. Raises ``BadInput``, with
    the times of the outputs, where there is none. The output that was read last is kept in memory,
    no other.
    """

    def __init__(self, folder: Path | str) -> None:
        self.folder = require_folder(folder)
        """Folder of the run."""
        if not (self.folder / RESULTS).exists():
            raise BadInput(
                f"there is no {RESULTS}", "name the folder of a tilth run", file=self.folder
            )
        self._results = read_results(self.folder / RESULTS)
        self._kept: tuple[int, Snapshot] | None = None

    @property
    def title(self) -> str:
        """Title of the model."""
        return self._results.title

    @property
    def units(self) -> dict[str, str]:
        """Labels of the units: of length, force, stress, mass, time and volume, by these keys."""
        return dict(self._results.units)

    @property
    def times(self) -> Floats:
        """Total times of the outputs, shape (outputs,)."""
        return np.array(self._results.times)

    @cached_property
    def stages(self) -> dict[str, tuple[float, float]]:
        """Total times of the first and last step so far of each stage, by name; empty without."""
        found = read_stages(self.folder / HISTORY)
        return {name: (start, end) for name, start, end in found}

    @cached_property
    def model(self) -> Model:
        """The model as it was declared; raises ``BadInput`` if it cannot be read."""
        return load_model(self.folder)

    @cached_property
    def history(self) -> History:
        """Every tracked quantity, a row per step: columns by heading, and as a table."""
        return History(read_history(self.folder / HISTORY))

    @cached_property
    def fields(self) -> dict[str, str]:
        """Names of the fields of the points at the last output, with their units ("" for none)."""
        known = {name: field_unit(name, self.units) for name in self.snapshot().point_fields}
        return {name: "" if unit == "-" else unit for name, unit in known.items()}

    def snapshot(self, time: float | None = None, *, index: int | None = None) -> Snapshot:
        """Returns all arrays of one output; they must not be changed."""
        number = self._number(time, index)
        if self._kept is None or self._kept[0] != number:
            self._kept = None  # before the other one needs memory
            self._kept = (number, self._results.snapshot(number))
        return self._kept[1]

    def points(self, time: float | None = None, *, index: int | None = None) -> Floats:
        """Returns the positions of the material points [length], shape (n, dim).

        The rows are those of ``field``: in the order of the points' permanent numbers.
        """
        return self.snapshot(time, index=index).position.copy()

    def field(
        self, name: str, time: float | None = None, *, index: int | None = None
    ) -> NDArray[Any]:
        """Returns a field of the points, tension positive.

        Args:
            name: one of ``fields``: scalars have shape (n,), vectors (n, dim), symmetric tensors
                (n, 6) in the order xx yy zz xy yz xz, other tensors (n, 3, 3). Or one with a
                component, shape (n,): ``displacement_y``, ``cauchy_stress_xx``,
                ``cauchy_stress_mean``, ``cauchy_stress_von_mises``.
            time, index: of the output.

        Raises:
            BadInput: there is no such field, with names near it, or no such output.
        """
        snapshot = self.snapshot(time, index=index)
        if name in snapshot.point_fields:
            return snapshot.point_fields[name].copy()
        require_field(snapshot, name)
        return field_values(snapshot, name, self.units)[0].copy()

    def surfaces(
        self, time: float | None = None, *, index: int | None = None
    ) -> dict[str, SurfaceShape]:
        """Returns the tracked surfaces by name; their arrays must not be changed.

        Each has ``position``, ``cells`` (segments or triangles) and ``fields`` (normals, in 2D
        the arc length).
        """
        return {each.name: each for each in self.snapshot(time, index=index).surfaces}

    def to_pyvista(self, time: float | None = None, *, index: int | None = None) -> Any:
        """Returns one output as a ``pyvista.MultiBlock``.

        Its blocks are ``points`` and ``grid``, and ``surfaces`` and ``rigid_bodies``, which have a
        block for each by name. Raises ``BadInput`` if PyVista is not installed.
        """
        return blocks_of(self.snapshot(time, index=index))

    def plot(
        self,
        field: str,
        time: float | None = None,
        *,
        show: Literal["field", "points", "domains"] = "field",
        section: str | None = None,
        values: tuple[float, float] | None = None,
    ) -> Figure:
        """Returns the figure of a field over the deformed soil, as ``tilth plot`` draws it.

        Arguments and errors as of ``tilth.plot.field.field_figure``.
        """
        from tilth.plot.field import field_figure

        return field_figure(
            self.folder, field, time=time, show=show, section=section, values=values
        )

    def plot_history(self, x: str, y: str) -> Figure:
        """Returns the figure of column ``y`` over column ``x`` of the history.

        Raises ``BadInput`` if there is no such column.
        """
        from tilth.plot.curves import curve_figure

        return curve_figure(self.folder, x, y)

    def export(
        self,
        to: Format,
        out: Path | str | None = None,
        *,
        times: Times = None,
        fields: Sequence[str] | None = None,
        show: Show = "domains",
    ) -> list[Path]:
        """Writes files for other programs, as ``tilth export``; returns them.

        Arguments and errors as of ``tilth.export.run.export_run``.
        """
        from tilth.export.run import export_run

        return export_run(self.folder, to, out, times=times, fields=fields, show=show)

    def __repr__(self) -> str:
        facts = ", ".join(value for key, value in self._facts() if key != "folder")
        return f"<RunResults: {facts}, in {self.folder}>"

    def _repr_html_(self) -> str:
        return html_table({**dict(self._facts()), "fields": ", ".join(self.fields)})

    def _facts(self) -> list[tuple[str, str]]:
        """Returns what is shown of the run, by headings, without reading an output."""
        times, unit = self._results.times, self.units.get("time", "")
        span = f"time {times[0]:.6g} to {times[-1]:.6g}"
        count = f"{len(times)} output{'' if len(times) == 1 else 's'}"
        facts = [("title", repr(self.title)), ("folder", str(self.folder))]
        return [*facts, ("outputs", f"{count}, {span} {unit}".rstrip())]

    def _number(self, time: float | None, index: int | None) -> int:
        """Returns the number of an output, from 0; raises ``BadInput`` if there is none."""
        if time is not None and index is not None:
            raise BadInput("both time and index are given", "give one of them", key="index")
        if index is None:
            return output_at(self._results, time)
        count = len(self._results)
        if not -count <= index < count:
            remedy = f"give a number from 0 to {count - 1}, or a time"
            raise BadInput("is not the number of an output", remedy, key="index", value=index)
        return range(count)[index]
