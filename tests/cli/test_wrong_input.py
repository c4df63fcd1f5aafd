# SPDX-License-Identifier: BSD-3-Clause
"""A user's mistake: exit code 2 and one message with file, key, value and remedy."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from .conftest import CASE, Outcome

Case = Callable[..., Path]
Tilth = Callable[..., Outcome]

BASE = CASE[CASE.index("[[boundaries]]") : CASE.index("[[loads]]")]


def implicit(entries: str, geometry: str = "") -> tuple[str, str]:
    """Replaces the condition on the base by an implicit boundary."""
    plane = '{ type = "plane", point = [0, 0.1], normal = [0, 1] }'
    text = f"""[[boundaries]]
name = "wall"
type = "implicit"
geometry = {geometry or plane}
{entries}

"""
    return BASE, text


WRONG = {
    "missing key": (
        ("young_modulus = 1e6\n", ""),
        ["materials.clay.young_modulus: missing", "give `young_modulus`"],
    ),
    "misspelt key": (
        ("poisson_ratio", "poison_ratio"),
        ["materials.clay.poison_ratio = 0.3: unknown key", "did you mean `poisson_ratio`?"],
    ),
    "misspelt section": (
        ("[[track]]", "[[tracks]]"),
        ["tracks = ", "unknown key", "did you mean `track`?"],
    ),
    "missing section": (("[schedule]\nsteps = 2\n", ""), ["schedule: missing", "[schedule]"]),
    "vector too long": (
        ("acceleration = [0, -9.81]", "acceleration = [0, 0, -9.81]"),
        ["loads[0].acceleration = [0.0, 0.0, -9.81]", "must have 2 components, not 3", "x, y"],
    ),
    "vector too short": (
        ("at = [0.5, 4]", "at = [4]"),
        ["track[0].at = [4.0]", "must have 2 components, not 1"],
    ),
    "a rule for domains that have their own": (
        ('basis = "gimp"', 'basis = "cpdi2"\ndomain_update = "corners"'),
        [
            'bodies[0].domain_update = "corners"',
            "cpdi2's domains always move with the grid",
            "leave it out",
        ],
    ),
    "number as text": (
        ("density = 1800", 'density = "1800"'),
        ['materials.clay.density = "1800"', "must be a number", "without quotes"],
    ),
    "not a number": (
        ("density = 1800", "density = nan"),
        ["materials.clay.density = NaN", "must be a finite number"],
    ),
    "incompressible": (
        ("poisson_ratio = 0.3", "poisson_ratio = 0.5"),
        ["materials.clay.poisson_ratio = 0.5", "smaller than 0.5", "0.49"],
    ),
    "negative yield stress": (
        ("yield_stress = 2e4", "yield_stress = -2e4"),
        ["materials.clay.yield_stress = -20000.0", "must be greater than zero"],
    ),
    "two strengths": (
        ("yield_stress = 2e4", "yield_stress = 2e4\ndeviatoric_radius = 2e4"),
        ["materials.clay.deviatoric_radius", "exactly one of"],
    ),
    "negative density": (
        ("density = 1800", "density = -1800"),
        ["materials.clay.density = -1800", "must not be negative"],
    ),
    "no density under a body force": (
        ("density = 1800\n", ""),
        ["materials.clay.density: missing", "a body force acts on this material"],
    ),
    "unknown material": (
        ('material = "clay"', 'material = "cley"'),
        ['bodies[0].material = "cley"', "no material of this name", "did you mean `clay`?"],
    ),
    "unknown model": (
        ('"von_mises"', '"von_misses"'),
        ['materials.clay.model = "von_misses"', 'did you mean "von_mises"?'],
    ),
    "no model": (
        ('model = "von_mises"\n', ""),
        ["materials.clay.model: missing", '"hencky_elastic", "von_mises"'],
    ),
    "shape of another dimension": (
        (
            '{ type = "box", lower = [0, 0], upper = [1, 4] }',
            '{ type = "sphere", centre = [0, 0, 0], radius = 1 }',
        ),
        ['bodies[0].shape.type = "sphere"', "plane_strain", '"box", "polygon", "circle"'],
    ),
    "two ways to divide a body": (
        ("points_per_cell = 2", "points_per_cell = 2\nspacing = 0.1"),
        ["bodies[0].spacing", "exactly one of `points_per_cell`, `points` and `spacing`"],
    ),
    "body outside the limits": (
        ("upper = [2, 5]", "upper = [2, 3]"),
        ["bodies[0].shape", "outside the grid limits", "y = 0 to 4", "0 to 3", "`grid.limits`"],
    ),
    "no condition": (
        (BASE, ""),
        ["boundaries: there is no boundary condition at all", "singular", "[[boundaries]]"],
    ),
    "a direction that nothing holds": (
        ('condition = "fixed"', 'condition = "roller"'),
        ["boundaries: no condition constrains the x direction", "singular", "roller"],
    ),
    "condition off the grid lines": (
        ("at = 0\n", "at = 0.2\n"),
        ["boundaries[0].at = 0.2", "not on a grid line", "y = 0 and 0.5"],
    ),
    "load factors not increasing": (
        ("[[0, 0], [1, 1]]", "[[0, 0], [0.5, 1], [0.5, 2]]"),
        ["loads[0].factor = [[0, 0], [0.5, 1], [0.5, 2]]", "must increase", "sort the rows"],
    ),
    "load factors that start late": (
        ("[[0, 0], [1, 1]]", "[[0.1, 0], [1, 1]]"),
        ["loads[0].factor", "the first time must be 0"],
    ),
    "steps as a decimal number": (
        ("steps = 2", "steps = 2.0"),
        ["schedule.steps = 2.0", "whole number", "without a decimal point"],
    ),
    "another format": (("format = 1", "format = 2"), ["format = 2", "reads format 1 only"]),
    "no format": (("format = 1\n", ""), ["format: missing", "format = 1"]),
    "not TOML": (
        ("cell_size = 0.5", "cell_size = 0.5.0"),
        ["is not valid TOML", "line 8"],
    ),
    "mesh that is not there": (
        ('{ type = "box", lower = [0, 0], upper = [1, 4] }', '{ type = "mesh", file = "a.msh" }'),
        ['bodies[0].shape.file = "a.msh"', "no such file", "relative to the case file"],
    ),
    "an implicit boundary without geometry": (
        (
            """type = "plane"
axis = "y"
at = 0
""",
            'type = "implicit"\n',
        ),
        ["boundaries[0].geometry: missing", "give `geometry`: Its position at time 0"],
    ),
    "a normal of no length": (
        implicit('condition = "fixed"', '{ type = "plane", point = [0, 0], normal = [0, 0] }'),
        ["boundaries[0].geometry.normal = [0, 0]", "must not be the zero vector", "[0, 1]"],
    ),
    "geometry of another dimension": (
        implicit(
            'condition = "fixed"',
            '{ type = "sphere", centre = [0, 0, 0], radius = 1, soil = "inside" }',
        ),
        ['boundaries[0].geometry.type = "sphere"', "plane_strain", '"circle", "polyline"'],
    ),
    "a polyline that crosses itself": (
        implicit(
            'condition = "fixed"',
            '{ type = "polyline", vertices = [[0, 0], [2, 0], [1, 1], [1, -1]], soil = "left" }',
        ),
        ["boundaries[0].geometry.vertices", "intersect each other", "in order along"],
    ),
    "delta of zero": (
        implicit('condition = "fixed"\ndelta = 0'),
        ["boundaries[0].delta = 0.0", "greater than 0 and at most 0.25", "for a thousandth"],
    ),
    "delta above half a cell": (
        implicit('condition = "fixed"\ndelta = 0.3'),
        ["boundaries[0].delta = 0.3", "greater than 0 and at most 0.25", "0.0005"],
    ),
    "a condition along no direction": (
        implicit('condition = "direction"'),
        ["boundaries[0].direction: missing", "such as direction = [1, 1]"],
    ),
    "a factor without a motion": (
        implicit('condition = "fixed"\nfactor = [[0, 0], [1, 1]]'),
        ["boundaries[0].factor", "nothing to scale", "`displacement`, `rotation`"],
    ),
    "a motion that names no file": (
        implicit('condition = "fixed"\nmotion = "lift"'),
        ["boundaries[0].motion", "does not name a function", "shape.py:distance"],
    ),
    "a radius that vanishes": (
        implicit(
            'condition = "fixed"\nradius_change = -2',
            '{ type = "circle", centre = [0, 0], radius = 1, soil = "inside" }',
        ),
        ["boundaries[0].radius_change = -2.0", "the radius 1 becomes -1 at factor 1"],
    ),
    "a volume loss in percent": (
        implicit(
            'condition = "fixed"\nvolume_loss = 2',
            '{ type = "circle", centre = [0, 0], radius = 1, soil = "inside" }',
        ),
        ["boundaries[0].volume_loss = 2", "must be between 0 and 1", "0.02 is a share of 2 %"],
    ),
    "an earthquake without gravity": (
        (
            'type = "body_force"\nacceleration = [0, -9.81]',
            'type = "seismic"\ncoefficient = [1, 0]',
        ),
        ['loads[0].type = "seismic"', "a part of gravity", 'type = "body_force"'],
    ),
    "a point force in the air": (
        (
            'type = "body_force"\nacceleration = [0, -9.81]',
            'type = "point_force"\nbody = "column"\nat = [9, 9]\nforce = [1, 0]',
        ),
        ["loads[0].at = [9.0, 9.0]", "no soil is within a cell", "move it to the soil"],
    ),
    "a line force in the plane": (
        (
            'type = "body_force"\nacceleration = [0, -9.81]',
            'type = "line_force"\nbody = "column"\nstart = [0, 1]\nend = [1, 1]\nforce = [1, 0]',
        ),
        ['loads[0].type = "line_force"', "is for 3D", "point_force"],
    ),
    "a surface that is not there": (
        implicit('condition = "fixed"', '{ type = "stl", file = "a.stl", soil = "inside" }'),
        ['boundaries[0].geometry.file = "a.stl"', "no such file", "relative to the case file"],
    ),
    "a distance function that is not there": (
        implicit('condition = "fixed"', '{ type = "function", function = "a.py:distance" }'),
        ['boundaries[0].geometry.function = "a.py:distance"', "no such file", "a.py"],
    ),
    "a motion that is not there": (
        implicit('condition = "fixed"\nmotion = "a.py:lift"'),
        ['boundaries[0].motion = "a.py:lift"', "no such file", "relative to the case file"],
    ),
    "penetration of a grid line": (
        (
            'quantity = "displacement"\nat = [0.5, 4]\ncomponent = "y"',
            'quantity = "penetration"\nboundary = "base"',
        ),
        ['track[0].boundary = "base"', "is for implicit boundaries", "has no implicit boundary"],
    ),
    "moment in the plane": (
        (
            'quantity = "displacement"\nat = [0.5, 4]\ncomponent = "y"',
            'quantity = "moment"\nboundary = "base"\nabout = [0, 0]\ncomponent = "x"',
        ),
        ['track[0].component = "x"', "moments about z only", 'component = "z"'],
    ),
}


def refused(outcome: Outcome, file: str, parts: list[str]) -> None:
    """Asserts exit code 2 and one message that starts with the file and holds all `parts`.

    Besides, only the Python functions that the case file names are announced.
    """
    assert outcome.code == 2
    announced = "runs the Python function "
    assert all(line.startswith(announced) for line in outcome.out.splitlines())
    assert outcome.err.startswith(f"{file}: ")
    for part in parts:
        assert part in outcome.err
    assert "Traceback" not in outcome.err
    assert outcome.err.count(file) == 1
    assert len(outcome.err.splitlines()) <= 3


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize("name", WRONG)
def test_wrong_entry(tilth: Tilth, case: Case, command: str, name: str) -> None:
    replaced, parts = WRONG[name]
    file = case(replaced)
    refused(tilth(command, file), str(file), parts)
    assert sorted(file.parent.iterdir()) == [file]


def test_several_wrong_entries_come_in_one_message(tilth: Tilth, case: Case) -> None:
    file = case(("poisson_ratio = 0.3", "poisson_ratio = 0.5"), ("steps = 2", "steps = 0"))
    outcome = tilth("check", file)
    assert outcome.code == 2
    assert outcome.err.startswith(f"{file}: 2 entries are wrong\n")
    assert "materials.clay.poisson_ratio = 0.5" in outcome.err
    assert "schedule.steps = 0: must be at least 1" in outcome.err


def test_missing_file_names_the_case_files_nearby(tilth: Tilth, case: Case) -> None:
    file = case()
    missing = file.with_name("colum.toml")
    refused(tilth("run", missing), str(missing), ["there is no such file", "column.toml"])


def test_a_folder_is_not_a_case_file(tilth: Tilth, case: Case) -> None:
    folder = case().parent
    refused(tilth("run", folder), str(folder), ["is a folder", "case files in it: column.toml"])


def test_a_file_that_is_not_text(tilth: Tilth, tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_bytes(b"format = 1\n\xff\xfe")
    refused(tilth("check", file), str(file), ["not a text file in UTF-8", "byte 11 is 0xff"])


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root reads all files")
def test_a_file_without_permission(tilth: Tilth, case: Case) -> None:
    file = case()
    file.chmod(0)
    refused(tilth("check", file), str(file), ["cannot be read", "permissions"])


def test_commands_on_a_folder_that_is_not_there(tilth: Tilth, tmp_path: Path) -> None:
    for command in ("resume", "report"):
        refused(tilth(command, tmp_path / "none"), str(tmp_path / "none"), ["no such folder"])


def test_results_do_not_go_into_the_folder_of_the_case(tilth: Tilth, case: Case) -> None:
    file = case()
    outcome = tilth("run", file, "--out", file.parent, "--overwrite")
    assert outcome.code == 2
    assert "the folder of the case file itself" in outcome.err
    assert "--out" in outcome.err
    assert file.exists()


@pytest.mark.parametrize(
    "arguments", [["run"], ["frobnicate"], ["run", "a.toml", "--threads", "0"], ["check", "--typo"]]
)
def test_wrong_arguments(tilth: Tilth, arguments: list[str]) -> None:
    outcome = tilth(*arguments)
    assert outcome.code == 2
    assert "Usage: tilth" in outcome.err
    assert "Error: " in outcome.err


def test_the_process_ends_with_the_exit_code(case: Case) -> None:
    file = case(("poisson_ratio", "poison_ratio"))
    process = subprocess.run(
        [sys.executable, "-m", "tilth", "run", file], capture_output=True, text=True, check=False
    )
    refused(
        Outcome(process.returncode, process.stdout, process.stderr), str(file), ["did you mean"]
    )


def test_a_body_without_points(tilth: Tilth, case: Case) -> None:
    pytest.importorskip("tilth._core")
    file = case(
        (
            '{ type = "box", lower = [0, 0], upper = [1, 4] }',
            '{ type = "circle", centre = [0.5, 0.5], radius = 0.01 }',
        )
    )
    for command in ("check", "run"):
        refused(tilth(command, file), str(file), ["column", "point"])


def test_a_stop_outside_the_schedule(tilth: Tilth, case: Case) -> None:
    pytest.importorskip("tilth._core")
    file = case()
    for until in ("1.5", "0", "-1", "nan"):
        outcome = tilth("run", file, "--until", until)
        refused(outcome, str(file), ["until = ", "the schedule, which goes from 0 to 1", "above 0"])
    assert not file.with_suffix("").exists()
    outcome = tilth("run", file, "--until", "soon")
    assert outcome.code == 2
    assert "'--until': 'soon' is not a valid float" in outcome.err


def test_an_output_folder_that_is_not_empty(tilth: Tilth, case: Case) -> None:
    pytest.importorskip("tilth._core")
    file = case()
    folder = file.with_suffix("")
    folder.mkdir()
    (folder / "thesis.txt").write_text("precious", encoding="utf-8")
    outcome = tilth("run", file)
    assert outcome.code == 2
    assert "not empty" in outcome.err
    assert str(folder) in outcome.err
    assert "--overwrite" in outcome.err
    assert "Traceback" not in outcome.err
    assert [entry.name for entry in folder.iterdir()] == ["thesis.txt"]


FUNCTIONS = """
import numpy as np
def upside_down(x):
    return 0.1 - x[:, 1]
def nan(x):
    return np.full(len(x), np.nan)
def lift(x, factor):
    return np.full(x.shape, np.nan)
"""
SECOND = """condition = "fixed"
displacement = { y = 0.1 }

[[boundaries]]
name = "slab"
type = "implicit"
geometry = { type = "plane", point = [0, 0.1], normal = [0, 1] }
condition = "fixed\""""
HILL = '{ type = "function", function = "functions.py:NAME" }'

WRONG_FROM_THE_START = {
    "all soil behind a plane": (
        implicit('condition = "fixed"', '{ type = "plane", point = [0, 0.1], normal = [0, -1] }'),
        ["boundaries[0].geometry", "all material is behind", "'wall'", "turn the normal"],
    ),
    "a distance of the wrong sign": (
        implicit('condition = "fixed"', HILL.replace("NAME", "upside_down")),
        ["boundaries[0].geometry", "negative everywhere", "change the function's sign"],
    ),
    "a distance that is no number": (
        implicit('condition = "fixed"', HILL.replace("NAME", "nan")),
        ["boundaries[0].geometry", "`nan` in `functions.py` returned nan at"],
    ),
    "a motion that is no number": (
        implicit('condition = "fixed"\nmotion = "functions.py:lift"'),
        ["boundaries[0].motion", "`lift` in `functions.py` returned [nan nan] at"],
    ),
    "two motions of one place": (
        implicit(SECOND),
        ["boundaries[1]", "'wall' and 'slab' prescribe contradictory displacements", "same motion"],
    ),
    "one smooth wall": (
        implicit('condition = "roller"'),
        ["boundaries: ", "not constrained against translation along x", "singular"],
    ),
}


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize("name", WRONG_FROM_THE_START)
def test_implicit_boundaries_that_cannot_be_computed(
    tilth: Tilth, case: Case, command: str, name: str
) -> None:
    """What only the points and the first step show."""
    pytest.importorskip("tilth._core")
    replaced, parts = WRONG_FROM_THE_START[name]
    file = case(replaced)
    functions = file.with_name("functions.py")
    functions.write_text(FUNCTIONS, encoding="utf-8")
    refused(tilth(command, file), str(file), parts)
    assert sorted(file.parent.iterdir()) == sorted([file, functions])
