# SPDX-License-Identifier: BSD-3-Clause
"""Motion of implicit boundaries: places, area vectors, and what turns with them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree
from small_problems import block_entries, dimension

from tilth import BadInput, Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.boundaries import ImplicitConstraints, make_implicit
from tilth.boundaries.surfaces.boundary import Implicit
from tilth.boundaries.surfaces.motion import cofactor, make_motion, rotation_matrix, rotation_part
from tilth.boundaries.surfaces.points import Pose, rotated
from tilth.mpm.active_grid import Buffers, locate

pytestmark = pytest.mark.slow

LINE = {"type": "plane", "point": [0.2, 0.1], "normal": [0.0, 1.0]}
PLANE = {"type": "plane", "point": [0.2, 0.1, 0.0], "normal": [0.0, 0.0, 1.0]}
CIRCLE = {"type": "circle", "centre": [0.7, 0.4], "radius": 1.5, "soil": "inside"}
SPHERE = {"type": "sphere", "centre": [0.7, 0.4, -0.2], "radius": 1.5, "soil": "outside"}
CYLINDER = {
    "type": "cylinder", "centre": [0.7, 0.4, -0.2], "axis": [1.0, 2.0, 2.0], "radius": 1.5,
    "soil": "inside",
}  # fmt: skip
BOX = {"type": "box", "lower": [-0.5, 0.2], "upper": [1.5, 1.3], "angle": 20.0, "soil": "inside"}
CUBE = {
    "type": "box", "lower": [-0.5, 0.2, 0.0], "upper": [1.5, 1.3, 0.7], "angle": 20.0, "axis": "x",
    "soil": "inside",
}  # fmt: skip

TURN = {"angle": 50.0, "centre": [0.3, -0.6]}
ALL = {"displacement": {"x": 0.3, "y": -0.8}, "rotation": TURN, "radius_change": -0.4}
MOTIONS = {
    "translation": (LINE, {"displacement": {"x": 0.3, "y": -0.8}}),
    "translation in space": (PLANE, {"displacement": {"x": 0.3, "z": -0.8}}),
    "rotation": (LINE, {"rotation": TURN}),
    **{
        f"rotation about {axis}": (
            PLANE,
            {"rotation": {"angle": -70.0, "centre": [0.3, -0.6, 0.9], "axis": axis}},
        )
        for axis in "xyz"
    },
    "radius of a circle": (CIRCLE, {"radius_change": 0.5}),
    "radius of a cylinder": (CYLINDER, {"radius_change": 0.5}),
    "radius of a sphere": (SPHERE, {"radius_change": 0.5}),
    "volume of a circle": (CIRCLE, {"volume_loss": 0.3}),
    "volume of a cylinder": (CYLINDER, {"volume_loss": 0.3}),
    "volume of a sphere": (SPHERE, {"volume_loss": 0.3}),
    "all of a circle with a volume": (CIRCLE, {**ALL, "radius_change": None, "volume_loss": 0.3}),
    "all of a circle": (CIRCLE, ALL),
    "all of a cylinder": (
        CYLINDER,
        {**ALL, "rotation": {"angle": 50.0, "centre": [0.3, -0.6, 0.9], "axis": "y"}},
    ),
}
every_motion = pytest.mark.parametrize("name", MOTIONS)
FACTORS = (0.0, 0.3, 1.0, -0.5)

BEND = """
import numpy as np
def bend(x, factor):
    return factor * np.column_stack([0.1 * x[:, 1] ** 2, 0.2 * np.sin(x[:, 0])])
def shear(x, factor):
    return factor * np.column_stack([0.4 * x[:, 1], 0.25 * x[:, 0] + 0.5 * x[:, 1]])
def nothing(x, factor):
    return np.full(x.shape, np.nan)
"""


def boundary(
    geometry: dict[str, Any], kind: str | None = None, cell: float = 0.3, **more: Any
) -> Implicit:
    """An implicit boundary on its own."""
    dim = len(geometry.get("point", geometry.get("centre", geometry.get("lower", [0, 0]))))
    kind = kind or ("3d" if dim == 3 else "plane_strain")
    declared = {"type": "implicit", "name": "wall", "condition": "roller", "geometry": geometry}
    entries = block_entries(kind, "gimp", boundaries=[declared | more])
    entries["grid"]["cell_size"] = cell
    model = Model.from_dict(entries)
    (made,) = make_implicit(model)
    made.extend_quadrature(np.full(dimension(kind), -1.0), np.full(dimension(kind), 2.0))
    return made


def pose_of(made: Implicit, before: float, after: float) -> Pose:
    """All of a boundary in a step."""
    return made.pose(before, after, np.arange(len(made.carried)))


def places(dim: int) -> Floats:
    return np.random.default_rng(3).uniform(-2.0, 3.0, (20, dim))


@pytest.fixture
def functions(tmp_path: Path) -> str:
    (tmp_path / "motion.py").write_text(BEND)
    return str(tmp_path / "motion.py")


def assert_map(made: Implicit, dim: int, exact: float) -> None:
    """Asserts that `reference` undoes `place` and that `gradient` is its derivative."""
    x, motion = places(dim), made.motion
    assert motion.position(x, 0.0) == pytest.approx(x, abs=1e-14)
    for factor in FACTORS:
        there = motion.position(x, factor)
        assert np.abs(motion.reference(there, factor) - x).max() < exact
        gradient = motion.gradient(x, factor)
        assert gradient.shape == (len(x), dim, dim)
        for k, unit in enumerate(np.eye(dim)):
            step = 1e-5 * unit
            difference = (
                motion.position(x + step, factor) - motion.position(x - step, factor)
            ) / 2e-5
            assert gradient[:, :, k] == pytest.approx(difference, abs=1e-8)


@every_motion
def test_linear_motions(name: str) -> None:
    geometry, motion = MOTIONS[name]
    made = boundary(geometry, **motion)
    dim = len(geometry.get("point", geometry.get("centre")))
    assert_map(made, dim, 1e-13)
    assert np.abs(made.motion.position(places(dim), 1.0) - places(dim)).max() > 0.1


def test_motion_of_a_user(functions: str) -> None:
    made = boundary(LINE, motion=f"{functions}:bend")
    assert_map(made, 2, 1e-11)
    x = places(2)
    moved = x + 0.5 * np.column_stack([0.1 * x[:, 1] ** 2, 0.2 * np.sin(x[:, 0])])
    assert made.motion.position(x, 0.5) == pytest.approx(moved, abs=1e-15)


def test_motion_of_a_user_that_is_no_number(functions: str) -> None:
    made = boundary(LINE, motion=f"{functions}:nothing")
    with pytest.raises(BadInput, match=r"boundaries\[0\]\.motion.*`nothing`.*nan"):
        pose_of(made, 0.0, 1.0)


def test_order_and_sense_of_the_parts() -> None:
    """First the radius, then the rotation, then the translation; anticlockwise."""
    quarter = {"angle": 90.0, "centre": [1.0, 0.0]}
    made = boundary(
        {**CIRCLE, "centre": [2.0, 0.0], "radius": 1.0}, radius_change=1.0, rotation=quarter,
        displacement={"x": 10.0},
    )  # fmt: skip
    # (3, 0) is on the circle; it grows to (4, 0), turns about (1, 0) to (1, 3), moves to (11, 3)
    x = np.array([[3.0, 0.0]])
    assert made.motion.position(x, 1.0) == pytest.approx(np.array([[11.0, 3.0]]), abs=1e-14)
    turn, centre = rotation_matrix(45.0, None, 2), np.array([1.0, 0.0])
    half = centre + turn @ (np.array([3.5, 0.0]) - centre) + [5.0, 0.0]
    assert made.motion.position(x, 0.5)[0] == pytest.approx(half, abs=1e-14)


@pytest.mark.parametrize(("axis", "start", "end"), [("x", 1, 2), ("y", 2, 0), ("z", 0, 1)])
def test_sense_of_rotation_about_each_axis(axis: str, start: int, end: int) -> None:
    turn = rotation_matrix(90.0, axis, 3)
    assert turn @ np.eye(3)[start] == pytest.approx(np.eye(3)[end], abs=1e-15)
    assert np.linalg.det(turn) == pytest.approx(1.0)


def test_cofactor_maps_area_vectors() -> None:
    """Nanson's formula."""
    random = np.random.default_rng(5)
    gradient = np.eye(3) + 0.5 * random.uniform(-1, 1, (50, 3, 3))
    a, b = random.uniform(-1, 1, (2, 50, 3))
    area = np.cross(
        np.einsum("nij,nj->ni", gradient, a), np.einsum("nij,nj->ni", gradient, b)
    )  # fmt: skip
    mapped = np.einsum("nij,nj->ni", cofactor(gradient), np.cross(a, b))
    assert mapped == pytest.approx(area, abs=1e-13)
    flat = gradient[:, :2, :2]
    quarter = np.array([[0.0, 1.0], [-1.0, 0.0]])
    along = np.einsum("nij,nj->ni", flat, a[:, :2])
    mapped = np.einsum("nij,nj->ni", cofactor(flat), a[:, :2] @ quarter.T)
    assert mapped == pytest.approx(along @ quarter.T, abs=1e-13)


def test_rotation_part_is_that_of_the_polar_decomposition() -> None:
    random = np.random.default_rng(6)
    stretch = random.uniform(-0.3, 0.3, (3, 3))
    stretch = np.eye(3) + stretch + stretch.T
    turn = rotation_matrix(130.0, "y", 3) @ rotation_matrix(-35.0, "x", 3)
    assert rotation_part((turn @ stretch)[None])[0] == pytest.approx(turn, abs=1e-13)


def closed(made: Implicit, before: float, after: float) -> Floats:
    """Sum of the area vectors; normals are those of the middle, so the motion must not turn."""
    pose = pose_of(made, before, after)
    return np.asarray(np.einsum("n,ni->i", pose.weight, pose.normal))


def test_a_circle_grows() -> None:
    made = boundary(CIRCLE, radius_change=0.5, displacement={"x": 0.3}, rotation=TURN)
    for factor in (0.0, 0.4):
        pose = pose_of(made, factor, 1.0)
        assert pose.weight.sum() == pytest.approx(2.0 * np.pi * (1.5 + 0.5 * factor), rel=1e-9)
    centre = made.motion.position(np.array([CIRCLE["centre"]]), 0.4)[0]
    assert np.linalg.norm(pose.position - centre, axis=1) == pytest.approx(1.7, abs=1e-12)
    # normals at the middle of the step are those of the circle there
    centre = made.motion.position(np.array([CIRCLE["centre"]]), 0.7)[0]
    assert made.quadrature is not None
    away = made.motion.position(made.quadrature.reference, 0.7) - centre
    assert pose.normal == pytest.approx(-away / 1.85, abs=1e-12)
    assert pose.increment == pytest.approx(
        made.motion.position(made.quadrature.reference, 1.0) - pose.position, abs=1e-14
    )


@pytest.mark.parametrize(("geometry", "power"), [(CIRCLE, 2), (CYLINDER, 2), (SPHERE, 3)])
def test_a_tunnel_loses_the_given_share(geometry: dict[str, Any], power: int) -> None:
    """Area of a circle, section of a cylinder, volume of a sphere: the power of its radius."""
    made = boundary(geometry, volume_loss=0.2)
    assert made.quadrature is not None
    axis = np.array(geometry.get("axis", np.zeros(len(geometry["centre"]))))
    axis = axis / (np.linalg.norm(axis) or 1.0)
    for factor in (0.0, 0.5, 1.0):
        arm = made.motion.position(made.quadrature.reference, factor) - geometry["centre"]
        radius = np.linalg.norm(arm - np.outer(arm @ axis, axis), axis=1)
        np.testing.assert_allclose((radius / 1.5) ** power, 1.0 - 0.2 * factor, rtol=1e-12)


def test_a_sphere_grows() -> None:
    made = boundary(SPHERE, radius_change=0.5, displacement={"z": 1.0})
    for factor in (0.0, 1.0):
        area = 4.0 * np.pi * (1.5 + 0.5 * factor) ** 2
        assert pose_of(made, factor, factor).weight.sum() == pytest.approx(area, rel=1e-4)
        assert closed(made, factor, factor) == pytest.approx(np.zeros(3), abs=1e-6 * area)
    pose = pose_of(made, 1.0, 1.0)
    away = pose.position - np.array(SPHERE["centre"]) - [0.0, 0.0, 1.0]
    assert pose.normal == pytest.approx(away / 2.0, abs=1e-12)


def test_a_sphere_grows_in_axisymmetry() -> None:
    ball = {**CIRCLE, "centre": [0.0, 0.4]}
    made = boundary(ball, "axisymmetric", radius_change=0.5, displacement={"y": 0.7})
    for factor in (0.0, 1.0):
        area = 4.0 * np.pi * (1.5 + 0.5 * factor) ** 2
        pose = pose_of(made, factor, factor)
        assert (pose.position[:, 0] > 0.0).all(), "the other half is the same surface once more"
        assert pose.weight.sum() == pytest.approx(area, rel=1e-6)


@pytest.mark.parametrize("geometry", [BOX, CUBE])
def test_a_box_turns(geometry: dict[str, Any]) -> None:
    dim = len(geometry["lower"])
    rotation = {"angle": 35.0, "centre": [0.3] * dim} | ({"axis": "y"} if dim == 3 else {})
    made = boundary(geometry, rotation=rotation, displacement={"x": 0.2})
    size = np.subtract(geometry["upper"], geometry["lower"])
    area = 2.0 * (size.sum() if dim == 2 else np.prod(size) * (1.0 / size).sum())
    assert made.quadrature is not None
    for factor in (0.0, 0.6, 1.0):
        pose = pose_of(made, factor, factor)
        assert pose.weight.sum() == pytest.approx(area, rel=1e-12)
        assert closed(made, factor, factor) == pytest.approx(np.zeros(dim), abs=1e-12)
        turn = rotation_matrix(35.0 * factor, rotation.get("axis"), dim)
        assert pose.normal == pytest.approx(made.quadrature.normal @ turn.T, abs=1e-12)


def test_a_box_is_stretched_by_a_user(functions: str) -> None:
    """Each face of a sheared box: its length, its normal, and a closed sum."""
    square = {**BOX, "angle": 0.0}
    made = boundary(square, motion=f"{functions}:shear")
    matrix = np.array([[1.0, 0.4], [0.25, 1.5]])
    pose, quadrature = pose_of(made, 1.0, 1.0), made.quadrature
    assert quadrature is not None
    assert closed(made, 1.0, 1.0) == pytest.approx(np.zeros(2), abs=1e-8)
    for normal, along in (
        ([1, 0], [0, 1.1]), ([-1, 0], [0, 1.1]), ([0, 1], [2, 0]), ([0, -1], [2, 0]),
    ):  # fmt: skip
        face = (quadrature.normal == normal).all(axis=1)
        edge = matrix @ along
        assert pose.weight[face].sum() == pytest.approx(np.linalg.norm(edge), rel=1e-8)
        assert pose.normal[face] @ edge == pytest.approx(np.zeros(face.sum()), abs=1e-8)
        assert (pose.normal[face] @ (matrix @ normal) > 0.0).all()


def test_gradient_of_the_prescribed_displacement(functions: str) -> None:
    """By the place at the start of the step."""
    made = boundary(LINE, motion=f"{functions}:bend", factor=[[0, 0], [1, 2]])
    pose = pose_of(made, 0.25, 0.5)
    for k, unit in enumerate(np.eye(2)):
        ends = [
            made.motion.position(made.motion.reference(pose.position + s * unit, 0.5), 1.0)
            - (pose.position + s * unit)
            for s in (1e-4, -1e-4)
        ]
        difference = (ends[0] - ends[1]) / 2e-4
        assert pose.gradient[:, :, k] == pytest.approx(difference, abs=1e-6)


def test_held_direction_turns_with_the_boundary() -> None:
    made = boundary(
        LINE, condition="direction", direction=[3.0, 4.0], rotation={**TURN, "angle": 90.0}
    )
    constrained = rotation_matrix(45.0, None, 2) @ [0.6, 0.8]
    pose = pose_of(made, 0.25, 0.75)  # directions are those of the middle of the step
    assert pose.projector == pytest.approx(
        np.broadcast_to(np.outer(constrained, constrained), pose.projector.shape), abs=1e-14
    )


@pytest.mark.parametrize("form", ["surface", "band"])
def test_carried_tractions_turn(form: str) -> None:
    rotation = {"angle": 60.0, "centre": [1.0, 0.0, 0.0], "axis": "y"}
    made = boundary(PLANE, rotation=rotation, displacement={"x": 0.5}, form=form, cell=1.0)
    pose = pose_of(made, 0.0, 0.5)
    random = np.random.default_rng(9)
    carried = random.uniform(-1, 1, made.carried.shape)
    middle, end = rotated(carried, pose, 0), rotated(rotated(carried, pose, 0), pose, 1)
    for angle, now in ((15.0, middle), (30.0, end)):
        turn = rotation_matrix(angle, "y", 3)
        assert now[:, :3] == pytest.approx(carried[:, :3] @ turn.T, abs=1e-14)
        if form == "band":
            tensor = carried[:, 3:].reshape(-1, 3, 3)
            assert now[:, 3:].reshape(-1, 3, 3) == pytest.approx(
                turn @ tensor @ turn.T, abs=1e-14
            )  # fmt: skip


@pytest.mark.parametrize("form", ["surface", "band"])
def test_a_step_turns_what_is_carried(form: str) -> None:
    """Before a step into its middle, after it on to its end; what touches no soil carries nothing.

    The reaction would come right without: the slip makes up for it, once more in every step.
    """
    wall = {
        "type": "implicit", "name": "wall", "condition": "fixed", "geometry": {**BOX, "angle": 0.0},
        "rotation": {"angle": 60.0, "centre": [0.0, 0.5]}, "form": form,
    }  # fmt: skip
    entries = block_entries("plane_strain", "gimp", boundaries=[wall])
    entries["bodies"][0]["shape"] = {"type": "box", "lower": [-0.5, 0.2], "upper": [0.5, 1.3]}
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    (made,) = simulation.state.implicit
    made.carried = np.random.default_rng(9).uniform(-1, 1, made.carried.shape)
    start = made.carried.copy()
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    constraints = ImplicitConstraints.gather(
        [made], simulation.state.points, active, "plane_strain", 0.0, 0.5
    )
    (part,) = constraints.parts
    half, whole = rotation_matrix(15.0, None, 2), rotation_matrix(30.0, None, 2)
    middle = start[part.chosen, :2] @ half.T
    assert part.before[:, :2] == pytest.approx(middle, abs=1e-13)
    part.commit(part.before)
    assert made.carried[part.chosen, :2] == pytest.approx(
        middle @ (whole @ half.T).T, abs=1e-13
    )  # fmt: skip
    others = np.delete(made.carried, part.chosen, axis=0)
    assert len(others) > 0
    assert not others.any()


def test_a_larger_region_keeps_what_is_carried() -> None:
    for geometry in (LINE, PLANE, CYLINDER):
        made = boundary(geometry, cell=1.0)
        assert made.quadrature is not None
        start = made.quadrature.reference
        made.carried = np.sin(3.0 * start)
        dim = start.shape[1]
        made.extend_quadrature(np.full(dim, -9.0), np.full(dim, 9.0))
        assert len(made.carried) > 1.2 * len(start)
        distance, number = cKDTree(made.quadrature.reference).query(start)
        assert distance.max() < 1e-12
        assert made.carried[number] == pytest.approx(np.sin(3.0 * start), abs=1e-12)
        assert not np.delete(made.carried, number, axis=0).any()


def test_a_growing_circle_does_not_turn_its_tractions() -> None:
    made = boundary(CIRCLE, radius_change=0.5)
    carried = np.random.default_rng(9).uniform(-1, 1, made.carried.shape)
    pose = pose_of(made, 0.2, 0.9)
    assert rotated(carried, pose, 0) == pytest.approx(carried, abs=1e-14)
    assert rotated(carried, pose, 1) == pytest.approx(carried, abs=1e-14)


def test_factor_follows_its_table() -> None:
    made = boundary(LINE, displacement={"y": 2.0}, factor=[[0, 0], [0.5, 1], [1, -1]])
    assert [made.factor(t) for t in (0.0, 0.25, 0.5, 0.75, 1.0)] == [0.0, 0.5, 1.0, 0.0, -1.0]
    assert pose_of(made, 0.25, 0.5).increment == pytest.approx(
        np.tile([0.0, 1.0], (len(made.carried), 1))
    )  # fmt: skip
    assert boundary(LINE).factor(0.7) == 0.0


def test_a_motion_names_its_boundary(functions: str) -> None:
    made = boundary(LINE)
    entries = block_entries("plane_strain", "gimp", boundaries=[
        {"type": "implicit", "name": "base", "condition": "fixed", "geometry": LINE},
        {"type": "implicit", "name": "top", "condition": "fixed", "geometry": LINE,
         "motion": f"{functions}:lift"},
    ])  # fmt: skip
    model = Model.from_dict(entries)
    with pytest.raises(BadInput, match=r"boundaries\[1\]\.motion.*no function `lift`"):
        make_motion(model.boundaries[1], made.geometry, "boundaries[1].motion", np.ones(2))
