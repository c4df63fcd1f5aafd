# SPDX-License-Identifier: BSD-3-Clause
"""Runs of the command on several processes: files, resume, errors, stops, the same bits again."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpi_runs import ENVIRONMENT, LIMIT, PYTHON, require_processes
from readings import long
from small_problems import block_entries, material_entries, rollers, weight

from tilth.output import read_history
from tilth.output.vtkhdf import read_results

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def processes_can_run() -> None:
    require_processes()


def case(folder: Path, solver: str = "auto", **changed: Any) -> Path:
    """A file with clay under its weight beside an oblique boundary, which yields and is pressed."""
    entries = block_entries("plane_strain", "gimp", boundaries=rollers("plane_strain", 6.0))
    entries["bodies"][0]["shape"]["upper"] = [6.0, 4.0]
    entries["materials"]["soil"] = material_entries("von_mises")
    entries["loads"] = [weight("plane_strain", 4.0)]
    entries["schedule"] = {"steps": 6}
    entries["analysis"]["solver"] = solver
    entries["output"] = {"checkpoint_every": 1}
    entries["track"] = [
        {"name": "base", "quantity": "reaction", "boundary": entries["boundaries"][1]["name"],
         "component": "y"},
        {"name": "top", "quantity": "displacement", "at": [3.0, 4.0], "component": "y"},
        {"name": "height", "quantity": "top_height", "of": "domains"},
        {"name": "elastic", "quantity": "energy", "kind": "elastic"},
        {"name": "work", "quantity": "energy", "kind": "external_work"},
    ]  # fmt: skip
    entries = {"format": 1, **entries, **changed}
    file = folder / "case.toml"
    file.write_text("\n".join(f"{key} = {inline(value)}" for key, value in entries.items()))
    return file


def inline(value: Any) -> str:
    """A value as TOML writes it, on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {inline(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(inline(each) for each in value) + "]"
    return json.dumps(value)


def started(processes: int, *arguments: str | Path) -> subprocess.Popen[str]:
    """The command `tilth ARGUMENTS` on some processes."""
    launcher = ["mpiexec", "-n", str(processes)] if processes > 1 else []
    return subprocess.Popen(
        [*launcher, PYTHON, "-m", "tilth", *map(str, arguments)], env={**os.environ, **ENVIRONMENT},
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def done(processes: int, *arguments: str | Path, code: int = 0) -> str:
    with started(processes, *arguments) as process:
        out, errors = process.communicate(timeout=LIMIT)
    assert process.returncode == code, out + errors
    return errors


def assert_same_run(one: Path, other: Path, share: float = 1e-9) -> None:
    """Asserts that the histories and the last outputs of two runs are the same."""
    first, second = read_history(one / "history.csv"), read_history(other / "history.csv")
    assert first.keys() == second.keys()
    for name, column in first.items():
        largest = np.abs(column).max()
        assert np.abs(column - second[name]).max() <= share * largest, name
    before, after = (read_results(each / "results.vtkhdf") for each in (one, other))
    assert before.steps == after.steps
    a, b = before.snapshot(-1), after.snapshot(-1)
    assert np.array_equal(a.point_id, b.point_id)
    assert np.array_equal(a.cells, b.cells)
    for name in a.point_fields:
        largest = max(np.abs(a.point_fields[name]).max(), 1e-300)
        assert np.abs(a.point_fields[name] - b.point_fields[name]).max() <= share * largest, name
    for name in a.node_fields:
        largest = np.abs(a.node_fields[name]).max()
        difference = np.abs(a.node_fields[name] - b.node_fields[name]).max()
        assert difference <= 1e3 * share * largest, name


def test_files_are_those_of_a_serial_run_and_resume_on_any_number(tmp_path: Path) -> None:
    """Four processes stop half way; one and three go on to the serial run's end."""
    file = case(tmp_path)
    done(1, "run", file, "--out", tmp_path / "serial")
    done(4, "run", file, "--until", "0.5", "--out", tmp_path / "half")
    for processes in (1, 3):
        folder = tmp_path / f"on_{processes}"
        subprocess.run(["cp", "-r", tmp_path / "half", folder], check=True)
        done(processes, "resume", folder)
        assert_same_run(tmp_path / "serial", folder)
        assert (folder / "report.html").exists()
    log = (tmp_path / "on_3" / "log.txt").read_text()
    points = len(read_results(tmp_path / "serial" / "results.vtkhdf").snapshot(0).point_id)
    assert "processes:    4" in log
    assert log.count(f"of {points:,} points") == 6  # one line for each step, none lost or doubled
    assert len({line.split("mass")[1].split(",")[0] for line in log.splitlines() if "mass" in line})


def test_a_finished_run_goes_on_to_a_later_end(tmp_path: Path) -> None:
    """Two processes finish it at half the time, three go on; one process does all in one go."""
    loads = [{**weight("plane_strain", 4.0), "factor": [[0.0, 0.0], [1.0, 1.0]]}]
    schedule = {"step_size": 0.25, "output_every": 2}
    file = case(tmp_path, loads=loads, schedule={**schedule, "end": 0.5})
    folder = tmp_path / "out"
    done(2, "run", file, "--out", folder)
    case(tmp_path, loads=loads, schedule={**schedule, "end": 1.0})
    done(3, "run", file, "--continue", folder)
    done(1, "run", file, "--out", tmp_path / "serial")
    assert_same_run(tmp_path / "serial", folder)


def test_the_same_bits_from_run_to_run(tmp_path: Path) -> None:
    """With multigrid: PETSc's GAMG and MUMPS promise no order of their sums."""
    file = case(tmp_path, solver="multigrid")
    for name in ("one", "two"):
        done(3, "run", file, "--out", tmp_path / name)
    first, second = (tmp_path / name / "history.csv" for name in ("one", "two"))
    assert first.read_bytes() == second.read_bytes()
    one, two = (read_results(tmp_path / n / "results.vtkhdf") for n in ("one", "two"))
    assert one.outputs == two.outputs  # check sums


def test_one_message_and_exit_code_2(tmp_path: Path) -> None:
    """For a solver of one process, and for a folder in use."""
    file = case(tmp_path, solver="superlu")
    errors = done(2, "run", file, "--out", tmp_path / "out", code=2)
    assert errors.count("analysis.solver") == 1
    assert 'choose solver = "auto"' in errors
    assert not (tmp_path / "out").exists() or not any((tmp_path / "out").iterdir())


def test_a_killed_process_ends_all_within_seconds(tmp_path: Path) -> None:
    """Finished steps can be read, and the run goes on where its checkpoint is."""
    file = case(tmp_path, schedule={"steps": 400})
    folder = tmp_path / "out"
    with started(3, "run", file, "--out", folder) as process:
        wait_for(lambda: (folder / "checkpoint.npz").exists())
        children = subprocess.run(
            ["pgrep", "-P", str(process.pid)], capture_output=True, text=True, check=True
        ).stdout.split()
        os.kill(int(children[-1]), signal.SIGKILL)
        start = time.monotonic()
        _, errors = process.communicate(timeout=60.0)
        assert time.monotonic() - start < 20.0
    assert process.returncode != 0
    assert "killed" in errors.lower() or "signal 9" in errors.lower()
    assert len(read_history(folder / "history.csv")["step"]) > 1
    assert read_results(folder / "results.vtkhdf").steps[0] == 0


def test_a_request_to_stop_reaches_all(tmp_path: Path) -> None:
    """SIGTERM to one process ends all after an iteration, with a checkpoint to go on from."""
    file = case(tmp_path, schedule={"steps": 400})
    folder = tmp_path / "out"
    with started(2, "run", file, "--out", folder) as process:
        wait_for(lambda: (folder / "checkpoint.npz").exists())
        children = subprocess.run(
            ["pgrep", "-P", str(process.pid)], capture_output=True, text=True, check=True
        ).stdout.split()
        os.kill(int(children[-1]), signal.SIGTERM)
        process.communicate(timeout=60.0)
    assert process.returncode == 3
    assert "interrupted by SIGTERM" in (folder / "log.txt").read_text()


def test_factor_of_safety(tmp_path: Path) -> None:
    """Of a folder that another number of processes wrote; process 0 alone prints."""
    base = {"name": "base", "type": "plane", "axis": "y", "at": 0.0, "condition": "fixed"}
    file = case(tmp_path, boundaries=[base], track=[])
    done(1, "run", file, "--out", tmp_path / "out")
    found = []
    for processes in (1, 2):
        with started(processes, "safety", tmp_path / "out", "--tolerance", "0.5") as process:
            out, errors = process.communicate(timeout=LIMIT)
        assert process.returncode == 0, out + errors
        assert out.count("Factor of safety") == 1
        found.append(json.loads((tmp_path / "out" / "safety.json").read_text())["factor"])
    assert found[0] == found[1]


def wait_for(condition: Any) -> None:
    deadline = time.monotonic() + LIMIT
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.parametrize(
    ("processes", "problem"),
    [(2, "contact_patch"), long(2, "collapse"), long(4, "plane_strain_block")],
)
def test_reference_problems_are_within_their_tolerances(processes: int, problem: str) -> None:
    with started(processes, "verify", problem, "--json") as process:
        out, errors = process.communicate(timeout=2.0 * LIMIT)
    assert process.returncode == 0, errors
    rows = json.loads(out)
    assert rows
    assert all(row["passed"] for row in rows)


def test_too_many_processes(tmp_path: Path) -> None:
    file = case(tmp_path, grid={"cell_size": 6.0})
    errors = done(4, "run", file, "--out", tmp_path / "out", code=2)
    assert "there are too few cells with soil for 4 processes" in errors
