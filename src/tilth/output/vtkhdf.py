# SPDX-License-Identifier: BSD-3-Clause
"""Writing and reading ``results.vtkhdf``, safe against a kill at any moment.

The visible file is never opened for writing. A hidden shadow file has one output less; an append
writes the missing and the new output to the shadow, waits for the disk and exchanges the names of
the two. So the visible file always contains every finished output, and each output is written
twice, independent of their number.
"""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tilth.errors import BadInput
from tilth.input_files import require_plain_files
from tilth.output.disk import reason_of, writing
from tilth.output.files import RESTORE, exchange_durably, replace_durably, temporary
from tilth.output.hdf5_file import KeptError, open_to_write
from tilth.output.snapshot import Snapshot
from tilth.output.vtkhdf_layout import (
    DamagedResults,
    append_snapshot,
    copy_last_snapshot,
    create_file,
    names_in,
    read_snapshot,
    stored_names,
    whole_column,
)

WAIT_FOR_WRITER = 5.0
"""How long reading waits for a program that writes an output [s]."""


class ResultsWriter:
    """Appends snapshots to a new temporal VTKHDF file.

    ``units`` are labels (keys ``length``, ``force``, ``stress``, ``mass``, ``time``); they and
    ``title`` are kept in the file for the report.
    """

    def __init__(self, path: Path | str, *, title: str = "", units: Mapping[str, str]) -> None:
        """Raises ``BadInput`` if there is a file at ``path``."""
        self.path = Path(path)
        self._shadow = temporary(self.path, "shadow")
        self._title = title
        self._units = dict(units)
        self._last: tuple[int, float] | None = None
        self.outputs: list[tuple[int, int]] = []
        """Step and check sum of each output in the file."""
        self._missing: int | None = 0
        """Number of outputs missing in the shadow, 0 or 1; None if the shadow cannot be used."""
        if self.path.exists():
            raise BadInput(
                f"{self.path} exists already", "resume that run or choose another folder"
            )
        self._remove_shadow()

    @classmethod
    def resume(cls, path: Path | str, last_step: int) -> ResultsWriter:
        """Continues the results at ``path``, after removing outputs after ``last_step``.

        Raises ``BadInput`` if they cannot be read, ``AnalysisFailed`` if they cannot be written;
        they are then as before.
        """
        path = Path(path)
        results = read_results(path)
        keep = sum(step <= last_step for step in results.steps)
        writer = cls.__new__(cls)
        writer.path, writer._shadow = path, temporary(path, "shadow")
        writer._title, writer._units = results.title, results.units
        writer._last = (results.steps[keep - 1], results.times[keep - 1]) if keep else None
        writer.outputs = results.outputs[:keep]
        writer._missing = None
        writer._remove_shadow()
        if keep == 0:
            path.unlink()
        elif keep < len(results.steps):
            with writer._changing_shadow():
                with open_to_write(KeptError(writer._shadow)) as file:
                    create_file(file, results.dim, results.title, results.units, results.names)
                    for index in range(keep):
                        append_snapshot(file, results.snapshot(index))
                replace_durably(writer._shadow, path)
        return writer

    def append(self, snapshot: Snapshot) -> None:
        """Writes one output; on return it is on the disk in the visible file.

        The steps must increase. Raises ``ValueError`` for a snapshot that does not fit the run, and
        ``AnalysisFailed`` if it cannot be written; the visible file is then as before.
        """
        if self._last is not None and not (
            snapshot.step > self._last[0] and snapshot.time >= self._last[1]
        ):
            raise ValueError(
                f"output of step {snapshot.step}, time {snapshot.time} after that of "
                f"step {self._last[0]}, time {self._last[1]}"
            )
        with self._changing_shadow():
            shadow, missing = self._open_shadow()
            with open_to_write(shadow) as file:
                if "tilth" not in file:
                    create_file(file, snapshot.dim, self._title, self._units, names_in(snapshot))
                if missing:
                    with _opened(self.path) as visible:
                        try:
                            copy_last_snapshot(visible, file)
                        except DamagedResults as error:
                            raise _damaged(self.path, error) from error
                checksum = append_snapshot(file, snapshot)
            exchange_durably(self._shadow, self.path)
        self.outputs.append((snapshot.step, checksum))
        self._missing = 1
        self._last = (snapshot.step, snapshot.time)

    def close(self) -> None:
        """Removes the hidden file; the results remain."""
        self._remove_shadow()
        self._missing = None

    @contextmanager
    def _changing_shadow(self) -> Iterator[None]:
        """Removes the shadow, and so frees its space, if it cannot be completed."""
        try:
            with writing(self.path):
                yield
        except BaseException:
            self.close()
            raise

    def _open_shadow(self) -> tuple[KeptError, int]:
        """Returns the open shadow and the number of missing outputs; a new copy if needed."""
        if self._missing is not None:
            try:
                return KeptError(self._shadow), self._missing
            except OSError:  # the earlier visible file is still open in another program
                pass
        self._remove_shadow()
        if self.path.exists():
            shutil.copyfile(self.path, self._shadow)
        return KeptError(self._shadow), 0

    def _remove_shadow(self) -> None:
        for hidden in (self._shadow, temporary(self.path, "old")):
            with suppress(OSError):  # a disk that became read-only; the results are complete
                hidden.unlink(missing_ok=True)


@dataclass(frozen=True)
class Results:
    """Contents of a results file; the outputs are read at access."""

    path: Path
    dim: int
    title: str
    units: dict[str, str]
    steps: list[int]
    """Step number of each output."""
    times: list[float]
    """Time of each output."""
    names: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """Names of the ``surfaces`` (tracked), ``contacts`` and ``rigid_bodies``, by these keys."""
    outputs: list[tuple[int, int]] = field(default_factory=list)
    """Step and check sum of each output."""

    @property
    def surfaces(self) -> tuple[str, ...]:
        """Names of the tracked surfaces."""
        return tuple(self.names.get("surfaces", ()))

    def snapshot(self, index: int) -> Snapshot:
        """Returns output number ``index`` (0 is the initial state, -1 the last), bit-exact.

        Raises ``BadInput`` if the file is damaged, for example if the output's check sum differs.
        """
        with _reading(self.path) as file:
            return read_snapshot(file, range(len(self.steps))[index])

    def __iter__(self) -> Iterator[Snapshot]:
        """Iterates over all outputs."""
        return (self.snapshot(index) for index in range(len(self.steps)))

    def __len__(self) -> int:
        """Number of outputs."""
        return len(self.steps)


def read_results(path: Path | str) -> Results:
    """Returns the contents of a results file; raises ``BadInput`` if it cannot be read."""
    path = Path(path)
    with _reading(path) as file:
        if "tilth" not in file or "VTKHDF" not in file:
            raise BadInput(f"{path} was not written by tilth", "name the folder of a tilth run")
        info = file["tilth"]
        steps = [int(step) for step in whole_column(info["step"])]
        times = [float(time) for time in whole_column(file["VTKHDF/points/Steps/Values"])]
        checksums = [int(checksum) for checksum in whole_column(info["checksum"])]
        results = Results(
            path=path,
            dim=int(info.attrs["dim"]),
            title=str(info.attrs["title"]),
            units={str(name): str(unit) for name, unit in json.loads(info.attrs["units"]).items()},
            steps=steps,
            times=times,
            names=stored_names(file),
            outputs=list(zip(steps, checksums, strict=True)),
        )
        if not 0 < len(steps) == len(times) or results.dim not in (2, 3):
            raise ValueError(f"{len(steps)} steps, {len(times)} times, {results.dim} directions")
        if not (np.diff(steps) > 0).all() or not (np.diff(times) >= 0).all():
            raise ValueError("the outputs are not in order")
        return results


def _opened(path: Path) -> Any:
    import h5py

    require_plain_files([path])
    deadline = time.monotonic() + WAIT_FOR_WRITER
    while True:
        try:
            return h5py.File(path, "r")
        except FileNotFoundError:
            raise BadInput(f"{path} does not exist", "name the folder of a tilth run") from None
        except BlockingIOError:  # a run locks its results while it writes an output
            if time.monotonic() > deadline:
                what = f"{path} is locked by a program that writes it"
                raise BadInput(what, "read it again when that program has ended") from None
            time.sleep(0.01)
        except OSError as error:
            what = f"{path} cannot be read as HDF5: {reason_of(error)}"
            raise BadInput(what, RESTORE) from error


def _damaged(path: Path, error: Exception) -> BadInput:
    return BadInput(f"{path} is damaged ({' '.join(str(error).split())})", RESTORE)


@contextmanager
def _reading(path: Path) -> Iterator[Any]:
    """Opens a results file only to read it; whatever is wrong with it becomes ``BadInput``."""
    with _opened(path) as file:
        try:
            yield file
        except BadInput:
            raise
        except Exception as error:  # HDF5 raises all kinds
            raise _damaged(path, error) from error
