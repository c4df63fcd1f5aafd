# SPDX-License-Identifier: BSD-3-Clause
"""The tutorial is true: its commands run one after the other and give the numbers of its tables."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

import pytest
from test_docs import ROOT, blocks

import tilth

TUTORIAL = ROOT / "docs" / "tutorial.md"
WIDTH_TIMES_STRENGTH = 2.0 * 20.0
"""Of the footing, 2 m x 20 kPa [kN/m]; the limit load is 2 + pi times as large (Prandtl)."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where all the shell blocks of the tutorial have been run."""
    folder = tmp_path_factory.mktemp("tutorial")
    command = folder / "bin" / "tilth"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m tilth "$@"\n', encoding="utf-8")
    command.chmod(0o755)
    environment = {**os.environ, "PATH": f"{command.parent}{os.pathsep}{os.environ['PATH']}"}
    for block in blocks(TUTORIAL, "sh"):
        subprocess.run(
            ["bash", "-e", "-c", block], cwd=folder, env=environment, check=True, timeout=500
        )
    return folder


@pytest.mark.slow
def test_the_case_file_is_the_one_shown(folder: Path, tmp_path: Path) -> None:
    (shown,) = blocks(TUTORIAL, "toml")
    case = tmp_path / "shown.toml"
    case.write_text(shown, encoding="utf-8")
    assert tilth.load_case(case).to_dict() == tilth.load_case(folder / "footing.toml").to_dict()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("run", "row"),
    [
        ("coarse", "| 0.5 | 2 | {load:.1f} | {ratio:.3f} | {error:.1f} % |"),
        ("footing", "| 0.25 | 4 | {load:.1f} | {ratio:.3f} | {error:.1f} % |"),
        ("footing", "| with F-bar | {load:.1f} | {ratio:.2f} | {error:.1f} % |"),
        ("locking", "| without | {load:.1f}, still rising | {ratio:.2f} | {error:.0f} % |"),
    ],
)
def test_the_tables_are_those_of_the_runs(folder: Path, run: str, row: str) -> None:
    load = float(tilth.open(folder / run).history["footing load [kN/m]"][-1])
    ratio = load / WIDTH_TIMES_STRENGTH
    error = 100.0 * (ratio / (2.0 + math.pi) - 1.0)
    expected = row.format(load=load, ratio=ratio, error=error)
    assert expected in TUTORIAL.read_text(encoding="utf-8"), expected
