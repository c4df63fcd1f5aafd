# SPDX-License-Identifier: BSD-3-Clause
"""Python functions that a case names: which commands run them, and that they say so."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tilth.case import load_case
from tilth.output.folder import MODEL, REPORT, SETUP

from .conftest import Outcome

pytest.importorskip("tilth._core")

PLATE = """[[boundaries]]
name = "plate"
type = "implicit"
geometry = { type = "plane", point = [0, 4], normal = [0, -1] }
condition = "roller"
motion = "moves.py:down"

[[loads]]
"""


@pytest.fixture
def moved(case: Callable[..., Path], tmp_path: Path) -> tuple[Path, Path]:
    """A case with a function whose file leaves a marker whenever it is run; the marker."""
    marker = tmp_path / "marker"
    (tmp_path / "moves.py").write_text(
        f"from pathlib import Path\n\nPath({str(marker)!r}).touch()\n\n\n"
        "def down(x, factor):\n    return 0 * x + [0, -0.01 * factor]\n"
    )
    file = case(("[[loads]]\n", PLATE), ("yield_stress = 2e4", "yield_stress = 2e5"))
    return file, marker


def ran(marker: Path) -> bool:
    """Whether the function's file was run since the last question."""
    found = marker.exists()
    marker.unlink(missing_ok=True)
    return found


@pytest.mark.slow
def test_who_runs_the_function_says_so_and_the_report_does_not(
    tilth: Callable[..., Outcome], moved: tuple[Path, Path], tmp_path: Path
) -> None:
    file, marker = moved
    said = f"runs the Python function down in {tmp_path / 'moves.py'}\n"
    load_case(file)
    assert not ran(marker)
    folder = tmp_path / "out"
    for arguments in (
        ["check", file],
        ["run", file, "--out", folder, "--until", "0.5"],
        ["resume", folder],
    ):
        outcome = tilth(*arguments)
        assert outcome.code == 0, outcome.err
        assert outcome.out.startswith(said)
        assert ran(marker)
    page = (folder / REPORT).read_text(encoding="utf-8")
    (tmp_path / "moves.py").unlink()
    outcome = tilth("report", folder)
    assert outcome == Outcome(0, f"report written to {folder / REPORT}\n", "")
    assert (folder / REPORT).read_text(encoding="utf-8") == page


@pytest.mark.slow
def test_a_folder_without_a_stored_set_up_gets_a_report_without_its_picture(
    tilth: Callable[..., Outcome], moved: tuple[Path, Path], tmp_path: Path
) -> None:
    file, marker = moved
    folder = tmp_path / "out"
    assert tilth("run", file, "--out", folder, "--until", "0.5", "--quiet").code == 0
    (folder / SETUP).unlink()
    ran(marker)
    assert tilth("report", folder).code == 0
    assert not ran(marker)
    assert "The set-up is not drawn" in (folder / REPORT).read_text(encoding="utf-8")
    assert "moves.py:down" in (folder / MODEL).read_text(encoding="utf-8")


def test_the_functions_of_a_model(moved: tuple[Path, Path], tmp_path: Path) -> None:
    file, _ = moved
    assert load_case(file).functions == (f"{tmp_path / 'moves.py'}:down",)
