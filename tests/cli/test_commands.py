# SPDX-License-Identifier: BSD-3-Clause
"""Version, help, and what the commands hand to the library; exit codes 0, 1, 3 and 4."""

import errno
import io
import subprocess
import sys
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from tilth import __version__
from tilth.analysis.memory import memory_of
from tilth.available_memory import AvailableMemory
from tilth.bodies.discretise import discretise
from tilth.case import load_case
from tilth.errors import AnalysisFailed, TilthError
from tilth.grid.background import background_grid
from tilth.output.folder import CHECKPOINT
from tilth.report.setup import Setup
from tilth.report.summary import print_summary

from .conftest import Outcome

Case = Callable[..., Path]
Tilth = Callable[..., Outcome]


@pytest.fixture
def analysis(monkeypatch: pytest.MonkeyPatch) -> types.ModuleType:
    """Stands in for `tilth.analysis.run`: records its calls, and raises what `fails` holds."""
    module: Any = types.ModuleType("tilth.analysis.run")
    module.calls = []
    module.fails = None

    def record(*arguments: Any, **options: Any) -> types.SimpleNamespace:
        module.calls.append((arguments, options))
        if module.fails is not None:
            raise module.fails
        return types.SimpleNamespace(finished=options["until"] is None, undecided={})

    module.run = module.resume = record
    monkeypatch.setitem(sys.modules, "tilth.analysis.run", module)
    monkeypatch.setattr("tilth.analysis.run", module, raising=False)
    return module


def test_version_loads_no_heavy_library() -> None:
    program = (
        "import sys; from tilth.cli import run_command; code = run_command(['--version']);"
        "print(code, [m for m in ('pydantic', 'numpy', 'rich', 'h5py') if m in sys.modules])"
    )
    process = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert process.stdout == f"tilth {__version__}\n0 []\n"


@pytest.mark.parametrize("command", ["run", "check", "resume", "report", "verify"])
def test_every_command_has_help(tilth: Tilth, command: str) -> None:
    assert f"  {command} " in tilth("--help").out
    outcome = tilth(command, "--help")
    assert outcome.code == 0
    assert f"Usage: tilth {command}" in outcome.out


def test_run_hands_the_model_on(tilth: Tilth, case: Case, analysis: Any) -> None:
    file = case()
    assert tilth("run", file) == Outcome(0, f"results in {file.with_suffix('')}\n", "")
    every_option = ("--out", "x", "--threads", "2", "--until", "0.5", "--overwrite", "--quiet")
    limit = ("--memory-limit", "64GB", "--explain", "dig:3")
    assert tilth("run", file, *every_option, *limit) == Outcome(0, "", "")
    ((model, folder), options), ((_, other), more) = analysis.calls
    assert model.title == "Column under its own weight"
    assert folder == file.with_suffix("")
    none = {"threads": None, "until": None, "memory_limit": None}
    assert options == none | {
        "overwrite": False,
        "from_stage": None,
        "continues": False,
        "quiet": False,
        "explain": None,
    }
    assert other == Path("x")
    given = {"threads": 2, "until": 0.5, "memory_limit": "64GB"}
    assert more == given | {
        "overwrite": True,
        "from_stage": None,
        "continues": False,
        "quiet": True,
        "explain": "dig:3",
    }


def test_resume_hands_the_folder_on(tilth: Tilth, tmp_path: Path, analysis: Any) -> None:
    given = ("--threads", "1", "--memory-limit", "1GB", "--explain", "12")
    assert tilth("resume", tmp_path, *given).code == 0
    options = {"threads": 1, "until": None, "memory_limit": "1GB", "quiet": False}
    assert analysis.calls == [((tmp_path,), options | {"explain": "12"})]


def test_a_run_that_stops_at_a_time_says_how_to_go_on(
    tilth: Tilth, case: Case, analysis: Any
) -> None:
    folder = case().with_suffix("")
    folder.mkdir()
    text = f"results in {folder}; continue with: tilth resume {folder}\n"
    for arguments in (["run", case()], ["resume", folder]):
        assert tilth(*arguments, "--until", "0.5") == Outcome(0, text, "")


def test_report_hands_the_folder_on(
    tilth: Tilth, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "tilth.analysis.setup_picture.write_report", lambda folder: folder / "report.html"
    )
    outcome = tilth("report", tmp_path)
    assert outcome == Outcome(0, f"report written to {tmp_path / 'report.html'}\n", "")


def test_report_of_a_folder_without_a_run_is_refused(tilth: Tilth, tmp_path: Path) -> None:
    outcome = tilth("report", tmp_path)
    assert outcome.code == 2
    assert "model.json cannot be read" in outcome.err


def test_an_analysis_that_fails_has_exit_code_1(tilth: Tilth, case: Case, analysis: Any) -> None:
    analysis.fails = AnalysisFailed("step 3 did not converge", "take smaller steps")
    outcome = tilth("run", case())
    assert outcome == Outcome(1, "", "step 3 did not converge\n  take smaller steps\n")


def test_an_interrupted_run_says_how_to_go_on(tilth: Tilth, case: Case, analysis: Any) -> None:
    analysis.fails = KeyboardInterrupt()
    folder = case().with_suffix("")
    outcome = tilth("run", case())
    assert outcome.code == 3
    assert "start the run again" in outcome.err
    folder.mkdir()
    (folder / CHECKPOINT).touch()
    for arguments in (["run", case()], ["resume", folder]):
        outcome = tilth(*arguments)
        assert outcome.code == 3
        assert outcome.err == f"interrupted; continue with: tilth resume {folder}\n"


def test_a_bug_is_reported_without_traceback(
    tilth: Tilth,
    case: Case,
    analysis: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    for bug in (ZeroDivisionError("division by zero"), TilthError("unforeseen")):
        analysis.fails = bug
        assert tilth("run", case()).code == 4
    analysis.fails = ZeroDivisionError("division by zero")
    outcome = tilth("run", case())
    assert "a bug in tilth: ZeroDivisionError: division by zero" in outcome.err
    assert "please report it at" in outcome.err
    assert "Traceback" not in outcome.err
    details = Path(outcome.err.split()[-1]).read_text(encoding="utf-8")
    assert "Traceback" in details
    assert __version__ in details


def summary_of(file: Path) -> str:
    """What `tilth check` prints of a case."""
    model = load_case(file)
    column = model.bodies[0]
    points = discretise(column, "plane_strain", background_grid(model))
    setup = Setup(
        title=model.title,
        dim=2,
        length_unit="m",
        position=points.position,
        half_lengths=points.half_length,
        body_id=np.zeros(len(points.position), dtype=np.int64),
        body_names=[column.name],
        cell_size=np.array(model.cell_size),
        origin=np.array(model.origin),
    )
    printed = io.StringIO()
    available = AvailableMemory(4e9, 8e9, "memory of the machine")
    print_summary(model, setup, memory_of(model), available, Console(file=printed, width=160))
    return printed.getvalue()


def test_check_prints_what_is_declared(case: Case) -> None:
    text = summary_of(case())
    # 1 m x 4 m in cells of 0.5 m with 2 x 2 points each
    assert "column: box of clay, 64 points, gimp basis, domains by right_stretch" in text
    assert "64 in 16 cells" in text
    assert "about 54, linear solver " in text  # 3 x 9 nodes
    assert "available: 4 GB (memory of the machine, 8 GB in all)" in text
    assert "yield stress 20000 Pa" in text
    assert "base: fixed on y = 0: ux = 0, uy = 0" in text
    assert "body force, acceleration [0, -9.81], factor 1 at the end" in text
    assert "2 steps to time 1, adaptive; 2 outputs" in text
    assert "top: displacement y at [0.5, 4]" in text


IMPLICIT = """[[boundaries]]
name = "foundation"
type = "implicit"
geometry = { type = "footing", centre = [0.5, 4], normal = [0, -2], width = 0.5 }
condition = "direction"
direction = [1, 1]
displacement = { y = -0.2 }
rotation = { angle = 3, centre = [0.5, 4] }
factor = [[0, 0], [1, 0.5]]

[[boundaries]]
name = "slope"
type = "implicit"
geometry = { type = "function", function = "shapes.py:slope" }
condition = "tangential"
delta = 0.002
form = "band"
motion = "shapes.py:slide"

[[loads]]
"""


def test_check_prints_implicit_boundaries(case: Case) -> None:
    file = case(("[[loads]]\n", IMPLICIT))
    file.with_name("shapes.py").touch()
    printed = " ".join(summary_of(file).split())
    assert (
        "foundation: implicit, constrained along [1, 1] on a footing (centre [0.5, 4], "
        "normal [0, -2], width 0.5), surface form, delta = 0.0005 m, "
        "turns by 3 degrees about [0.5, 4], uy = -0.2 m, factor 0.5 at the end"
    ) in printed
    assert (
        "slope: implicit, tangential on a function (shapes.py:slope), band form, "
        "delta = 0.002 m, moves by shapes.py:slide, factor 1 at the end"
    ) in printed


def test_check_prints_the_stress_at_the_start(case: Case) -> None:
    given = """[[initial.stress]]
type = "{}"
body = "column"
{}

"""
    at_rest = given.format("k0", "K0 = 0.5\nground = 4.0\nsurcharge = 3.0")
    printed = " ".join(summary_of(case(("[[loads]]\n", at_rest + "[[loads]]\n"))).split())
    assert "column: weight of the soil below y = 4 m, K0 0.5, surcharge 3 Pa" in printed
    assert "equilibrium with the loads and boundaries at time 0 is found before" in printed
    table = "vertical_pressure = { depth = [[0, 1], [9, 7]], surface = 4.0 }\nK0 = 0.6"
    printed = " ".join(
        summary_of(case(("[[loads]]\n", given.format("table", table) + "[[loads]]\n"))).split()
    )
    assert "column: vertical pressure by depth 1 to 7 Pa, K0 0.6" in printed
    stress = given.format("given", "stress = [-10.0, -20.0, -10.0, 0.0]")
    printed = " ".join(summary_of(case(("[[loads]]\n", stress + "[[loads]]\n"))).split())
    assert "column: stress [-10, -20, -10, 0] Pa" in printed


STAGES = """[[stages]]
name = "weight"
schedule = { steps = 2 }

[[stages]]
name = "dig"
schedule = { steps = 2 }
reset = ["plastic_strain"]

[[stages.excavate]]
body = "column"
shape = { type = "box", lower = [-1, 1], upper = [2, 4] }
"""


@pytest.mark.slow
def test_check_lists_and_draws_stages(tilth: Tilth, case: Case, tmp_path: Path) -> None:
    file = case(("[schedule]\nsteps = 2\n", STAGES))
    checked = tilth("check", file)
    assert checked.code == 0
    printed = " ".join(checked.out.split())
    assert "stage 1 weight: 2 steps from time 0 to 1, adaptive; 2 outputs" in printed
    assert "excavates a box of column resets plastic strain to 0" in printed
    assert "schedule" not in printed
    assert "64 in 16 cells" in printed
    assert (tmp_path / "column.setup.png").stat().st_size > 10_000
    ran = tilth("run", file, "--out", tmp_path / "results")
    assert ran.code == 0
    assert "stage 2/2 dig, step 4" in ran.err
    assert "<h2>Stages</h2>" in (tmp_path / "results" / "report.html").read_text()


def test_check_draws_the_set_up(tilth: Tilth, case: Case, tmp_path: Path) -> None:
    pytest.importorskip("tilth._core")
    file = case()
    drawn = tmp_path / "drawn.png"
    for arguments, picture in (
        (["check", file], file.with_suffix(".setup.png")),
        (["check", file, "--picture", drawn], drawn),
    ):
        outcome = tilth(*arguments)
        assert outcome.code == 0
        assert picture.read_bytes().startswith(b"\x89PNG")
        assert outcome.out.endswith(f"set-up drawn in {picture}\n")


def test_check_warns_of_what_is_probably_not_meant(tilth: Tilth, case: Case) -> None:
    pytest.importorskip("tilth._core")
    far = """[[boundaries]]
name = "far wall"
type = "implicit"
geometry = { type = "plane", point = [9, 0], normal = [-1, 0] }
condition = "roller"

"""
    outcome = tilth("check", case(("[[loads]]\n", far + "[[loads]]\n")))
    assert outcome.code == 0
    assert "warning: boundary 'far wall' is not in contact with soil" in outcome.err


@pytest.mark.parametrize("name", ["drawn", "drawn.xyz", "drawn.toml"])
def test_check_refuses_a_picture_of_another_kind(tilth: Tilth, case: Case, name: str) -> None:
    outcome = tilth("check", case(), "--picture", name)
    assert outcome.code == 2
    assert f"'{name}' does not end with .png, .pdf, .svg" in outcome.err


def test_check_says_where_the_picture_cannot_go(tilth: Tilth, case: Case, tmp_path: Path) -> None:
    pytest.importorskip("tilth._core")
    outcome = tilth("check", case(), "--picture", tmp_path / "none" / "drawn.png")
    assert outcome.code == 2
    assert "cannot be written" in outcome.err
    assert "--picture" in outcome.err


def test_a_bug_is_reported_where_no_file_can_be_written(
    tilth: Tilth, case: Case, analysis: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, "x")

    monkeypatch.setattr("tilth.cli.tempfile.NamedTemporaryFile", refuse)
    analysis.fails = ZeroDivisionError("division by zero")
    outcome = tilth("run", case())
    assert outcome.code == 4
    assert outcome.err.startswith("a bug in tilth: ZeroDivisionError: division by zero\n")
    assert "with the case file and this text:" in outcome.err


def test_a_full_disk_is_no_bug(tilth: Tilth, case: Case, analysis: Any) -> None:
    file = case()
    for error, text in (
        (OSError(errno.ENOSPC, "x"), "a file cannot be written: the disk is full\n"),
        (OSError(errno.EROFS, "x", "a/b"), "a/b cannot be written: the disk is read-only\n"),
    ):
        analysis.fails = error
        remedy = "  put this right, then start the command again\n"
        assert tilth("run", file) == Outcome(1, "", text + remedy)
    analysis.fails = OSError(errno.EBADF, "x")
    outcome = tilth("run", file)
    assert outcome.code == 4
    Path(outcome.err.split()[-1]).unlink()


@pytest.mark.slow
@pytest.mark.parametrize("unbuffered", [True, False])
def test_a_reader_that_ends_early_is_no_bug(case: Case, unbuffered: bool) -> None:
    """As in `tilth check CASE.toml | head -0`."""
    options = ["-u"] if unbuffered else []
    with subprocess.Popen(
        [sys.executable, *options, "-m", "tilth", "check", str(case())],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == ""
    assert process.returncode == 1
