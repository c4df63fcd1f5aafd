# SPDX-License-Identifier: BSD-3-Clause
"""The short form of the random tests, and the parts that they are made of."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from random import Random

import pytest

from fuzz.case_files import EXAMPLES, changed_case, tomllib
from fuzz.oracle import faults
from fuzz.sandbox import Job, run_jobs
from fuzz.toml_text import toml_text

pytest.importorskip("tilth._core")
pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs processes that are forked")


@pytest.mark.slow
@pytest.mark.parametrize("part", [("--checks", 50), ("--runs", 12), ("--folders", 12)])
def test_no_fault_is_found(part: tuple[str, int], tmp_path: Path) -> None:
    """In a process of its own, since forking needs one without threads."""
    options = [*map(str, part), "--patience", "5", "--keep", tmp_path]
    process = subprocess.run(
        [sys.executable, Path(__file__).parent, *options],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert process.returncode == 0, process.stdout + process.stderr


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*/*.toml")), ids=lambda f: f.stem)
def test_the_written_tree_is_the_tree_that_was_read(file: Path) -> None:
    tree = tomllib.loads(file.read_text(encoding="utf-8"))
    assert tomllib.loads(toml_text(tree)) == tree


def test_a_name_gives_the_same_changes_again() -> None:
    for number in range(30):
        name = f"check-7-{number}"
        assert changed_case("check", Random(name)) == changed_case("check", Random(name))


def _outcome_of(arguments: list[str], folder: Path, seconds: float = 5.0) -> list[str]:
    folder.mkdir()
    ((job, outcome),) = run_jobs([Job("probe", folder, arguments, seconds, lambda code: [])], 1)
    return faults(job, outcome)


def test_the_oracle_names_what_a_command_does_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tilth import cli

    def command(arguments: list[str]) -> int:
        kind = arguments[1]
        if kind == "crash":
            os.kill(os.getpid(), signal.SIGABRT)
        while kind == "hang":
            pass
        if kind == "memory":
            bytearray(100 * 2**30)
        if kind == "stray":
            Path("stray").touch()
            return 0
        sys.stderr.write({"two": "one\ntwo\n", "escape": "\x1b[31m: wrong\n"}.get(kind, "wrong\n"))
        return 4 if kind == "four" else 2

    monkeypatch.setattr(cli, "run_command", command)
    expected = {
        "good": "", "crash": "crash by SIGABRT", "hang": "too slow", "memory": "exit code 70",
        "two": "2 messages", "escape": "unprintable characters", "four": "bug: ",
        "stray": "file left outside the output folder: stray",
    }  # fmt: skip
    for kind, text in expected.items():
        found = _outcome_of(["check", kind], tmp_path / kind, seconds=1.0)
        assert len(found) == bool(text), (kind, found)
        assert not text or found[0].startswith(text)
