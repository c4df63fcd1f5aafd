# SPDX-License-Identifier: BSD-3-Clause
"""The completion scripts, and what bash completes with them."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from .conftest import Outcome

Tilth = Callable[..., Outcome]

BASH = """\
eval "$(tilth completion bash)"
COMP_WORDS=({words}) COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
_tilth_completion tilth
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


def completed(folder: Path, words: str) -> list[str]:
    """What bash offers for the last of the words."""
    command = folder / "tilth"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m tilth "$@"\n', encoding="utf-8")
    command.chmod(0o755)
    process = subprocess.run(
        ["bash", "--norc", "-c", BASH.format(words=words)],
        env=os.environ | {"PATH": f"{folder}:{os.environ['PATH']}"},
        capture_output=True, text=True, check=True, cwd=folder,
    )  # fmt: skip
    assert process.stderr == ""
    return process.stdout.split()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("tilth ch", ["check"]),
        ("tilth new foot", ["footing"]),
        ("tilth verify strip_", ["strip_footing", "strip_footing_friction"]),
        ("tilth run case.toml --ov", ["--overwrite"]),
        ("tilth completion f", ["fish"]),
    ],
)
def test_bash_completes(tmp_path: Path, words: str, offered: list[str]) -> None:
    assert completed(tmp_path, words) == offered


def test_bash_completes_files(tmp_path: Path) -> None:
    """click leaves files to bash, of which it asks so by an option of `complete`."""
    process = subprocess.run(
        [sys.executable, "-m", "tilth"],
        env=os.environ | {"_TILTH_COMPLETE": "bash_complete", "COMP_WORDS": "tilth run ca",
                          "COMP_CWORD": "2"},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert process.stdout == "file,ca\n"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_each_shell_has_a_script_that_calls_tilth(tilth: Tilth, shell: str) -> None:
    outcome = tilth("completion", shell)
    assert outcome.code == 0
    assert f"_TILTH_COMPLETE={shell}_complete" in outcome.out


def test_another_shell_is_refused(tilth: Tilth) -> None:
    outcome = tilth("completion", "tcsh")
    assert outcome.code == 2
    assert "'bash', 'zsh', 'fish'" in outcome.err
