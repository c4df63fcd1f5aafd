# SPDX-License-Identifier: BSD-3-Clause
"""Checkpoints beside the run: their order, their errors, and what a kill leaves at any moment."""

from __future__ import annotations

import errno
import os
import shutil
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from resumed_runs import assert_same_results, entries_of
from small_problems import block_entries, rollers

import tilth.analysis.recorder
import tilth.output.checkpoint_thread
from tilth import Model, resume, run
from tilth.errors import AnalysisFailed
from tilth.output import CheckpointThread, read_checkpoint, write_checkpoint
from tilth.output.disk import writing
from tilth.output.folder import CHECKPOINT, HISTORY


@pytest.fixture(autouse=True)
def no_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tilth.output.checkpoint_thread, "PAUSE", 0.0)


@pytest.fixture(scope="module")
def model() -> Model:
    return Model.from_dict(entries_of())


@pytest.fixture(scope="module")
def uninterrupted(model: Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "whole"
    run(model, folder, quiet=True)
    return folder


def test_at_most_one_waits_and_it_is_the_last() -> None:
    thread, begun, go_on = CheckpointThread(), threading.Event(), threading.Event()
    written: list[int] = []

    def first() -> None:
        begun.set()
        assert go_on.wait(60.0)
        written.append(1)

    thread.write(first)
    assert begun.wait(60.0)
    for number in (2, 3):
        thread.write(lambda number=number: written.append(number))  # type: ignore[misc]
    assert written == []
    go_on.set()
    thread.wait()
    assert written == [1, 3]


@pytest.mark.parametrize("error", [AnalysisFailed("the disk is full"), MemoryError()])
def test_an_error_reaches_the_caller_once(error: Exception) -> None:
    thread, written = CheckpointThread(), []

    def fail() -> None:
        raise error

    thread.write(fail)
    with pytest.raises(type(error)) as raised:
        thread.wait()
    assert raised.value is error
    thread.wait()
    thread.write(lambda: written.append(1))
    thread.wait()
    assert written == [1]


def test_what_waits_is_not_written_after_an_error() -> None:
    thread, begun, go_on = CheckpointThread(), threading.Event(), threading.Event()
    written: list[int] = []

    def fail() -> None:
        begun.set()
        assert go_on.wait(60.0)
        raise AnalysisFailed("the disk is full")

    thread.write(fail)
    assert begun.wait(60.0)
    thread.write(lambda: written.append(1))
    go_on.set()
    with pytest.raises(AnalysisFailed):
        thread.wait()
    assert written == []


def test_the_end_of_a_run_does_not_wait_for_a_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tilth.output.checkpoint_thread, "PAUSE", 1e6)
    thread, written = CheckpointThread(), []
    for number in (1, 2):
        thread.write(lambda number=number: (time.sleep(0.01), written.append(number)))  # type: ignore[misc]
        thread.wait()
    assert written == [1, 2]


# --- in a run ---------------------------------------------------------------------------------


def replace_writer(monkeypatch: pytest.MonkeyPatch, before: Callable[[int, Path], None]) -> None:
    """Calls `before(number, folder)` before each checkpoint of a run is written."""
    count = 0

    def write(path: Path, arrays: Any, meta: Any) -> None:
        nonlocal count
        count += 1
        before(count, path.parent)
        write_checkpoint(path, arrays, meta)

    monkeypatch.setattr(tilth.analysis.recorder, "write_checkpoint", write)


def test_rows_are_on_the_disk_before_the_checkpoint_and_it_before_the_older_one_goes(
    model: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "out"
    history, checkpoint, new = (
        folder / HISTORY,
        folder / CHECKPOINT,
        folder / ".checkpoint.npz.new",
    )
    calls: list[str] = []
    rows, seen = 0, 0
    fsync, replace = os.fsync, os.replace

    def note_sync(descriptor: int) -> None:
        nonlocal rows
        status = os.fstat(descriptor)
        files = {"rows": history, "content": new, "names": folder}
        for what, file in files.items():
            if file.exists() and os.path.samestat(file.stat(), status):
                if what != "names" or calls[-1:] == ["replaced"]:
                    calls.append(what)
                if what == "rows":
                    rows = status.st_size
        fsync(descriptor)

    def note_replace(source: Path, target: Path) -> None:
        nonlocal seen
        replace(source, target)
        if target == checkpoint:
            seen += 1
            assert read_checkpoint(checkpoint)[1]["history"][0] <= rows
            calls.append("replaced")

    monkeypatch.setattr(os, "fsync", note_sync)
    monkeypatch.setattr(os, "replace", note_replace)
    run(model, folder, quiet=True)
    assert seen > 1
    assert calls == ["rows", "content", "replaced", "names"] * seen


@pytest.mark.slow
def test_a_kill_at_any_checkpoint_leaves_a_run_that_can_be_resumed(
    model: Model, uninterrupted: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where the run is steps ahead of the checkpoint: each second one waits for the next."""
    ahead = threading.Semaphore(0)

    def copy(number: int, folder: Path) -> None:
        if number % 2 == 0:
            assert ahead.acquire(timeout=60.0)
        if number > 1:  # there is an older one
            shutil.copytree(folder, tmp_path / f"{number}", ignore=shutil.ignore_patterns(".*"))

    record = tilth.analysis.recorder.Recorder.step

    def step(self: Any, *arguments: Any) -> None:
        record(self, *arguments)
        if self.analysis.clock.step % 3 == 0 or self.analysis.done:
            ahead.release()

    monkeypatch.setattr(tilth.analysis.recorder.Recorder, "step", step)
    with monkeypatch.context() as patch:
        replace_writer(patch, copy)
        run(model, tmp_path / "out", quiet=True)
    assert_same_results(uninterrupted, tmp_path / "out")
    copies = sorted(folder for folder in tmp_path.iterdir() if folder.name.isdecimal())
    assert len(copies) > 2
    for folder in copies:
        resume(folder, quiet=True)
        assert_same_results(uninterrupted, folder)


@pytest.mark.parametrize("number", [1, 2, 4])
def test_a_full_disk_is_said_as_of_any_file_and_the_run_goes_on_from_the_older_checkpoint(
    number: int, model: Model, uninterrupted: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "out"

    def refuse(count: int, folder: Path) -> None:
        if count == number:
            with writing(folder / CHECKPOINT):
                raise OSError(errno.ENOSPC, "x")

    with monkeypatch.context() as patch:
        replace_writer(patch, refuse)
        with pytest.raises(AnalysisFailed) as raised:
            run(model, folder, quiet=True)
    assert raised.value.message == f"{folder / CHECKPOINT} cannot be written: the disk is full"
    assert raised.value.message in (folder / "log.txt").read_text()
    if number == 1:
        assert "--overwrite" in raised.value.remedy
        return
    assert "tilth resume" in raised.value.remedy
    resume(folder, quiet=True)
    assert_same_results(uninterrupted, folder)


def test_a_failure_at_the_last_checkpoint_is_not_a_finished_run(
    model: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, record = tmp_path / "out", tilth.analysis.recorder.Recorder._write_checkpoint

    def refuse(self: Any, file: Path, arrays: Any, meta: Any) -> None:
        if meta["clock"]["time"] == model.schedule.end:
            raise AnalysisFailed("the disk is full")
        record(self, file, arrays, meta)

    monkeypatch.setattr(tilth.analysis.recorder.Recorder, "_write_checkpoint", refuse)
    with pytest.raises(AnalysisFailed, match="the disk is full"):
        run(model, folder, quiet=True)
    assert "stopped: the disk is full" in (folder / "log.txt").read_text()


@pytest.mark.parametrize("largest", [0, 10**9])
def test_large_states_are_not_copied(
    largest: int, model: Model, uninterrupted: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    threads = []
    monkeypatch.setattr(tilth.analysis.recorder, "LARGEST_COPY", largest)
    replace_writer(monkeypatch, lambda *_: threads.append(threading.current_thread().name))
    run(model, tmp_path / "out", quiet=True)
    assert ("checkpoint" in threads) == (largest > 0)
    assert_same_results(uninterrupted, tmp_path / "out")


@pytest.mark.parametrize("every", [2, 10])
def test_the_last_checkpoint_is_that_of_the_end(every: int, tmp_path: Path) -> None:
    """Also where the number of steps is no multiple of `checkpoint_every`."""
    entries = block_entries("plane_strain", "linear", cells=1, boundaries=rollers("plane_strain"))
    entries["schedule"] = {"steps": 3}
    entries["output"] = {"report": False, "checkpoint_every": every}
    run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    _, progress = read_checkpoint(tmp_path / "out" / CHECKPOINT)
    assert (progress["clock"]["step"], progress["clock"]["time"]) == (3, 1.0)
