# SPDX-License-Identifier: BSD-3-Clause
"""Runs in processes of their own, which may be killed or find no space on the disk."""

from __future__ import annotations

import json
import multiprocessing
import os
import time
from collections.abc import Callable
from multiprocessing.context import ForkServerProcess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from implicit_blocks import flat, gravity, implicit, model_of
from small_problems import material_entries

from tilth import Model
from tilth.cli import run_command

STEPS = 10
PROCESSES = multiprocessing.get_context("forkserver")
PROCESSES.set_forkserver_preload(
    [
        "tilth.analysis.run",
        "tilth.analysis.setup_picture",
        "tilth.report.html",
        "h5py",
        "unlucky_runs",
    ]
)

Prepare = Callable[..., None]


def demanding(steps: int = STEPS) -> Model:
    """A plastic block with F-bar, CPDI2 and a tracked surface that a platen presses on a base."""
    block = {"type": "box", "lower": [0.1, 0.13], "upper": [1.1, 1.13]}
    walls = [
        implicit("base", flat([0.0, 0.13], [0.0, 1.0])),
        implicit("platen", flat([0.6, 1.13], [0.0, -1.0]), displacement={"y": -0.2}),
        implicit("guide", flat([0.1, 0.0], [1.0, 0.0])),
    ]
    entries = model_of("plane_strain", "cpdi2", block, walls, steps, loads=[gravity(2)]).to_dict()
    entries["bodies"][0] |= {"anti_locking": "f_bar", "surface": {}}
    entries["materials"]["soil"] = material_entries("von_mises", yield_stress=25.0)
    entries["analysis"]["tolerance"] = 1e-9
    entries["schedule"] = {"steps": steps, "outputs": 5}
    entries["output"] = {"report": False}
    entries["track"] = [
        {"name": name, "quantity": "reaction", "boundary": name, "component": "y"}
        for name in ("base", "platen")
    ]
    return Model.from_dict(entries)


def write_case(model: Model, file: Path) -> Path:
    """Writes the case file of a model; returns its path."""

    def value(item: Any) -> str:
        if isinstance(item, dict):
            return "{" + ", ".join(f"{json.dumps(k)} = {value(v)}" for k, v in item.items()) + "}"
        if isinstance(item, list):
            return "[" + ", ".join(map(value, item)) + "]"
        return json.dumps(item)

    file.write_text("".join(f"{key} = {value(v)}\n" for key, v in model.to_dict().items()))
    return file


def start(
    arguments: list[str | Path], screen: Path, prepare: Prepare | None = None, *given: Any
) -> ForkServerProcess:
    """Starts `tilth ARGUMENTS` with one thread, after `prepare(*given)`; prints into `screen`."""
    words = [str(argument) for argument in arguments]
    process = PROCESSES.Process(target=_command, args=(words, screen, prepare, given))
    process.start()
    return process


def finish(process: ForkServerProcess, seconds: float = 300.0) -> int | None:
    """Waits for the process; returns its exit code."""
    process.join(seconds)
    if process.is_alive():
        process.kill()
        pytest.fail("the process does not end")
    return process.exitcode


def command(
    arguments: list[str | Path], screen: Path, prepare: Prepare | None = None, *given: Any
) -> tuple[int | None, str]:
    """Runs `tilth ARGUMENTS` as `start` does; returns the exit code and what it printed."""
    code = finish(start(arguments, screen, prepare, *given))
    return code, screen.read_text()


def wait_for(file: Path, process: ForkServerProcess) -> None:
    """Waits until a file exists."""
    while not file.exists():
        assert process.is_alive(), "the process has ended"
        time.sleep(0.001)


def hidden_files(folder: Path) -> list[str]:
    """Names of the files that only a run in progress has."""
    return sorted(
        file.name for file in folder.iterdir() if file.name[0] == "." or file.suffix == ".new"
    )


def moments(count: int, seed: int) -> np.ndarray:
    """Numbers in (0, 1), one in each of `count` equal parts, in a random order."""
    random = np.random.default_rng(seed)
    return random.permutation((np.arange(count) + random.random(count)) / count)


def _command(words: list[str], screen: Path, prepare: Prepare | None, given: Any) -> None:
    """In the new process."""
    from tilth import _core

    file = os.open(screen, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
    for number in (1, 2):
        os.dup2(file, number)
    if prepare is not None:
        prepare(*given)
    threads = ["--threads", "1"] if words[0] in ("run", "resume") else []
    _core.set_threads(1)
    os._exit(run_command([*words, *threads]))
