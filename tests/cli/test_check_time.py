# SPDX-License-Identifier: BSD-3-Clause
"""`tilth check` takes 10 s of processor time at most, whatever the case asks for."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import pytest

from .conftest import CASE, Outcome

Tilth = Callable[..., Outcome]

LONGEST = 10.0
"""[s] of processor time."""

GRAVITY = '[[initial.stress]]\ntype = "gravity"\nbody = "column"\nsteps = 1000000\n\n[schedule]'

SLOW = {
    "a key of 100,000 points": ("x" + ".x" * 100_000 + " = 1\n" + CASE, 2),
    "a section of 100,000 points": (CASE + "\n[x" + ".x" * 100_000 + "]\n", 2),
    "a key of 50,000 quoted parts": (CASE + "\n" + '"a.b".' * 50_000 + "x = 1\n", 2),
    "a text that does not end": ('x = "' + '\\"' * 200_000 + "\n" + "." * 200 + "\n" + CASE, 2),
    "a long text that does not end": ('x = """' + '""\\' * 100_000 + "." * 200 + "\n", 2),
    "36,000 keys of 50 parts": (
        "".join(f"k{i}{'.x' * 49} = 1\n" for i in range(36_000)) + CASE, 2,
    ),
    "one long word": ("x" * 400_000 + "\n" + "." * 200 + "\n" + CASE, 2),
    "30,000 unknown keys": ("".join(f"k{i} = 1\n" for i in range(30_000)) + CASE, 2),
    "30,000 unknown sections": (CASE + "".join(f"[q{i}]\n" for i in range(30_000)), 2),
    "gravity in a million parts": (
        CASE.replace("[[0, 0], [1, 1]]", "[[0, 1], [1, 1]]").replace("[schedule]", GRAVITY), 0,
    ),
    "a table of 100,000 rows": (
        CASE.replace("[[0, 0], [1, 1]]", f"{[[i, 1] for i in range(100_000)]}"), 0,
    ),
    "a million steps": (CASE.replace("steps = 2", "steps = 1000000"), 0),
    "1,000 points a cell and direction": (CASE.replace("cell = 2\n", "cell = 1000\n"), 2),
}  # fmt: skip


@pytest.mark.parametrize("what", SLOW)
def test_check_ends_in_time(what: str, tilth: Tilth, tmp_path: Path) -> None:
    text, code = SLOW[what]
    file = tmp_path / "case.toml"
    file.write_text(text, encoding="utf-8")
    start = time.process_time()
    done = tilth("check", file)
    assert time.process_time() - start < LONGEST
    assert done.code == code, done.err[:2000]
    if code == 2:
        assert done.err.startswith(f"{file}: ")
        assert len(done.err) < 10_000


def test_the_most_points_of_a_cell(tilth: Tilth, tmp_path: Path) -> None:
    """As many as are accepted are checked in time, too."""
    file = tmp_path / "case.toml"
    text = CASE.replace("cell_size = 0.5", "cell_size = 1.0").replace("cell = 2\n", "cell = 200\n")
    file.write_text(text, encoding="utf-8")
    start = time.process_time()
    done = tilth("check", file)
    assert done.code == 0, done
    assert time.process_time() - start < LONGEST


def test_what_says_that_equilibrium_was_not_waited_for(tilth: Tilth, tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(SLOW["gravity in a million parts"][0], encoding="utf-8")
    done = " ".join(tilth("check", file).out.split())
    assert "equilibrium before the first step takes more than 3 s to find" in done


MANY = "a." * 1001


@pytest.mark.parametrize(
    ("text", "refused"),
    [
        (f"# {MANY}\n", False),
        (f'title = "{"a." * 90}"\n', False),
        (f"title = '{'a.' * 90}'\n", False),
        (f"title = '''{'a.' * 90}'''\n", False),
        (f"{MANY}b = 1\n", True),
        (f"\n\n{MANY.replace('.', ' . ')}b = 1\n", True),
        (f'"#".{MANY}b = 1\n', True),
        ("".join(f"{'a.' * 50}b{i} = 1\n" for i in range(401)), True),
    ],
)
def test_only_keys_have_parts(text: str, refused: bool, tilth: Tilth, tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(CASE.replace('title = "Column under its own weight"\n', text), encoding="utf-8")
    done = tilth("check", file)
    assert done.code == (2 if refused else 0), done
    if refused:
        line = 4 if text.startswith("\n") else 2
        assert f"has keys of too many parts, the first one in about line {line}\n" in done.err
