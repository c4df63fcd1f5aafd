# SPDX-License-Identifier: BSD-3-Clause
"""What is refused or warned of before the first step with implicit boundaries, and what is not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from implicit_blocks import (
    ACROSS,
    BRICK,
    DISC,
    SQUARE,
    flat,
    gravity,
    implicit,
    model_of,
    squeezed,
    steps_of,
)
from small_problems import KINDS, plane

from tilth import BadInput, Model
from tilth.analysis.simulation import Simulation
from tilth.cli import run_command

pytestmark = pytest.mark.slow

BLOCK = {"type": "box", "lower": [0.1, 0.2], "upper": [1.1, 1.2]}
CUBE = {"type": "box", "lower": [0.1, 0.2, 0.3], "upper": [1.1, 1.2, 1.3]}
BALL = {"type": "sphere", "centre": [0.1, 0.2, 0.0], "radius": 0.7}
BASE = implicit("base", flat([0.0, 0.2], [0.0, 1.0]), "fixed")
LEFT = implicit("left", flat([0.1, 0.0], [1.0, 0.0]))

FUNCTIONS = """
import numpy as np
def base(x):
    return x[:, 1] - 0.2
def upside_down(x):
    return 0.2 - x[:, 1]
def nowhere(x):
    return x[:, 1] - 100.0
def nan(x):
    return np.where(x[:, 1] > 0.5, np.nan, x[:, 1] - 0.2)
def lift_nan(x, factor):
    return np.full_like(x, np.nan if factor > 0.0 else 0.0)
def hollow(x):
    return 1.0 - np.linalg.norm(x - 0.5, axis=1)
"""


@pytest.fixture
def functions(tmp_path: Path) -> str:
    file = tmp_path / "functions.py"
    file.write_text(FUNCTIONS)
    return str(file)


def checked(shape: dict[str, Any], *walls: Any, kind: str = "plane_strain", **more: Any) -> Any:
    """The simulation of a block after its checks."""
    simulation = Simulation(model_of(kind, "gimp", shape, list(walls), **more))
    simulation.check()
    return simulation


# --- boundaries without soil ---------------------------------------------------------------------


def test_a_boundary_that_touches_nothing_is_named() -> None:
    far = implicit("far wall", flat([5.0, 0.0], [-1.0, 0.0]))
    simulation = checked(BLOCK, BASE, far)
    assert [
        text
        for text in simulation.services.warnings.texts
        if "'far wall' is not in contact" in text
    ]
    assert not [text for text in simulation.services.warnings.texts if "'base'" in text]
    result = simulation.advance(0.0, 1.0)
    assert (
        len([text for text in simulation.services.warnings.texts if "'far wall'" in text]) == 1
    ), "said once"
    assert not result.resultant("far wall").any()


def test_a_boundary_that_touches_is_not_named() -> None:
    assert not [
        text for text in checked(BLOCK, BASE, LEFT).services.warnings.texts if "boundary '" in text
    ]


@pytest.mark.parametrize(
    "geometry",
    [
        flat([0.0, 2.0], [0.0, 1.0]),
        {**DISC, "radius": 3.0, "soil": "outside"},
        {"type": "box", "lower": [-1.0, -1.0], "upper": [2.0, 2.0], "soil": "outside"},
        {"type": "polyline", "vertices": [[-1.0, 2.0], [3.0, 2.0]], "soil": "left"},
    ],
)
def test_all_soil_behind_a_boundary(geometry: dict[str, Any]) -> None:
    with pytest.raises(BadInput, match="all material is behind") as error:
        checked(BLOCK, BASE, implicit("upside down", geometry))
    assert "upside down" in str(error.value)
    assert "turn the normal" in str(error.value)


@pytest.mark.parametrize("name", ["upside_down", "nowhere"])
def test_a_function_with_the_wrong_sign(functions: str, name: str) -> None:
    geometry = {"type": "function", "function": f"{functions}:{name}"}
    with pytest.raises(BadInput, match="all material is behind") as error:
        checked(BLOCK, implicit("hill", geometry, "fixed"))
    assert "hill" in str(error.value)


def test_a_function_that_returns_no_number(functions: str) -> None:
    geometry = {"type": "function", "function": f"{functions}:nan"}
    with pytest.raises(BadInput, match=r"boundaries\[1\]\.geometry.*`nan`.*returned nan at"):
        checked(BLOCK, BASE, implicit("hill", geometry))


def test_a_motion_that_returns_no_number(functions: str) -> None:
    lift = implicit("lift", flat([0.0, 1.2], [0.0, -1.0]), motion=f"{functions}:lift_nan")
    with pytest.raises(BadInput, match=r"boundaries\[1\]\.motion.*`lift_nan`.*nan"):
        checked(BLOCK, BASE, lift)


def test_a_function_that_is_right(functions: str) -> None:
    geometry = {"type": "function", "function": f"{functions}:base"}
    warnings = checked(BLOCK, implicit("hill", geometry, "fixed")).services.warnings.texts
    assert not [text for text in warnings if "'hill'" in text]


# --- contradictions ------------------------------------------------------------------------------

UP = {"displacement": {"y": 0.1}}
ALONG = {"displacement": {"x": 0.1}}
FOOTING = {"type": "footing", "centre": [0.4, 1.2], "normal": [0.0, -1.0], "width": 0.6}
CONTRADICTIONS: dict[str, list[Any]] = {
    "two motions of one place": [BASE, implicit("other", BASE["geometry"], "fixed", **UP)],
    "from both sides": [
        BASE,
        implicit("other", {**SQUARE, "angle": 0.0, "soil": "inside", "faces": ["y-"]}, **UP),
    ],
    "in one of two directions": [
        implicit("base", BASE["geometry"], "direction", direction=[1.0, 1.0]),
        implicit("other", BASE["geometry"], "direction", direction=[2.0, 2.0], **ALONG),
    ],
    "a rotation": [
        BASE,
        implicit("other", BASE["geometry"], rotation={"angle": 3.0, "centre": [0.1, 0.2]}),
    ],
    "in the middle of the schedule": [
        BASE,
        implicit(
            "other", BASE["geometry"], factor=[[0, 0], [0.5, 0], [0.6, 1], [0.7, 0], [1, 0]], **UP
        ),
    ],
}


@pytest.mark.parametrize("name", CONTRADICTIONS)
def test_contradictions_name_both_boundaries(name: str) -> None:
    with pytest.raises(BadInput, match="contradictory displacements") as error:
        checked(BLOCK, *CONTRADICTIONS[name])
    assert "'base'" in str(error.value)
    assert "'other'" in str(error.value)
    assert "the same motion" in str(error.value)


def test_contradiction_with_a_condition_on_a_grid_line() -> None:
    """One place, two conditions of different kinds."""
    shape = {"type": "box", "lower": [0.0, 0.0], "upper": [1.0, 1.0]}
    other = implicit("other", flat([0.0, 0.0], [0.0, 1.0]), "fixed", **UP)
    with pytest.raises(BadInput) as error:
        checked(shape, plane("base", "y", 0.0, condition="fixed"), other)
    assert "'base'" in str(error.value)
    assert "'other'" in str(error.value)


AGREEMENTS: dict[str, tuple[dict[str, Any], list[Any]]] = {
    "corners of a moving box": (
        SQUARE,
        [implicit("box", {**SQUARE, "soil": "inside"}, "fixed", displacement={"x": 1.0, "y": 2.0})],
    ),
    "corners between smooth platens that all move": (
        BLOCK,
        [
            implicit("base", BASE["geometry"], **UP),
            implicit("left", LEFT["geometry"], **ALONG),
            implicit("top", flat([0.0, 1.2], [0.0, -1.0]), displacement={"y": -0.3}),
        ],
    ),
    "a rough footing beside a smooth wall": (
        BLOCK,
        [BASE, LEFT, implicit("footing", FOOTING, "fixed", displacement={"y": -0.1})],
    ),
    "a smooth footing beside a wall that moves": (
        BLOCK,
        [
            BASE,
            implicit("wall", {**FOOTING, "centre": [0.1, 0.9], "normal": [1.0, 0.0]}, **ALONG),
            implicit("footing", FOOTING, displacement={"y": -0.1}),
        ],
    ),
    "one condition said twice": (
        BLOCK,
        [
            implicit("base", BASE["geometry"], "fixed", **UP),
            implicit("again", BASE["geometry"], "fixed", **UP),
        ],
    ),
    "two rollers with the same normal motion": (
        BLOCK,
        [
            LEFT,
            implicit("base", BASE["geometry"], **UP),
            implicit("again", BASE["geometry"], displacement={"x": 3.0, "y": 0.1}),
        ],
    ),
    "a roller and what holds along it": (
        BLOCK,
        [
            implicit("base", BASE["geometry"], **UP),
            implicit("rough", BASE["geometry"], "tangential", **ALONG),
        ],
    ),
    "far from each other": (
        BLOCK,
        [BASE, implicit("top", flat([0.0, 1.2], [0.0, -1.0]), "fixed", displacement={"y": -0.3})],
    ),
}


@pytest.mark.parametrize("name", AGREEMENTS)
def test_no_false_alarm(name: str) -> None:
    shape, walls = AGREEMENTS[name]
    texts = checked(shape, *walls, steps=20).services.warnings.texts
    assert [text for text in texts if "cells wide" not in text] == []  # these are narrow


@pytest.mark.parametrize("kind", KINDS)
def test_no_false_alarm_in_other_kinds(kind: str) -> None:
    simulation = Simulation(squeezed(kind, "gimp", "fixed", 1e-4))
    simulation.check()
    assert simulation.services.warnings.texts == []


# --- rigid motions -------------------------------------------------------------------------------

SLOPE = flat([0.1, 0.2], ACROSS)
STEEP = flat([0.1, 0.2], [np.cos(np.pi / 9), np.sin(np.pi / 9)])
FREE: dict[str, tuple[str, dict[str, Any], list[Any], str]] = {
    "one smooth inclined plane": ("plane_strain", SQUARE, [implicit("base", SLOPE)], "translation"),
    "two smooth parallel planes": (
        "plane_strain",
        BLOCK,
        [implicit("base", BASE["geometry"]), implicit("top", flat([0.0, 1.2], [0.0, -1.0]))],
        "translation along x",
    ),
    "what holds along one direction": (
        "plane_strain",
        SQUARE,
        [implicit("base", SLOPE, "direction", direction=[1.0, 2.0])],
        "translation",
    ),
    "a disc in a smooth rim": (
        "plane_strain",
        DISC,
        [implicit("rim", {**DISC, "soil": "inside"})],
        "rotation in the xy plane",
    ),
    "a ball in a smooth shell": (
        "3d",
        BALL,
        [implicit("rim", {**BALL, "soil": "inside"})],
        "rotation in the yz plane",
    ),
    "two planes in space": (
        "3d",
        CUBE,
        [implicit(n, flat([0.1, 0.2, 0.3], v)) for n, v in (("a", [1, 0, 0]), ("b", [0, 1, 1]))],
        "translation along y and translation along z",
    ),
    "a smooth wall around the axis": (
        "axisymmetric",
        {"type": "box", "lower": [0.0, 0.2], "upper": [1.0, 1.2]},
        [implicit("wall", flat([1.0, 0.0], [-1.0, 0.0]))],
        "translation along y",
    ),
    "only one of two bodies": ("plane_strain", BLOCK, [BASE], "translation along x"),
}


@pytest.mark.parametrize("name", FREE)
def test_a_rigid_motion_that_is_left_is_refused(name: str) -> None:
    kind, shape, walls, free = FREE[name]
    model = model_of(kind, "gimp", shape, walls)
    if name == "only one of two bodies":
        entries = model.to_dict()
        second = {**shape, "lower": [5.0, 3.2], "upper": [6.0, 4.2]}
        entries["bodies"].append({**entries["bodies"][0], "name": "loose", "shape": second})
        model = Model.from_dict(entries)
    with pytest.raises(BadInput, match="not constrained against") as error:
        Simulation(model).check()
    assert free in str(error.value)
    assert "singular" in str(error.value)


HELD: dict[str, tuple[str, dict[str, Any], list[Any]]] = {
    "two smooth inclined planes": (
        "plane_strain",
        SQUARE,
        [implicit("base", SLOPE), implicit("left", STEEP)],
    ),
    "one rough inclined plane": ("plane_strain", SQUARE, [implicit("base", SLOPE, "fixed")]),
    "a smooth plane and a direction": (
        "plane_strain",
        SQUARE,
        [
            implicit("base", SLOPE),
            implicit("side", SLOPE, "direction", direction=[1.0, 0.0]),
        ],
    ),
    "a smooth plane and a grid line": (
        "plane_strain",
        {"type": "box", "lower": [0.0, 0.2], "upper": [1.0, 1.2]},
        [implicit("base", BASE["geometry"]), plane("left", "x", 0.0)],
    ),
    "a disc in a rough rim": (
        "plane_strain",
        DISC,
        [implicit("rim", {**DISC, "soil": "inside"}, "tangential")],
    ),
    "three planes in space": (
        "3d",
        CUBE,
        [
            implicit(n, flat([0.1, 0.2, 0.3], v))
            for n, v in (("a", [1, 0, 0]), ("b", [0, 1, 0]), ("c", [0, 0, 1]))
        ],
    ),
    "a smooth base around the axis": (
        "axisymmetric",
        {"type": "box", "lower": [0.0, 0.2], "upper": [1.0, 1.2]},
        [implicit("base", BASE["geometry"])],
    ),
}


@pytest.mark.parametrize("name", HELD)
def test_what_holds_everything_is_accepted(name: str) -> None:
    """And the system of equations is regular: the block bears its weight."""
    kind, shape, walls = HELD[name]
    load = gravity(3 if kind == "3d" else 2)
    simulation, _ = steps_of(model_of(kind, "gimp", shape, walls, steps=2, loads=[load]))
    assert simulation.services.warnings.texts == []
    assert 1e-4 < np.abs(simulation.state.points.displacement).max() < 0.2


# --- delta ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("delta", [0.0, -1e-3, 0.126, float("nan")])
def test_delta_out_of_range(delta: float) -> None:
    with pytest.raises(BadInput, match=r"boundaries\[0\]\.delta"):
        model_of("plane_strain", "gimp", BLOCK, [{**BASE, "delta": delta}])


@pytest.mark.parametrize("delta", [1e-6, 0.125])
def test_delta_within_its_range(delta: float) -> None:
    wall = {**BASE, "delta": delta}
    simulation = checked(BLOCK, wall)
    assert simulation.state.implicit[0].delta == delta


def test_delta_is_a_thousandth_of_the_smallest_edge() -> None:
    entries = model_of("plane_strain", "gimp", BLOCK, [BASE]).to_dict()
    entries["grid"]["cell_size"] = [0.25, 0.5]
    assert Simulation(Model.from_dict(entries)).state.implicit[0].delta == 0.25e-3


# --- tilth check ---------------------------------------------------------------------------------

TETRAHEDRON = """solid base
{facets}
endsolid base
"""
CORNERS = ((-2.0, -2.0, -2.0), (6.0, -2.0, -2.0), (-2.0, 6.0, -2.0), (-2.0, -2.0, 6.0))
TRIANGLES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def stl() -> str:
    facets = []
    for triangle in TRIANGLES:
        corners = "".join("vertex {} {} {}\n".format(*CORNERS[k]) for k in triangle)
        facets.append(f"facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet")
    return TETRAHEDRON.format(facets="\n".join(facets))


DRAWN: dict[str, tuple[str, dict[str, Any], dict[str, Any]]] = {
    "plane": ("plane_strain", BLOCK, flat([0.0, 0.2], [0.1, 1.0])),
    "plane around the axis": (
        "axisymmetric",
        {"type": "box", "lower": [0.0, 0.2], "upper": [1.0, 1.2]},
        flat([0.0, 0.2], [0.0, 1.0]),
    ),
    "plane in space": ("3d", CUBE, flat([0.1, 0.2, 0.3], [0.1, 0.2, 1.0])),
    "circle": ("plane_strain", DISC, {**DISC, "soil": "inside"}),
    "cylinder": (
        "3d",
        CUBE,
        {"type": "cylinder", "centre": [0.6, 0.7, 0.8], "axis": [0.0, 1.0, 1.0], "radius": 0.6,
         "soil": "inside"},
    ),
    "sphere": ("3d", BALL, {**BALL, "soil": "inside"}),
    "polyline": (
        "plane_strain",
        BLOCK,
        {"type": "polyline", "vertices": [[0.0, 0.2], [0.6, 0.17], [1.3, 0.2]], "soil": "left"},
    ),
    "box": ("plane_strain", SQUARE, {**SQUARE, "soil": "inside"}),
    "box in space": ("3d", BRICK, {**BRICK, "soil": "inside", "faces": ["z-", "x+"]}),
    "footing": ("plane_strain", BLOCK, {**FOOTING, "centre": [0.6, 0.2], "normal": [0.0, 1.0]}),
    "footing in space": (
        "3d",
        CUBE,
        {"type": "footing", "centre": [0.6, 0.7, 0.3], "normal": [0.0, 0.0, 1.0],
         "width": [0.5, 0.8], "along": [1.0, 1.0, 0.0]},
    ),
    "function": ("plane_strain", BLOCK, {"type": "function", "function": "functions.py:base"}),
    "function in space": ("3d", CUBE, {"type": "function", "function": "functions.py:hollow"}),
    "stl": ("3d", CUBE, {"type": "stl", "file": "surface.stl", "soil": "inside"}),
    "terrain": (
        "plane_strain",
        BLOCK,
        {"type": "terrain", "surface": [[-1.0, 0.2], [0.6, 0.17], [2.0, 0.2]], "lower": [-1.0],
         "upper": [2.0], "soil": "above"},
    ),
    "terrain in space": (
        "3d",
        CUBE,
        {"type": "terrain", "surface": 0.2, "lower": [-1, -1], "upper": [2, 2], "soil": "above"},
    ),
}  # fmt: skip


def toml(item: Any) -> str:
    if isinstance(item, dict):
        return "{" + ", ".join(f"{k} = {toml(v)}" for k, v in item.items() if v is not None) + "}"
    if isinstance(item, list | tuple):
        return "[" + ", ".join(map(toml, item)) + "]"
    if isinstance(item, str):
        return f'"{item}"'
    return str(item).lower() if isinstance(item, bool) else str(item)


@pytest.mark.parametrize("name", DRAWN)
@pytest.mark.usefixtures("functions")
def test_check_draws_every_geometry(
    name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    kind, shape, geometry = DRAWN[name]
    (tmp_path / "surface.stl").write_text(stl())
    dim = 3 if kind == "3d" else 2
    other = implicit("other", flat([0.0] * dim, np.eye(dim)[1].tolist()))
    entries = model_of(kind, "gimp", shape, [other]).to_dict()
    entries["boundaries"] = [implicit("wall", geometry, "fixed", displacement={"y": 0.1})]
    file = tmp_path / "case.toml"
    file.write_text("".join(f"{key} = {toml(value)}\n" for key, value in entries.items()))
    code = run_command(["check", str(file)])
    printed = capfd.readouterr()
    assert code == 0
    about_the_wall = "warning: boundaries[0].geometry"  # some bodies are behind it, or it is small
    assert all(line.startswith(about_the_wall) for line in printed.err.splitlines())
    assert "wall: implicit, fixed" in printed.out
    assert file.with_suffix(".setup.png").read_bytes().startswith(b"\x89PNG")
