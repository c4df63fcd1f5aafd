# SPDX-License-Identifier: BSD-3-Clause
"""Kills, stops and full disks: a run that is resumed ends in the bits of an undisturbed one."""

from __future__ import annotations

import contextlib
import os
import resource
import shutil
import signal
import time
from pathlib import Path

import pytest
from resumed_runs import assert_same_results, checkpoint_of
from unlucky_runs import (
    command,
    demanding,
    finish,
    hidden_files,
    moments,
    start,
    wait_for,
    write_case,
)

from tilth import Model
from tilth.output import read_log

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_case(demanding(), tmp_path_factory.mktemp("case") / "block.toml")


@pytest.fixture(scope="module")
def whole(case: Path) -> Path:
    """An undisturbed run."""
    folder = case.with_name("whole")
    code, text = command(["run", case, "--out", folder, "--quiet"], case.with_name("screen"))
    assert (code, text) == (0, "")
    return folder


@pytest.fixture(scope="module")
def seconds(case: Path, whole: Path) -> float:
    """How long a run takes, with the processes already warm."""
    begin = time.monotonic()
    command(["run", case, "--out", case.with_name("again"), "--quiet"], case.with_name("screen"))
    return time.monotonic() - begin


def resume_to_the_end(case: Path, folder: Path, whole: Path) -> None:
    """Resumes, or starts again where there is no checkpoint, and compares with the whole run."""
    screen = folder.with_name("screen")
    if checkpoint_of(folder).exists():
        arguments = ["resume", folder, "--quiet"]
    else:
        code, text = command(["resume", folder], screen)
        assert code == 2, text
        arguments = ["run", case, "--out", folder, "--overwrite", "--quiet"]
    assert command(arguments, screen) == (0, "")
    assert_same_results(whole, folder)
    assert hidden_files(folder) == []


@pytest.mark.parametrize("moment", moments(8, seed=1).tolist())
def test_killed(moment: float, case: Path, whole: Path, seconds: float, tmp_path: Path) -> None:
    kill_and_resume(moment * seconds, case, whole, tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("moment", moments(50, seed=2).tolist())
def test_killed_often(
    moment: float, case: Path, whole: Path, seconds: float, tmp_path: Path
) -> None:
    kill_and_resume(moment * seconds, case, whole, tmp_path)


def kill_and_resume(after: float, case: Path, whole: Path, place: Path) -> None:
    """Kills the run after so many seconds, and the resumed run once again."""
    folder, screen = place / "out", place / "screen"
    arguments = ["run", case, "--out", folder, "--quiet"]
    for delay in (after, 0.3 * after):
        process = start(arguments, screen)
        time.sleep(delay)
        process.kill()
        assert finish(process) in (-signal.SIGKILL, 0)
        if not checkpoint_of(folder).exists():
            break
        arguments = ["resume", folder, "--quiet"]
    folder.mkdir(exist_ok=True)
    resume_to_the_end(case, folder, whole)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_stopped_by_a_signal(number: int, case: Path, whole: Path, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    process = start(["run", case, "--out", folder], tmp_path / "screen")
    wait_for(checkpoint_of(folder), process)
    for _ in range(2 if number != signal.SIGINT else 1):  # a closed terminal sends two of them
        os.kill(process.pid or 0, number)
    assert finish(process) == 3
    last = (tmp_path / "screen").read_text().splitlines()[-1]
    assert last == f"interrupted; continue with: tilth resume {folder}"
    sender = "the user" if number == signal.SIGINT else signal.Signals(number).name
    assert f"interrupted by {sender} after step" in (folder / "log.txt").read_text()
    assert hidden_files(folder) == []
    resume_to_the_end(case, folder, whole)


@pytest.mark.parametrize("moment", moments(4, seed=3).tolist())
@pytest.mark.parametrize("name", ["check", "report", "verify"])
def test_other_commands_stop_in_one_line(
    name: str, moment: float, case: Path, whole: Path, tmp_path: Path
) -> None:
    folder = shutil.copytree(whole, tmp_path / "whole")  # on a fast machine the report is written
    arguments: dict[str, list[str | Path]] = {
        "check": [case, "--picture", tmp_path / "picture.png"],
        "report": [folder],
        "verify": ["self_weight_column"],
    }
    delay = 0.05 + 0.3 * moment
    while True:
        process = start([name, *arguments[name]], tmp_path / "screen")
        wait_for(tmp_path / "screen", process)
        time.sleep(delay)
        with contextlib.suppress(ProcessLookupError):
            os.kill(process.pid or 0, signal.SIGTERM)
        code = finish(process)
        if code != 0 or delay < 1e-3:
            break
        (tmp_path / "screen").unlink()
        delay /= 2.0  # a fast machine: the command had ended before the signal
    assert code == 3
    text = (tmp_path / "screen").read_text()
    assert text.splitlines()[-1] == "interrupted"
    assert "Traceback" not in text
    assert hidden_files(folder) == []


# --- full disks -------------------------------------------------------------------------------


def limit_files(size: int) -> None:
    """No file may become larger, which Python and HDF5 learn from the same call as of a full disk.

    The error is EFBIG in place of ENOSPC. Unlike a small file system it needs no rights.
    """
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def limits(whole: Path, count: int) -> list[int]:
    """Sizes that the files of a run pass one after the other."""
    largest = max(file.stat().st_size for file in whole.iterdir())
    return [int(largest * share**2) for share in sorted(moments(count, seed=4))]


@pytest.mark.parametrize("level", range(20))
def test_full_disk(level: int, case: Path, whole: Path, tmp_path: Path) -> None:
    folder, screen = tmp_path / "out", tmp_path / "screen"
    size = limits(whole, 20)[level]
    arguments: list[str | Path] = ["run", case, "--out", folder, "--quiet"]
    code, text = command(arguments, screen, limit_files, size)
    assert code == 1, text
    problem, remedy = text.splitlines()
    assert problem.startswith(str(folder))
    assert problem.endswith("cannot be written: the file would be larger than the system allows")
    assert ("tilth resume" if checkpoint_of(folder).exists() else "--overwrite") in remedy
    assert hidden_files(folder) == []
    resume_to_the_end(case, folder, whole)


def limit_report(size: int) -> None:
    """No file may become larger than so many bytes once the report begins."""
    from tilth.analysis import run

    write = run.write_report

    def limited(folder: Path) -> Path:
        limit_files(size)
        return write(folder)

    run.write_report = limited


def test_full_disk_before_the_report(tmp_path: Path) -> None:
    """The results are complete; the message says how to write the report."""
    model = Model.from_dict(demanding(2).to_dict() | {"output": {"report": True}})
    case, folder = write_case(model, tmp_path / "block.toml"), tmp_path / "out"
    arguments: list[str | Path] = ["run", case, "--out", folder, "--quiet"]
    code, text = command(arguments, tmp_path / "screen", limit_report, 10_000)
    assert code == 1, text
    assert text.startswith(f"the results are in {folder}, but not the report: ")
    assert text.endswith(f"write it again with: tilth report {folder}\n")
    assert read_log(folder / "log.txt").finished
    assert hidden_files(folder) == []
    written = f"report written to {folder / 'report.html'}\n"
    assert command(["report", folder], tmp_path / "screen") == (0, written)
