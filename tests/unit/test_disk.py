# SPDX-License-Identifier: BSD-3-Clause
"""Files that cannot be written, screens that are closed."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tilth.errors import AnalysisFailed
from tilth.output import HistoryWriter, RunLog
from tilth.output.disk import is_of_the_disk, writing
from tilth.output.files import write_durably
from tilth.output.folder import CHECKPOINT
from tilth.output.hdf5_file import KeptError, open_to_write
from tilth.output.screen import Screen

FULL = Path("/dev/full")
needs_full = pytest.mark.skipif(not FULL.exists(), reason="the system has no /dev/full")


def test_the_message_has_the_file_the_reason_and_how_to_go_on(tmp_path: Path) -> None:
    file = tmp_path / "history.csv"
    for number, reason in (
        (errno.ENOSPC, "the disk is full"),
        (errno.EDQUOT, "the quota of the disk is used up"),
        (errno.EROFS, "the disk is read-only"),
        (errno.EIO, "the disk reports an input or output error"),
    ):
        refusal = OSError(number, "x")
        assert is_of_the_disk(refusal)
        with pytest.raises(AnalysisFailed) as error, writing(file):
            raise refusal
        assert error.value.message == f"{file} cannot be written: {reason}"
        assert "--overwrite" in error.value.remedy
    (tmp_path / CHECKPOINT).touch()
    with pytest.raises(AnalysisFailed, match="continue with: tilth resume"), writing(file):
        raise OSError(errno.ENOSPC, "x")
    with pytest.raises(ValueError, match="not of the disk"), writing(file):
        raise ValueError("not of the disk")


@needs_full
def test_history_and_log_on_a_full_disk(tmp_path: Path) -> None:
    history = HistoryWriter(tmp_path / "history.csv", [])
    log = RunLog(tmp_path / "log.txt")
    for writer in (history, log):
        with FULL.open("w") as full:
            os.dup2(full.fileno(), writer._file.fileno())
    for attempt in (
        lambda: history.append(0, 0.0, 0, []), lambda: log.warning("x"),
        history.close, log.close,
    ):  # fmt: skip
        with pytest.raises(AnalysisFailed, match="the disk is full"):
            attempt()


def test_a_file_that_is_not_completed_is_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "report.html"
    write_durably(file, b"old")

    def refuse(*_: Any) -> None:
        raise OSError(errno.ENOSPC, "x")

    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(OSError, match="x"):
        write_durably(file, b"new")
    assert [name.name for name in tmp_path.iterdir()] == ["report.html"]
    assert file.read_bytes() == b"old"


# --- HDF5 -------------------------------------------------------------------------------------


def fill(file: Any, seed: int) -> None:
    """Many data sets that grow, so that HDF5 reads what it has written."""
    random = np.random.default_rng(seed)
    for number in range(20):
        name, rows = f"group/{number}", random.random((500, 3))
        if name not in file:
            file.create_dataset(name, data=rows, maxshape=(None, 3), chunks=(300, 3))
        else:
            file[name].resize(len(file[name]) + len(rows), axis=0)
            file[name][-len(rows) :] = rows


def contents(path: Path) -> dict[str, bytes]:
    with h5py.File(path) as file:
        return {name: file["group"][name][()].tobytes() for name in file["group"]}


def test_hdf5_writes_what_it_writes_by_itself(tmp_path: Path) -> None:
    for seed in range(3):
        with open_to_write(KeptError(tmp_path / "one")) as file:
            fill(file, seed)
        with h5py.File(tmp_path / "other", "a", libver=("earliest", "v110")) as file:
            fill(file, seed)
        assert contents(tmp_path / "one") == contents(tmp_path / "other")


class FullDisk(KeptError):
    """Writes fail after so many calls."""

    left = 0
    error: BaseException = OSError(errno.ENOSPC, "x")

    def write(self, content: Any) -> int:
        self.left -= 1
        if self.left < 0:
            self._keep(self.error)
        return super().write(content)


@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "x"), KeyboardInterrupt()])
@pytest.mark.parametrize("calls", [0, 1, 5, 20, 60])
def test_hdf5_on_a_full_disk_ends_in_the_first_error(
    calls: int, error: BaseException, tmp_path: Path
) -> None:
    """And closes the file: it can be removed and written again."""
    for again in range(2):
        if again:
            (tmp_path / "file").unlink()
        disk = FullDisk(tmp_path / "file")
        disk.left, disk.error = calls, error
        with pytest.raises(type(error)), open_to_write(disk) as file:
            for seed in range(3):
                fill(file, seed)
        assert disk.closed
        assert not file


def test_a_file_that_a_reader_has_open_is_not_written(tmp_path: Path) -> None:
    with open_to_write(KeptError(tmp_path / "file")) as file:
        fill(file, 0)
    with h5py.File(tmp_path / "file"), pytest.raises(OSError, match="unavailable"):
        KeptError(tmp_path / "file")
    KeptError(tmp_path / "file").close()


# --- screens ------------------------------------------------------------------------------------


def test_a_screen_that_is_closed_is_silent() -> None:
    read, written = os.pipe()
    with os.fdopen(written, "w") as stream:
        screen = Screen(stream)
        assert not screen.isatty()
        assert screen.write("seen\n") == 5
        screen.flush()
        assert os.read(read, 10) == b"seen\n"
        os.close(read)
        for _ in range(2):
            screen.write("not seen\n")
            screen.flush()
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
