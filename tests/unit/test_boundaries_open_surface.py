# SPDX-License-Identifier: BSD-3-Clause
"""Open surfaces of triangles and terrains as boundaries: distances, sides, borders, sliding."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from tilth import BadInput, Model, check, run
from tilth.analysis.simulation import Simulation
from tilth.bodies.stl_file import read_stl
from tilth.geometry.make import make_geometry
from tilth.geometry.open_surface import OpenSurface
from tilth.geometry.plane import Plane
from tilth.geometry.polyline import Polyline
from tilth.model.shapes import box_axes

Array = npt.NDArray[np.float64]
TURN = np.array(box_axes(3, 40.0, "x")) @ np.array(box_axes(3, 25.0, "z"))
SQUARE = np.array([[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]])
NORMAL = np.array([-np.sin(np.radians(25.0)), 0.0, np.cos(np.radians(25.0))])


def square(turn: Array = TURN) -> Array:
    """Corners of the two triangles of a turned square."""
    return (SQUARE @ turn.T)[[[0, 1, 2], [0, 2, 3]]]


def stl(file: Path, corners: Array) -> Path:
    """Writes triangles as an STL file in text."""
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex " + " ".join(f"{x!r}" for x in corner) + "\n" for corner in triangle)
        + "endloop\nendfacet\n"
        for triangle in corners.tolist()
    )
    file.write_text(f"solid surface\n{facets}endsolid surface\n")
    return file


@pytest.mark.parametrize("front", [True, False])
def test_a_square_is_a_plane_over_its_inside(front: bool) -> None:
    """Distances, gradients and facets; the side is that of the triangles' normals."""
    surface = OpenSurface.from_corners(square(), front)
    plane = Plane(np.zeros(3), TURN[:, 2] if front else -TURN[:, 2])
    x = np.random.default_rng(2).uniform(-1.9, 1.9, (400, 3)) @ TURN.T
    np.testing.assert_allclose(surface.distance(x), plane.distance(x), rtol=0, atol=1e-14)
    np.testing.assert_allclose(surface.gradient(x), plane.gradient(x), rtol=0, atol=1e-13)
    facets = surface.facets(np.zeros(3), np.ones(3), 0.5)
    np.testing.assert_allclose(facets.normal, np.tile(plane.normal, (len(facets.group), 1)))
    edge = facets.corner[:, 1:] - facets.corner[:, :1]
    area = 0.5 * np.cross(edge[:, 0], edge[:, 1])
    np.testing.assert_allclose(area.sum(axis=0), 16.0 * plane.normal, atol=1e-12)


def test_beyond_its_border() -> None:
    """There the distance is that to the border; the side is that of the plane."""
    surface = OpenSurface.from_corners(square(np.eye(3)), True)
    x = np.array(
        [[3.0, 0.5, 0.2], [3.0, 0.5, -0.2], [5.0, 6.0, 0.0], [0.1, 0.2, -1.0], [2.0, 1.0, 1.0]]
    )
    found = surface.distance(x)
    np.testing.assert_allclose(found, [np.hypot(1, 0.2), -np.hypot(1, 0.2), 5.0, -1.0, 1.0])
    assert surface.beyond_border(x, 1.1).tolist() == [0, 1]
    assert surface.beyond_border(x, 6.0).tolist() == [0, 1, 2]
    border = surface.border(0.5)
    assert len(border) == 32
    assert (np.abs(border[:, :2]).max(axis=1) == 2.0).all()


def hill(x: Array, y: Array) -> Array:
    return np.asarray(1.5 + 0.2 * x * y - 0.15 * x**2 + 0.3 * np.sin(y))


def test_a_curved_surface_against_all_its_triangles() -> None:
    """And turned about all axes: distances are those of the turned points."""
    line = np.linspace(-2.0, 2.0, 12)
    node = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1)
    place = np.dstack([node, hill(node[..., 0], node[..., 1])])
    low, right, up, far = place[:-1, :-1], place[1:, :-1], place[:-1, 1:], place[1:, 1:]
    halves = np.stack([np.stack([low, right, far], axis=2), np.stack([low, far, up], axis=2)])
    corners = halves.reshape(-1, 3, 3)
    x = np.random.default_rng(4).uniform(-2.5, 2.5, (60, 3)) + np.array([0.0, 0.0, 1.5])
    share = np.random.default_rng(5).dirichlet(np.ones(3), 1500)
    sampled = np.einsum("pc,tcx->tpx", share, corners).reshape(-1, 3)
    nearest = np.array([np.linalg.norm(sampled - each, axis=1).min() for each in x])
    surface = OpenSurface.from_corners(corners, True)
    found = surface.distance(x)
    np.testing.assert_allclose(np.abs(found), nearest, rtol=0, atol=0.015)
    inside = (np.abs(x[:, :2]) < 1.9).all(axis=1)
    above = x[:, 2] > hill(x[:, 0], x[:, 1])
    clear = inside & (np.abs(x[:, 2] - hill(x[:, 0], x[:, 1])) > 0.02)
    np.testing.assert_array_equal(found[clear] > 0.0, above[clear])
    turned = OpenSurface.from_corners(corners @ TURN.T, True)
    np.testing.assert_allclose(turned.distance(x @ TURN.T), found, rtol=0, atol=1e-13)
    np.testing.assert_allclose(
        turned.gradient(x @ TURN.T), surface.gradient(x) @ TURN.T, rtol=0, atol=1e-11
    )


def sliding(geometry: dict[str, Any], **changed: Any) -> dict[str, Any]:
    """A cube on a slope of 25 degrees with friction, thrown on its way by inertia."""
    return {
        "units": {"time": "s"},
        "analysis": {"kind": "3d", "inertia": {"scheme": "newmark"}},
        "grid": {"cell_size": 0.5},
        "materials": {
            "stone": {
                "model": "hencky_elastic", "young_modulus": 1e8, "poisson_ratio": 0.2,
                "density": 2000.0,
            }
        },
        "bodies": [
            {
                "name": "cube", "material": "stone", "basis": "gimp", "points_per_cell": 2,
                "shape": {
                    "type": "box", "lower": [0.1, -0.4, 0.1], "upper": [1.1, 0.6, 1.1],
                    "angle": -25.0, "axis": "y",
                },
            }
        ],
        "boundaries": [
            {
                "name": "slope", "type": "implicit", "geometry": geometry,
                "contact": {"normal": "unilateral", "tangential": "friction", "friction": 0.2},
                "wished_in_place": True,
            }
        ],
        "loads": [
            {"type": "body_force", "acceleration": [0, 0, -10.0], "factor": [[0, 1], [1, 1]]}
        ],
        "schedule": {"end": 0.12, "steps": 4},
        "track": [
            {"name": "x", "quantity": "reaction", "boundary": "slope", "component": "x"},
            {"name": "z", "quantity": "reaction", "boundary": "slope", "component": "z"},
        ],
        **changed,
    }  # fmt: skip


POINT = [0.1, -0.4, 0.1]


def slope(folder: Path, cuts: int) -> dict[str, Any]:
    """The plane of the slope as an STL surface of 2 cuts^2 triangles."""
    along, across = np.array([NORMAL[2], 0.0, -NORMAL[0]]), np.array([0.0, 1.0, 0.0])
    line = np.linspace(-4.0, 4.0, cuts + 1)
    place = np.array(POINT) + line[:, None, None] * along + line[None, :, None] * across
    low, right, up, far = place[:-1, :-1], place[1:, :-1], place[:-1, 1:], place[1:, 1:]
    halves = np.stack([np.stack([low, right, far], axis=2), np.stack([low, far, up], axis=2)])
    file = stl(folder / f"slope_{cuts}.stl", halves.reshape(-1, 3, 3))
    return {"type": "stl", "file": str(file), "soil": "front"}


def final(entries: dict[str, Any]) -> tuple[Array, Simulation]:
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    steps = entries["schedule"]["steps"]
    size = entries["schedule"].get("end", 1.0) / steps
    for k in range(steps):
        simulation.advance(k * size, (k + 1) * size)
    return simulation.state.points.displacement, simulation


DOWN = -np.array([NORMAL[2], 0.0, -NORMAL[0]])
ON_PLANE = {"type": "plane", "point": POINT, "normal": NORMAL.tolist()}


def slid(geometry: dict[str, Any]) -> tuple[float, float]:
    """How far the cube has slid down the slope, and moved across it."""
    moved = final(sliding(geometry))[0].mean(axis=0)
    return float(moved @ DOWN), float(np.linalg.norm(moved - (moved @ DOWN) * DOWN))


def test_a_block_slides_on_an_stl_slope_as_on_the_plane(tmp_path: Path) -> None:
    """By g (sin - mu cos) t^2 / 2, however many triangles the slope has."""
    sine, cosine = -NORMAL[0], NORMAL[2]
    expected = 10.0 * (sine - 0.2 * cosine) * 0.12**2 / 2.0
    on_plane, across = slid(ON_PLANE)
    assert on_plane == pytest.approx(expected, rel=1e-3)
    assert across < 0.01 * expected
    for cuts in (1, 5):
        down, across = slid(slope(tmp_path, cuts))
        assert down == pytest.approx(on_plane, rel=2e-4)
        assert across < 0.01 * expected


CUBE_FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


def test_slope_and_block_turned_against_the_grid(tmp_path: Path) -> None:
    """By 33 degrees about the vertical, and so about all axes; the way is that of the formula."""
    about_z = np.array(box_axes(3, 33.0, "z")).T
    own = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    axes = np.stack([-DOWN, [0.0, 1.0, 0.0], NORMAL])
    corner = (np.array(POINT) + own @ axes) @ about_z.T
    halves = [each for a, b, c, d in CUBE_FACES for each in ([a, b, c], [a, c, d])]
    body = stl(tmp_path / "cube.stl", corner[np.array(halves)])
    geometry = slope(tmp_path, 3)
    triangles = read_stl(Path(geometry["file"]), "key") @ about_z.T
    entries = sliding({**geometry, "file": str(stl(tmp_path / "turned.stl", triangles))})
    entries["bodies"][0]["shape"] = {"type": "stl", "file": str(body), "scale": 1.0}
    moved = final(entries)[0].mean(axis=0)
    expected = 10.0 * (-NORMAL[0] - 0.2 * NORMAL[2]) * 0.12**2 / 2.0
    np.testing.assert_allclose(moved @ (about_z @ DOWN), expected, rtol=0.01)
    assert np.linalg.norm(moved) == pytest.approx(expected, rel=0.01)


SMOOTH = {"normal": "unilateral", "tangential": "smooth"}


def heights(
    folder: Path, name: str, slope: float = 0.0, bump: float = 0.0, raised: float = 0.0
) -> dict[str, Any]:
    """Heights z = raised + slope x + bump x y as a CSV grid, an ESRI grid or survey points."""
    line = np.linspace(-4.0, 4.0, 9)
    table = [(x, y, raised + slope * x + bump * x * y) for x in line for y in line]
    file = folder / f"{name}.{'asc' if name == 'esri' else 'csv'}"
    if name == "esri":
        rows = [[raised + slope * x + bump * x * y for x in line] for y in line[::-1]]
        text = "\n".join(" ".join(f"{z!r}" for z in map(float, row)) for row in rows)
        head = "ncols 9\nnrows 9\nxllcenter -4\nyllcenter -4\ncellsize 1\n"
        file.write_text(f"{head}{text}\n")
    else:
        text = "\n".join(f"{x},{y},{z}" for x, y, z in table)
        file.write_text(f"x,y,{'z' if name == 'scattered' else 'value'}\n{text}\n")
    more = {"places": "scattered"} if name == "scattered" else {}
    return {"file": str(file), **more}


def terrain(surface: Any, soil: str = "above", reach: float = 3.5, dim: int = 3) -> dict[str, Any]:
    return {
        "type": "terrain", "surface": surface, "soil": soil,
        "lower": [-reach] * (dim - 1), "upper": [reach] * (dim - 1),
    }  # fmt: skip


def made(geometry: dict[str, Any], **changed: Any) -> Any:
    model = Model.from_dict(sliding(geometry, **changed))
    (boundary,) = model.boundaries
    return make_geometry(boundary, model)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["grid", "esri", "scattered"])
@pytest.mark.parametrize("soil", ["above", "below"])
def test_a_terrain_from_heights(name: str, soil: str, tmp_path: Path) -> None:
    """An inclined plane within the corners; a saddle meets the middles of its cells."""
    surface = made(terrain(heights(tmp_path, name, 0.3), soil))
    normal = np.array([-0.3, 0.0, 1.0]) / np.hypot(1.0, 0.3)
    plane = Plane(np.zeros(3), normal if soil == "above" else -normal)
    x = np.random.default_rng(3).uniform(-2.5, 2.5, (100, 3))
    np.testing.assert_allclose(surface.distance(x), plane.distance(x), rtol=0, atol=1e-12)
    assert np.abs(surface.border(0.1)[:, :2]).max() == pytest.approx(3.5, abs=1e-12)
    if name != "scattered":
        saddle = made(terrain(heights(tmp_path, name, bump=0.2), soil))
        middle = np.array([[0.5, 0.5, 0.05], [-1.5, 2.5, -0.75], [1.0, -2.0, -0.4]])
        np.testing.assert_allclose(saddle.distance(middle), 0.0, atol=1e-12)


def test_a_terrain_far_from_the_origin(tmp_path: Path) -> None:
    """Map coordinates: near places are not merged."""
    file = tmp_path / "survey.csv"
    origin = np.array([543_000.0, 5_280_000.0])
    line = np.arange(0.0, 3.01, 0.05)
    rows = [f"{origin[0] + x},{origin[1] + y},{0.1 * x:.9f}" for x in line for y in line]
    file.write_text("x,y,z\n" + "\n".join(rows) + "\n")
    geometry = terrain({"file": str(file), "places": "scattered"})
    geometry |= {"lower": (origin + 0.5).tolist(), "upper": (origin + 2.5).tolist()}
    surface = made(geometry)
    x = np.array([[1.0, 1.3, 0.1], [2.02, 0.777, 1.202]]) + np.array([*origin, 0.0])
    np.testing.assert_allclose(surface.distance(x), [0.0, 1.0 / np.hypot(1.0, 0.1)], atol=1e-6)


def test_a_terrain_in_the_plane() -> None:
    """The polyline through its heights, with the soil above; straight parts are one segment."""
    rows = [[-5.0, 1.0], [0.0, 1.0], [1.0, 2.0], [2.0, 3.0], [5.0, 3.0]]
    flat = {
        "analysis": {"kind": "plane_strain"}, "units": {},
        "bodies": [{
            "name": "cube", "material": "stone", "basis": "gimp", "points_per_cell": 2,
            "shape": {"type": "box", "lower": [0.0, 3.0], "upper": [1.0, 4.0]},
        }],
        "loads": [], "track": [],
    }  # fmt: skip
    line = made(terrain(rows, reach=4.0, dim=2), **flat)
    assert isinstance(line, Polyline)
    vertices = np.array([[-4.0, 1.0], [0.0, 1.0], [2.0, 3.0], [4.0, 3.0]])
    expected = Polyline(vertices, closed=False, left=True)
    x = np.random.default_rng(1).uniform(-3.5, 3.5, (80, 2))
    np.testing.assert_array_equal(line.distance(x), expected.distance(x))
    assert line.distance(np.array([[-3.0, 2.0], [-3.0, 0.0]])).tolist() == [1.0, -1.0]
    places = np.array([[-4.1, 1.2], [-3.9, 1.1], [4.5, 2.0], [4.2, 3.1], [9.0, 3.0], [0.0, 9.0]])
    assert line.beyond_border(places, 1.2).tolist() == [0, 2, 3]


def test_a_block_slides_on_a_terrain_as_on_the_plane(tmp_path: Path) -> None:
    """The slope of heights on a grid."""
    tangent = float(np.tan(np.radians(25.0)))
    surface = heights(tmp_path, "grid", tangent, raised=POINT[2] - tangent * POINT[0])
    assert slid(terrain(surface))[0] == pytest.approx(slid(ON_PLANE)[0], rel=2e-4)


@pytest.mark.parametrize("held", [{"condition": "fixed"}, {"contact": SMOOTH}])
def test_ground_on_curved_bedrock(held: dict[str, Any], tmp_path: Path) -> None:
    """A saddle of heights carries the whole weight of the ground whose base it is."""
    surface = heights(tmp_path, "grid", bump=0.2)
    entries = sliding(terrain(surface))
    entries["analysis"] = {"kind": "3d"}
    entries["bodies"][0]["shape"] = {
        "type": "terrain", "base": surface, "surface": 1.5, "lower": [-1, -1], "upper": [1, 1],
    }  # fmt: skip
    bedrock = {"name": "slope", "type": "implicit", "geometry": terrain(surface), **held}
    if "contact" in held:
        bedrock["wished_in_place"] = True
    sides = [
        {"name": f"{axis} {at}", "type": "plane", "axis": axis, "at": at, "condition": "roller"}
        for axis in "xy" for at in (-1.0, 1.0)
    ]  # fmt: skip
    entries |= {"boundaries": [bedrock, *sides], "schedule": {"steps": 1}}
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    step = simulation.advance(0.0, 1.0)
    weight = 2000.0 * 10.0 * simulation.state.points.initial_volume.sum()
    np.testing.assert_allclose(step.resultant("slope")[2], weight, rtol=1e-6)
    assert simulation.state.implicit[0].distance(simulation.state.points.position, 1.0).min() > 0.0


@pytest.mark.parametrize("reach", [3.5, 0.8])
def test_soil_beyond_the_border_is_warned_of(reach: float, tmp_path: Path) -> None:
    """At the start by a check, later in the run, once."""
    entries = sliding(terrain(0.0, reach=reach))
    entries["bodies"][0]["shape"] = {
        "type": "box",
        "lower": [-0.5, -0.5, 0],
        "upper": [0.5, 0.5, 1],
    }
    entries["boundaries"][0]["contact"] = {"normal": "unilateral", "tangential": "smooth"}
    entries["initial"] = {"velocity": [{"body": "cube", "x": 8.0}]}
    entries["schedule"] = {"end": 0.1, "steps": 4}
    entries["output"] = {"report": False}
    model = Model.from_dict(entries)
    run(model, tmp_path / "out", quiet=True)
    log = (tmp_path / "out" / "log.txt").read_text()
    said = log.count("soil is beyond the border of the boundary 'slope'")
    assert said == (1 if reach < 1.0 else 0)
    assert ("let boundaries[0].geometry reach further" in log) == (reach < 1.0)
    entries["bodies"][0]["shape"]["upper"] = [3.0, 0.5, 1]
    warnings = check(Model.from_dict(entries)).warnings
    assert any("beyond the border" in text for text in warnings) == (reach < 1.0)


BOWTIE = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1, 0, 0], [0, 1, 0], [1, 1, 0.0]]])
TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])[
    [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
]
FIN = np.concatenate([square(np.eye(3)), [[SQUARE[0], SQUARE[2], [0, 0, 1.0]]]])


@pytest.mark.parametrize(
    ("corners", "soil", "message"),
    [
        (square(), "outside", r"not closed: 4 edges with a triangle on one side only .*\"front\""),
        (BOWTIE, "front", "1 edges whose two triangles are turned to opposite sides"),
        (FIN, "back", "1 edges with more than two triangles"),
        (TETRAHEDRON, "front", r"the surface is closed\n.*\"inside\" or \"outside\""),
        (square(), "left", "not one of the choices"),
    ],
)
def test_wrong_surfaces(corners: Array, soil: str, message: str, tmp_path: Path) -> None:
    file = stl(tmp_path / "s.stl", corners)
    with pytest.raises(BadInput, match=f"(?s){message}"):
        made({"type": "stl", "file": str(file), "soil": soil})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"upper": [9.0, 3.0]}, "geometry.surface.file = .*: .*outside"),
        ({"upper": [1.0]}, "geometry.upper = .*: has 1 components, not one for each horizontal"),
        ({"upper": [-5.0, 3.0]}, "geometry.upper = .*: must exceed `lower`"),
        ({"soil": "left"}, "geometry.soil = .left.: not one of the choices"),
        ({"surface": [[0.0, 1.0], [2.0, 1.0]]}, "geometry.surface"),
    ],
)
def test_wrong_terrains(changes: dict[str, Any], message: str, tmp_path: Path) -> None:
    entries = {**terrain(heights(tmp_path, "grid")), **changes}
    with pytest.raises(BadInput, match=f"(?s)boundaries.0..{message}"):
        made(entries)


def rigid(geometry: dict[str, Any]) -> dict[str, Any]:
    """A plate of an open surface that comes down on a held cube."""
    entries = sliding(terrain(0.0))
    entries["analysis"] = {"kind": "3d"}
    entries["bodies"][0]["shape"] = {
        "type": "box",
        "lower": [-0.5, -0.5, 0],
        "upper": [0.5, 0.5, 1],
    }
    held = {"name": "base", "type": "plane", "axis": "z", "at": 0.0, "condition": "fixed"}
    plate = {
        "name": "plate", "geometry": geometry, "centre": [0.0, 0.0, 1.0],
        "rotation": {"x": 0.0, "y": 0.0, "z": 0.0},
        "displacement": {"x": 0.0, "y": 0.0, "z": -0.01},
        "contact": {"normal": "unilateral", "tangential": "smooth"},
    }  # fmt: skip
    track = {"name": "z", "quantity": "reaction", "boundary": "plate", "component": "z"}
    schedule = {"steps": 1}
    return entries | {
        "boundaries": [held], "rigid_bodies": [plate], "loads": [], "track": [track],
        "schedule": schedule,
    }  # fmt: skip


Geometry = Callable[[Path], dict[str, Any]]


@pytest.mark.parametrize(
    "geometry",
    [
        lambda folder: {
            "type": "stl", "soil": "back",
            "file": str(stl(folder / "p.stl", square(np.eye(3)) + np.array([0.0, 0.0, 1.0]))),
        },
        lambda folder: terrain(1.0, "below", 2.0),
    ],
)  # fmt: skip
def test_a_rigid_body_of_an_open_surface(geometry: Geometry, tmp_path: Path) -> None:
    """As a footing on the same side, to the integration on other facets; its other side is open."""
    entries = rigid(geometry(tmp_path))
    footing = {
        "type": "footing", "centre": [0.0, 0.0, 1.0], "normal": [0.0, 0.0, -1.0],
        "width": [4.0, 4.0], "along": [1.0, 0.0, 0.0],
    }  # fmt: skip
    same = {**entries, "rigid_bodies": [{**entries["rigid_bodies"][0], "geometry": footing}]}
    found, simulation = final(entries)
    expected, _ = final(same)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-3 * 0.01)
    said = check(simulation.setup.model).warnings
    assert any("has soil on one side of this" in text for text in said)
