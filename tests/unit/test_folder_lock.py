# SPDX-License-Identifier: BSD-3-Clause
"""One run at a time writes into a folder, and a killed one does not bar it."""

from __future__ import annotations

import errno
import fcntl
import os
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from small_problems import block_entries

from tilth import BadInput, Model, resume, run
from tilth.analysis.simulation import Simulation
from tilth.cli import run_command
from tilth.output.lock import LOCK, FolderLock, holder_of

HOLD = """
import sys
from tilth.output.lock import FolderLock
with FolderLock(sys.argv[1]):
    print("held", flush=True)
    sys.stdin.readline()
"""


def model_of(report: bool = False) -> Model:
    entries = block_entries("plane_strain", "linear", cells=1, schedule={"steps": 2})
    entries["output"] = {"report": report}
    return Model.from_dict(entries)


@pytest.fixture
def finished(tmp_path: Path) -> Path:
    run(model_of(), tmp_path / "out", quiet=True)
    return tmp_path / "out"


def contents(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir() if file.name != LOCK}


def held_by_a_process(folder: Path) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(folder)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    return process


@pytest.mark.slow
def test_a_second_process_is_refused_until_the_first_one_dies(
    finished: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It changes nothing, says who holds the folder, and a kill releases it."""
    before = contents(finished)
    process = held_by_a_process(finished)
    try:
        for second in (
            lambda: resume(finished, quiet=True),
            lambda: run(model_of(), finished, overwrite=True, quiet=True),
            lambda: run(model_of(), finished, quiet=True),
        ):
            with pytest.raises(BadInput, match=rf"in use by process {process.pid} on .*, since 20"):
                second()
        assert run_command(["resume", str(finished)]) == 2
        assert "-c" in capsys.readouterr().err  # the command of the holder
        assert contents(finished) == before
        holder = holder_of(finished)
        assert holder is not None
        assert holder.process == process.pid
        assert run_command(["report", str(finished)]) == 0
        assert "may replace the report at its end" in capsys.readouterr().out
    finally:
        process.kill()
        process.communicate()
    assert (finished / LOCK).exists()
    assert holder_of(finished) is None
    resume(finished, quiet=True)
    assert not (finished / LOCK).exists()
    assert run_command(["report", str(finished)]) == 0
    assert "replace" not in capsys.readouterr().out


def test_two_threads_of_one_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    advance = Simulation.advance
    inside, go_on = threading.Event(), threading.Event()

    def wait(self: Simulation, *arguments: Any) -> Any:
        inside.set()
        assert go_on.wait(60)
        return advance(self, *arguments)

    monkeypatch.setattr(Simulation, "advance", wait)
    with ThreadPoolExecutor() as pool:
        first = pool.submit(run, model_of(), tmp_path / "out", quiet=True)
        assert inside.wait(60)
        with pytest.raises(BadInput, match="in use by this process"):
            run(model_of(), tmp_path / "out", overwrite=True, quiet=True)
        with pytest.raises(BadInput, match="in use by this process"):
            resume(tmp_path / "out", quiet=True)
        go_on.set()
        assert first.result(60).finished
    assert not (tmp_path / "out" / LOCK).exists()


def test_the_lock_is_held_until_the_report_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []
    monkeypatch.setattr(
        "tilth.analysis.run.write_report", lambda folder: seen.append(holder_of(folder))
    )
    run(model_of(report=True), tmp_path / "out", quiet=True)
    (holder,) = seen
    assert holder is not None
    assert holder.process == os.getpid()


def test_only_one_of_many_holds_the_folder(tmp_path: Path) -> None:
    """Also while the file is deleted and made again all the time."""
    inside, entered, end = [0], [0], 200

    def take() -> None:
        while entered[0] < end:
            try:
                with FolderLock(tmp_path):
                    inside[0] += 1
                    assert inside[0] == 1
                    entered[0] += 1
                    inside[0] -= 1
            except BadInput:
                pass

    with ThreadPoolExecutor() as pool:
        for each in [pool.submit(take) for _ in range(4)]:
            each.result(120)
    assert list(tmp_path.iterdir()) == []


def test_a_deleted_lock_file_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The holder ends between the opening of its file and the lock on it."""
    before, flock, calls = FolderLock(tmp_path), fcntl.flock, []
    before.__enter__()

    def end_first(file: int, kind: int) -> None:
        if not calls:
            before.__exit__(None, None, None)
        calls.append(file)
        flock(file, kind)

    monkeypatch.setattr(fcntl, "flock", end_first)
    with FolderLock(tmp_path):
        assert len(calls) == 2
        with pytest.raises(BadInput, match="in use"), FolderLock(tmp_path):
            pass
    assert not (tmp_path / LOCK).exists()


def test_without_locks_the_run_warns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(file: int, kind: int) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", refuse)
    run(model_of(), tmp_path / "out", quiet=True)
    assert "cannot be locked on this file system" in (tmp_path / "out/log.txt").read_text()
    assert not (tmp_path / "out" / LOCK).exists()


def test_the_file_of_a_killed_run_does_not_make_a_folder_full(tmp_path: Path) -> None:
    (tmp_path / LOCK).write_text("{")
    assert run(model_of(), tmp_path, quiet=True).finished


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write everywhere")
def test_a_folder_that_cannot_be_written(finished: Path) -> None:
    finished.chmod(0o555)
    with pytest.raises(BadInput, match="cannot be written"):
        resume(finished)
    finished.chmod(0o755)


def test_resume_needs_a_folder(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="there is no such folder"):
        resume(tmp_path / "absent")
