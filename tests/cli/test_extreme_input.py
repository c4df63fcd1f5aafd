# SPDX-License-Identifier: BSD-3-Clause
"""Numbers near the limits of double precision, and sizes, schedules and nesting beyond reason.

Each is refused with exit code 2 and one message that names the key, without a warning of a library,
and before anything of the size that was asked for is made.
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import date
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tilth.errors import BadInput
from tilth.model import BodyForce, Grid, HenckyElastic, Model, Schedule

from .conftest import CASE, Outcome

Case = Callable[..., Path]
Tilth = Callable[..., Outcome]

BODY = '{ type = "box", lower = [0, 0], upper = [1, 4] }'
BASE = CASE[CASE.index("[[boundaries]]") : CASE.index("[[loads]]")]
LOAD = CASE[CASE.index("[[loads]]") : CASE.index("[schedule]")]
TRACK = 'quantity = "displacement"\nat = [0.5, 4]\ncomponent = "y"'
LIMITS = "limits = { lower = [-1, 0], upper = [2, 5] }\n"


def implicit(geometry: str, entries: str = "") -> tuple[str, str]:
    """Replaces the condition on the base by an implicit boundary."""
    text = '[[boundaries]]\nname = "wall"\ntype = "implicit"\ncondition = "fixed"\n'
    return BASE, f"{text}geometry = {geometry}\n{entries}\n"


def affine(matrix: str) -> tuple[str, str]:
    """Replaces the condition on the base by an affine motion."""
    text = '[[boundaries]]\nname = "motion"\ntype = "affine"\npath = "linear"\n'
    return BASE, f"{text}deformation_gradient = {matrix}\n"


def body(shape: str) -> tuple[str, str]:
    """Replaces the shape of the body."""
    return BODY, shape


def schedule(entries: str) -> tuple[str, str]:
    """Replaces the schedule's entries."""
    return "steps = 2", entries


POLYGON = "[[0, 0], [1, 0], " + ", ".join(f"[{1 - i / 2e4}, 1]" for i in range(11_000)) + "]"
BIG_INTEGER = "9" * 400
PLANE = '{ type = "plane", point = [0, 0.1], normal = [0, 1] }'

WRONG: dict[str, tuple[str, tuple[str, str]]] = {
    "a billion steps": ("schedule.steps", schedule("steps = 1000000000")),
    "steps of 400 digits": ("schedule.steps", schedule(f"steps = {BIG_INTEGER}")),
    "steps of 5000 digits": ("cannot be read", schedule(f"steps = {'9' * 5000}")),
    "steps of 20000 hexadecimal digits": ("schedule.steps", schedule(f"steps = 0x{'f' * 20000}")),
    "a step size near nothing": ("schedule.step_size", schedule("step_size = 1e-300")),
    "a step size far below the end": ("schedule.step_size", schedule("step_size = 1e-8")),
    "an end beyond numbers": ("schedule.end", schedule("steps = 2\nend = 1e300")),
    "a least step": ("schedule.minimum_step", schedule("steps = 2\nminimum_step = 1e-300")),
    "a least step of nothing": ("minimum_step", schedule("steps = 2\nminimum_step = 5e-324")),
    "a billion outputs": ("schedule.outputs", schedule("steps = 2\noutputs = 1000000000")),
    "outputs as 1e9": ("schedule.outputs", schedule("steps = 2\noutputs = 1e9")),
    "output of many steps": ("output_every", schedule("steps = 1000000\noutput_every = 1")),
    "outputs at one time but for round-off": (
        "schedule.output_times",
        schedule("steps = 2\noutput_times = [0.5, 0.5000000000000002]"),
    ),
    "an output near time 0": ("output_times", schedule("steps = 2\noutput_times = [5e-324, 1]")),
    "a date for the end": ("schedule.end", schedule("steps = 2\nend = 1979-05-27")),
    "infinity for the end": ("schedule.end", schedule("steps = 2\nend = inf")),
    "no number for the end": ("schedule.end", schedule("steps = 2\nend = nan")),
    "minus zero for the end": ("schedule.end", schedule("steps = 2\nend = -0.0")),
    "true for the end": ("schedule.end", schedule("steps = 2\nend = true")),
    "cells of nothing": ("grid.cell_size", ("cell_size = 0.5", "cell_size = 1e-300")),
    "cells smaller than the least": ("grid.cell_size", ("cell_size = 0.5", "cell_size = 5e-324")),
    "cells without bound": ("grid.cell_size", ("cell_size = 0.5", "cell_size = 1e300")),
    "cells of very different edges": (
        "grid.cell_size",
        ("cell_size = 0.5", "cell_size = [5e28, 0.5]"),
    ),
    "cells much smaller than the body": (
        "bodies[0].shape: x = 1 is 1e+09 cells from the origin of the grid",
        ("cell_size = 0.5", "cell_size = 1e-9"),
    ),
    "cells much larger than the body": (
        "bodies[0].shape = [1.0, 4.0]: is smaller than 1e-06 of a cell",
        ("cell_size = 0.5", "cell_size = 1e9"),
    ),
    "an origin beyond numbers": ("grid.origin", (LIMITS, "origin = [1e308, 0]")),
    "an origin that loses digits": ("round-off", (LIMITS, "origin = [1e12, 0]")),
    "an origin far from the body": ("cells from the origin", (LIMITS, "origin = [-1e8, 0]")),
    "limits beyond numbers": ("grid.limits.upper", ("upper = [2, 5]", "upper = [1e308, 5]")),
    "a body beyond numbers": (
        "bodies[0].shape.upper",
        body('{ type = "box", lower = [0, 0], upper = [1e308, 4] }'),
    ),
    "a body of nothing": (
        "bodies[0].shape = [1e-09, 4.0]: is smaller",
        body('{ type = "box", lower = [0, 0], upper = [1e-9, 4] }'),
    ),
    "a body far away": (
        "bodies[0].shape",
        body('{ type = "box", lower = [1e9, 0], upper = [1000000001, 4] }'),
    ),
    "an angle beyond numbers": (
        "bodies[0].shape.angle",
        body('{ type = "box", lower = [0, 0], upper = [1, 4], angle = 1e300 }'),
    ),
    "an angle of many turns": (
        "bodies[0].shape.angle",
        body('{ type = "box", lower = [0, 0], upper = [1, 4], angle = 1e20 }'),
    ),
    "a polygon of many vertices": (
        "bodies[0].shape.vertices",
        body(f'{{ type = "polygon", vertices = {POLYGON} }}'),
    ),
    "a polygon beyond numbers": (
        "bodies[0].shape.vertices",
        body('{ type = "polygon", vertices = [[0, 0], [1e308, 0], [0, 1e308]] }'),
    ),
    "a circle of nothing": (
        "bodies[0].shape.radius",
        body('{ type = "circle", centre = [0, 0], radius = 5e-324 }'),
    ),
    "a billion points per cell": (
        "points_per_cell",
        ("points_per_cell = 2", "points_per_cell = 1000000000"),
    ),
    "too many points per cell": ("points_per_cell", ("cell = 2\n", "cell = 2000\n")),
    "points per cell of 400 digits": ("points_per_cell", ("cell = 2\n", f"cell = {BIG_INTEGER}\n")),
    "points without number": (
        "points",
        ("points_per_cell = 2", "points = [1000000000, 1000000000]"),
    ),
    "a spacing of nothing": ("spacing", ("points_per_cell = 2", "spacing = 1e-300")),
    "a spacing far below a cell": ("spacing", ("points_per_cell = 2", "spacing = 1e-9")),
    "a spacing without bound": ("spacing", ("points_per_cell = 2", "spacing = 1e300")),
    "a surface spacing of nothing": (
        "surface.spacing",
        ("points_per_cell = 2", "points_per_cell = 2\nsurface = { spacing = 1e-20 }"),
    ),
    "a modulus beyond numbers": ("young_modulus", ("= 1e6", "= 1e300")),
    "a modulus of nothing": ("young_modulus", ("= 1e6", "= 5e-324")),
    "a strength of nothing": ("yield_stress", ("= 2e4", "= 1e-300")),
    "a density beyond numbers": ("density", ("density = 1800", "density = 1e300")),
    "a density of nothing": ("density", ("density = 1800", "density = 1e-300")),
    "gravity beyond numbers": ("acceleration", ("-9.81", "-1e308")),
    "a table beyond numbers": ("loads[0].factor", ("[1, 1]]", "[1, 1e308]]")),
    "a table with a time beyond numbers": ("loads[0].factor", ("[1, 1]]", "[1e308, 1]]")),
    "a track beyond numbers": ("track[0].at", ("at = [0.5, 4]", "at = [1e308, 4]")),
    "a scale beyond numbers": ("track[0].scale", ("[0.5, 4]", "[0.5, 4]\nscale = 1e308")),
    "a line beyond numbers": ("boundaries[0].at", ("at = 0\n", "at = 1e308\n")),
    "a line beyond the grid": ("boundaries[0].at", ("at = 0\n", "at = 1e9\n")),
    "a range beyond numbers": (
        "boundaries[0].range.x",
        ("at = 0\n", "at = 0\nrange = { x = [-1e308, 1e308] }\n"),
    ),
    "a motion beyond numbers": (
        "boundaries[0].deformation_gradient",
        affine("[[1e100, 0], [0, 1]]"),
    ),
    "a large matrix": (
        "2 x 2 or 3 x 3",
        affine(str([[float(i == j) for i in range(30)] for j in range(30)])),
    ),
    "a normal beyond numbers": (
        "geometry.normal",
        implicit('{ type = "plane", point = [0, 0], normal = [0, 1e308] }'),
    ),
    "a plane far away": (
        "boundaries[0].geometry.point",
        implicit('{ type = "plane", point = [0, -1e12], normal = [0, 1] }'),
    ),
    "a huge circle": (
        "geometry.radius",
        implicit('{ type = "circle", centre = [0, 0], radius = 1e20, soil = "inside" }'),
    ),
    "a tiny circle": (
        "geometry.radius",
        implicit('{ type = "circle", centre = [0.5, 0.5], radius = 1e-20, soil = "outside" }'),
    ),
    "a tiny box": (
        "boundaries[0].geometry = ",
        implicit('{ type = "box", lower = [0, 0], upper = [1e-9, 1], soil = "outside" }'),
    ),
    "a tiny footing": (
        "geometry.width",
        implicit('{ type = "footing", centre = [0.5, 4], normal = [0, -1], width = 1e-12 }'),
    ),
    "a spline of many points": (
        "geometry.vertices",
        implicit(f'{{ type = "spline", vertices = {POLYGON}, soil = "left" }}'),
    ),
    "a polyline of many points": (
        "geometry.vertices",
        implicit(f'{{ type = "polyline", vertices = {POLYGON}, soil = "left" }}'),
    ),
    "a long spline": (
        "boundaries[0].geometry: passes through about",
        implicit('{ type = "spline", vertices = [[0, 0], [1e5, 0], [1e5, 1]], soil = "left" }'),
    ),
    "a band beyond numbers": ("boundaries[0].delta", implicit(PLANE, "delta = 1e300")),
    "a band of nothing": ("boundaries[0].delta", implicit(PLANE, "delta = 5e-324")),
    "a translation without bound": (
        "boundaries[0].displacement",
        implicit(PLANE, "displacement = { y = 1e20 }"),
    ),
    "a rotation without bound": (
        "rotation.angle",
        implicit(PLANE, "rotation = { angle = 1e300, centre = [0, 0] }"),
    ),
    "a tolerance below round-off": (
        "analysis.tolerance",
        ('kind = "plane_strain"', 'kind = "plane_strain"\ntolerance = 1e-300'),
    ),
    "brackets without end": ("nested too deeply", ("at = [0.5, 4]", f"at = {'[' * 10000}")),
    "nested lists": ("nested too deeply", ("at = [0.5, 4]", f"at = {'[' * 9999}1{']' * 9999}")),
    "nested tables": (
        "nested too deeply",
        ("at = [0.5, 4]", f"at = {'{a = ' * 9999}1{'}' * 9999}"),
    ),
    "a key of many parts": (
        "schedule: has more than 20 levels",
        ("steps = 2", f"steps = 2\n{'.'.join('a' * 90)} = 1"),
    ),
    "a key for a number": (
        "schedule: has more than 20 levels",
        ("steps = 2", f"steps = 2\nend.{'.'.join('a' * 90)} = 1"),
    ),
    "a key of very many parts": (
        "has keys of too many parts, the first one in about line 40",
        ("steps = 2", f"steps = 2\n{'.'.join('a' * 3000)} = 1"),
    ),
    "a NUL byte": ("not valid TOML", ("at = [0.5, 4]", "at = \0[0.5, 4]")),
    "a NUL byte in a path": (
        "bodies[0].shape.file",
        body('{ type = "mesh", file = "a\\u0000.msh" }'),
    ),
    "a path of many characters": (
        "bodies[0].shape.file",
        body(f'{{ type = "mesh", file = "{"a" * 100_000}" }}'),
    ),
    "a long text for a number": (
        "schedule.end",
        ("steps = 2", f'steps = 2\nend = "{"a" * 100_000}"'),
    ),
    "a long key": ("unknown key", ("steps = 2", f"steps = 2\n{'a' * 100_000} = 1")),
    "many unknown keys": (
        "and 9980 more",
        ("steps = 2", "steps = 2\n" + "\n".join(f"step{i} = 1" for i in range(10_000))),
    ),
    "many unknown names": (
        "and 979 more",
        (
            "[[track]]",
            "".join(
                f'[[track]]\nname = "{i}"\nquantity = "penetration"\nboundary = "wall{i}"\n'
                for i in range(999)
            )
            + "[[track]]",
        ),
    ),
    "many tracks": (
        "track",
        ("[[track]]", '[[track]]\nname = "x"\n' * 1_001 + "[[track]]"),
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_extremes_are_refused(tilth: Tilth, case: Case, name: str) -> None:
    part, replaced = WRONG[name]
    file = case(replaced)
    outcome = tilth("check", file)
    assert outcome.code == 2, outcome.err[-2000:]
    assert outcome.out == ""
    assert outcome.err.startswith(f"{file}: ")
    assert part in outcome.err
    assert outcome.err.count(str(file)) == 1
    assert "Warning" not in outcome.err
    assert "Traceback" not in outcome.err
    assert len(outcome.err) < 10_000
    assert sorted(file.parent.iterdir()) == [file]


def in_space(shape: str, boundary: str = "") -> str:
    """Returns a case in 3D with this shape and boundary."""
    base = BASE.replace('axis = "y"', 'axis = "z"')
    if boundary:
        base = implicit(boundary)[1]
    replaced = (
        (LIMITS, ""), (LOAD, ""), (TRACK, 'quantity = "energy"\nkind = "elastic"'), (BASE, base),
        (BODY, shape), ('"plane_strain"', '"3d"'),
    )  # fmt: skip
    text = CASE
    for old, new in replaced:
        assert text.count(old) == 1
        text = text.replace(old, new)
    return text


BLOCK = '{ type = "box", lower = [0, 0, 0], upper = [1, 1, 1] }'
WRONG_IN_SPACE = {
    "a cylinder beyond numbers": (
        "bodies[0].shape.height",
        in_space(
            '{ type = "cylinder", centre = [0, 0, 0], radius = 1, axis = "z", height = 1e300 }'
        ),
    ),
    "a flat cylinder": (
        "bodies[0].shape",
        in_space(
            '{ type = "cylinder", centre = [0, 0, 0], radius = 1, axis = "z", height = 1e-20 }'
        ),
    ),
    "a sphere that is no number": (
        "bodies[0].shape.radius",
        in_space('{ type = "sphere", centre = [0, 0, 0], radius = nan }'),
    ),
    "a sphere of more points than numbers": (
        'bodies "column".points_per_cell: needs about',
        in_space('{ type = "sphere", centre = [0, 0, 0], radius = 1000 }'),
    ),
    "a box of more points than numbers": (
        'bodies "column".points_per_cell: needs about',
        in_space('{ type = "box", lower = [0, 0, 0], upper = [1e5, 1e5, 1e5] }'),
    ),
    "a far sphere": (
        "boundaries[0].geometry.centre",
        in_space(
            BLOCK,
            '{ type = "sphere", centre = [1e15, 0, 0], radius = 1, soil = "outside" }',
        ),
    ),
    "a tiny cylinder": (
        "boundaries[0].geometry.radius",
        in_space(
            BLOCK,
            '{ type = "cylinder", centre = [0, 0, 0], axis = "z", radius = 1e-25, '
            'soil = "outside" }',
        ),
    ),
    "a slim footing": (
        "boundaries[0].geometry.width",
        in_space(
            BLOCK,
            '{ type = "footing", centre = [0, 0, 1], normal = [0, 0, -1], along = [1, 0, 0], '
            "width = [1e-10, 1] }",
        ),
    ),
}


@pytest.mark.parametrize("name", WRONG_IN_SPACE)
def test_extremes_in_space_are_refused(tilth: Tilth, tmp_path: Path, name: str) -> None:
    part, text = WRONG_IN_SPACE[name]
    file = tmp_path / "case.toml"
    file.write_text(text, encoding="utf-8")
    outcome = tilth("check", file)
    assert outcome.code == 2, outcome.err[-2000:]
    assert part in outcome.err
    assert "Traceback" not in outcome.err


def test_a_large_file_is_not_read(tilth: Tilth, tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text("# " + "a" * 4_000_000, encoding="utf-8")
    outcome = tilth("check", file)
    assert outcome.code == 2
    assert "larger than 4 MB" in outcome.err


def test_a_device_without_end_is_not_read(tilth: Tilth) -> None:
    outcome = tilth("check", "/dev/zero")
    assert outcome.code == 2
    assert "cannot be read: it is a device, not a file" in outcome.err


@pytest.mark.parametrize(
    "value",
    [10**400, Decimal(1), date(1979, 5, 27), True, np.nan, np.inf, "1", [1], None],
)
def test_what_is_no_number_in_python(value: Any) -> None:
    with pytest.raises(BadInput, match=r"HenckyElastic\.young_modulus"):
        HenckyElastic(young_modulus=value, poisson_ratio=0.3)


@pytest.mark.parametrize(
    "value", [Fraction(1, 2), np.float32(0.5), np.float64(0.5), np.array(0.5)[()]]
)
def test_other_numbers_of_python(value: Any) -> None:
    assert Grid(cell_size=value).cell_size == 0.5
    assert Schedule(steps=np.int64(3)).steps == 3


def test_a_table_of_many_rows() -> None:
    factor = [[i, 1] for i in range(100_001)]
    with pytest.raises(BadInput, match=r"BodyForce\.factor = .*: has 100,001 rows"):
        BodyForce(acceleration=[0, 1], factor=factor)


def test_an_integer_that_python_does_not_write() -> None:
    with pytest.raises(BadInput, match=r"Schedule\.steps = \.\.\.: "):
        Schedule(steps=10**5000)


def test_a_dictionary_of_many_levels() -> None:
    nested: Any = 1
    for _ in range(100_000):
        nested = [nested]
    with pytest.raises(BadInput, match="schedule: has more than 20 levels"):
        Model.from_dict({"format": 1, "schedule": nested})
