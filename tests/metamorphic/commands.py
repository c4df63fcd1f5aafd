# SPDX-License-Identifier: BSD-3-Clause
"""The commands of tilth on a model: their exit codes, and that they refuse the same."""

from __future__ import annotations

import contextlib
import io
import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from fuzz.toml_text import toml_text

from metamorphic.subject import Subject
from tilth.cli import run_command
from tilth.errors import EXIT_ANALYSIS_FAILED, EXIT_BAD_INPUT, EXIT_DONE

CODES = (EXIT_DONE, EXIT_ANALYSIS_FAILED, EXIT_BAD_INPUT)


def commands(subject: Subject) -> Iterator[str]:
    """Carries out `check` and `run`, then two of the others, in a folder of their own."""
    with tempfile.TemporaryDirectory(prefix="tilth-metamorphic-") as name:
        folder = Path(name)
        case, out = folder / "case.toml", folder / "out"
        case.write_text(toml_text({"format": 1, **subject.entries}), encoding="utf-8")
        code, text = _call("check", case, "--picture", folder / "setup.png")
        yield from _wrong("check", code, text, CODES)
        ran, text = _call("run", case, "--out", out, "--quiet", "--threads", "1")
        yield from _wrong("run", ran, text, CODES)
        if ran != subject.run.exit_code:
            yield f"run: exit code {ran}, but {subject.run.exit_code} in memory: {text[-300:]}"
        if (code == EXIT_BAD_INPUT) != (ran == EXIT_BAD_INPUT):
            yield f"check has exit code {code}, run {ran}: {text[-300:]}"
        if ran not in (EXIT_DONE, EXIT_ANALYSIS_FAILED) or not out.exists():
            return
        plot = ("plot", out, "--field", "displacement", "--save", folder / "plot.png")
        afterwards = (
            ("report", out),
            plot,
            ("export", out, "--to", "vtk", "--out", folder / "vtk"),
            ("export", out, "--to", "csv", "--out", folder / "csv"),
            ("safety", out, "--quiet", "--tolerance", "0.3"),
        )
        for words in subject.random.sample(afterwards, 2):
            allowed = CODES if words[0] == "safety" else (EXIT_DONE,)
            code, text = _call(*words)
            yield from _wrong(str(words[0]), code, text, allowed)
        shutil.rmtree(out)


def _call(*words: object) -> tuple[int, str]:
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = run_command([str(word) for word in words])
    return code, err.getvalue()


def _wrong(command: str, code: int, text: str, allowed: tuple[int, ...]) -> Iterator[str]:
    if code not in allowed:
        bug = ""
        if found := re.search(r"(/\S+\.txt)", text):
            bug = Path(found[1]).read_text(encoding="utf-8", errors="replace")[-600:]
        yield f"{command} has exit code {code}: {text[-300:]} {bug}"
    elif "Traceback" in text:
        yield f"{command}: traceback {text[-300:]}"
