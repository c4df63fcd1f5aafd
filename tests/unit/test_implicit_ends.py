# SPDX-License-Identifier: BSD-3-Clause
"""Ends of held boundaries inside a cell: which vertices hold soil, and how wide a footing acts.

docs/decisions/0047-ends-inside-a-cell.md
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from implicit_blocks import flat, implicit
from mpi_runs import assert_as_serial
from small_problems import block_entries, material_entries

import tilth
from tilth import Model
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.boundaries.implicit.constraint import SurfaceConstraint
from tilth.boundaries.surfaces.ends import FARTHEST_MOTION, INSIDE, find_ends, width_of
from tilth.geometry.footing import Footing
from tilth.geometry.polyline import Polyline
from tilth.geometry.protocol import Geometry
from tilth.geometry.round import Circle

H = 0.25
HALF = 0.7
"""Half of the width of the footing [m]."""


def ends_of(geometry: Geometry) -> list[list[float]]:
    found = find_ends(geometry, geometry.facets(np.zeros(2), np.ones(2), 0.5), 0.2)
    return sorted(np.round(found.corner.reshape(-1, geometry.dim), 9).tolist())


def test_the_ends_of_a_strip() -> None:
    strip = Footing(np.array([1.0, 2.0]), np.array([0.0, -1.0]), np.array([2.0]))
    assert ends_of(strip) == [[0.0, 2.0], [2.0, 2.0]]
    found = find_ends(strip, strip.facets(np.zeros(2), np.ones(2), 0.5), 0.2)
    order = np.argsort(found.beyond[:, 0])
    np.testing.assert_allclose(found.beyond[order], [[-0.05, 2.0], [2.05, 2.0]])
    np.testing.assert_allclose(found.normal, [[0.0, -1.0]] * 2)


def test_the_ends_of_a_rectangle_are_its_outline() -> None:
    """Not the sides that its triangles have in common."""
    plate = Footing(np.zeros(3), np.array([0.0, 0.0, -1.0]), np.array([2.0, 1.0]))
    found = find_ends(plate, plate.facets(np.zeros(3), np.ones(3), 0.5), 0.2)
    edge = found.corner[:, 1] - found.corner[:, 0]
    assert np.linalg.norm(edge, axis=1).sum() == pytest.approx(6.0)
    on_outline = np.isclose(np.abs(found.corner[..., :2]), plate.half).any(axis=2)
    assert on_outline.all()


def test_what_ends_nowhere_and_what_ends_at_a_corner() -> None:
    assert ends_of(Circle(np.zeros(2), 1.0, inside=False)) == []
    bend = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.3], [3.0, 1.5]])
    assert ends_of(Polyline(bend, closed=False, left=True)) == [[0.0, 0.0], [3.0, 1.5]]
    corner = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    # an end of each of its two sides
    assert ends_of(Polyline(corner, closed=False, left=True)) == [
        [0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0],
    ]  # fmt: skip


@pytest.mark.parametrize("dim", [2, 3])
def test_distances_beyond_the_ends(dim: int) -> None:
    """Across the nearest end, positive outside, at a corner as for the ends that meet there."""
    normal = np.eye(dim)[-1]
    plate = Footing(np.zeros(dim), normal, np.ones(dim - 1))
    found = find_ends(plate, plate.facets(np.zeros(dim), np.ones(dim), 0.25), 0.2)
    place = np.zeros((4, dim))
    place[:, 0] = [0.3, 0.6, -0.45, 0.0]
    distance = found.distance(place, np.tile(normal, (4, 1)))
    np.testing.assert_allclose(distance, [-0.2, 0.1, -0.05, -0.5], atol=1e-12)
    assert (found.distance(place, np.tile(-normal, (4, 1))) == -np.inf).all()
    if dim == 3:
        corner = np.array([[0.6, 0.6, 0.0], [0.4, 0.45, 0.0]])
        distance = found.distance(corner, np.tile(normal, (2, 1)))
        np.testing.assert_allclose(distance, [0.1, -0.05], atol=1e-12)


def footing(kind: str, share: float, way: float, *, mirrored: bool = False) -> Model:
    """Half a footing on clay whose end is `share` of a cell beyond a line, pushed by `way`."""
    dim = 3 if kind == "3d" else 2
    top, size = (1.0, 1.5) if kind == "3d" else (2.0, 3.0)
    unit = np.eye(dim)
    sign = np.array([-1.0 if mirrored else 1.0, *np.ones(dim - 2)])
    far = [*(sign * size), top]
    sides = []
    for k in range(dim - 1):
        if kind != "axisymmetric":
            sides.append(implicit(f"middle {k}", flat(np.zeros(dim), sign[k] * unit[k])))
        sides.append(implicit(f"far {k}", flat(far[k] * unit[k], -sign[k] * unit[k])))
    sides.append(implicit("base", flat(np.zeros(dim), unit[-1]), "fixed"))
    shape: dict[str, Any] = {"type": "footing", "normal": (-unit[-1]).tolist()}
    shape["centre"] = (top * unit[-1]).tolist()
    shape |= {"width": 2.0 * HALF} if dim == 2 else {"width": [2.0 * HALF] * 2, "along": [1, 0, 0]}
    sides.append(implicit("footing", shape, displacement={"xyz"[dim - 1]: -way}))
    entries = block_entries(
        kind, "gimp", boundaries=sides, loads=[], schedule={"steps": 4, "outputs": 1}
    )
    entries["analysis"] |= {"tolerance": 1e-9, "solver": "auto"}
    entries["materials"] = {"soil": material_entries("von_mises", yield_stress=1.0)}
    entries["materials"]["soil"] |= {"young_modulus": 1e4, "poisson_ratio": 0.48}
    entries["bodies"][0] |= {
        "shape": {
            "type": "box",
            "lower": np.minimum(far, 0.0).tolist(),
            "upper": np.maximum(far, 0.0).tolist(),
        },
        "anti_locking": "f_bar",
    }
    origin = [*(sign * (HALF - share * H)), -0.3 * H]
    entries["grid"] |= {"cell_size": H, "origin": origin}
    return Model.from_dict(entries)


def owners(model: Model, monkeypatch: pytest.MonkeyPatch) -> tuple[float, list[int]]:
    """The force on the footing at the end, and how many patches it had in each step."""
    count: list[int] = []
    joined = SurfaceConstraint.joined

    def counted(self: SurfaceConstraint, *arguments: Any) -> Any:
        found = joined(self, *arguments)
        if self.boundary.name == "footing":
            count.append(len(np.unique(found)))
        return found

    with monkeypatch.context() as patch:
        patch.setattr(SurfaceConstraint, "joined", counted)
        force: list[float] = []
        march(model, lambda s, result, t: force.append(float(result.resultant("footing")[-1])))
    return -force[-1], count


def test_the_last_vertex_is_inside_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """On which side of the middle of the cell the end lies makes no difference."""
    force = {}
    for share in (0.0, INSIDE - 0.01, INSIDE + 0.01, 0.49, 0.51, 0.99):
        force[share], count = owners(footing("plane_strain", share, 0.1 * H), monkeypatch)
        assert len(set(count)) == 1  # the same patches in all steps
        before = share + np.arange(4)  # cells from the end to the lines before it
        held = (before >= INSIDE) & (HALF - before * H > -0.5 * H)  # half a cell past the middle
        assert count[0] == held.sum()
    assert abs(force[0.31] / force[0.29] - 1.0) < 0.02
    assert abs(force[0.51] / force[0.49] - 1.0) < 0.002
    assert np.ptp(list(force.values())) < 0.11 * np.mean(list(force.values()))


def test_after_a_long_way_soil_would_have_flowed_past_the_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, count = owners(footing("plane_strain", 0.8, 1.01 * FARTHEST_MOTION * H), monkeypatch)
    _, fewer = owners(footing("plane_strain", 0.8, 0.99 * FARTHEST_MOTION * H), monkeypatch)
    assert (set(count), set(fewer)) == ({4}, {3})


def test_a_narrow_footing_keeps_all_vertices(monkeypatch: pytest.MonkeyPatch) -> None:
    """With one patch the soil under it could turn."""
    entries = footing("plane_strain", 0.8, 0.1 * H).to_dict()
    for width, number in ((2.9 * H, 3), (3.1 * H, 2)):
        entries["boundaries"][-1]["geometry"]["width"] = width
        entries["grid"]["origin"][0] = 0.5 * width - 0.8 * H
        _, count = owners(Model.from_dict(entries), monkeypatch)
        assert set(count) == {number}


@pytest.mark.parametrize("dim", [2, 3])
def test_the_width_of_a_boundary(dim: int) -> None:
    """Its extent along its own axes; in space the lesser one."""
    normal, along = [np.array(v) for v in ((0.6, -0.8), (0.8, 0.6))] if dim == 2 else [
        np.array(v) for v in ((0.0, 0.6, -0.8), (1.0, 0.0, 0.0))
    ]  # fmt: skip
    plate = Footing(np.ones(dim), normal, np.array([2.0, 0.7][: dim - 1]), along)
    facets = plate.facets(np.zeros(dim), np.ones(dim), 0.5)
    assert width_of(facets) == pytest.approx(2.0 if dim == 2 else 0.7)


def test_a_mirrored_footing(monkeypatch: pytest.MonkeyPatch) -> None:
    force, _ = owners(footing("plane_strain", 0.8, 0.1 * H), monkeypatch)
    other, _ = owners(footing("plane_strain", 0.8, 0.1 * H, mirrored=True), monkeypatch)
    assert other == pytest.approx(force, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "processes"), [("axisymmetric", 2), ("3d", 3)])
def test_processes_have_the_same_ends(kind: str, processes: int) -> None:
    assert_as_serial(footing(kind, 0.8, 0.1 * H), processes)


@pytest.mark.parametrize(("width", "warned"), [(4.9, True), (5.1, False)])
def test_a_footing_of_a_few_cells(width: float, warned: bool) -> None:
    entries = footing("plane_strain", 0.8, 0.1 * H).to_dict()
    entries["boundaries"][-1]["geometry"]["width"] = width * H
    texts = [text for text in tilth.check(Model.from_dict(entries)).warnings if "wider" in text]
    assert len(texts) == warned
    if warned:
        assert texts[0].startswith(
            "boundaries[3].geometry.width: the boundary 'footing' is only 4.9"
        )


def test_a_platen_wider_than_the_soil_ends_nowhere_in_it() -> None:
    entries = footing("plane_strain", 0.8, 0.1 * H).to_dict()
    entries["boundaries"][-1]["geometry"]["width"] = 7.0
    simulation = Simulation(Model.from_dict(entries))
    step = simulation.prepare(0.0, 0.1)
    part = next(each for each in step.constraints.parts if each.boundary.name == "footing")
    assert isinstance(part, SurfaceConstraint)
    assert part.open_ends is not None
    assert len(part.open_ends.normal) == 0


def test_a_grid_that_follows_begins_at_the_place_and_no_origin_counts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    entries = footing("plane_strain", 0.0, 0.1 * H).to_dict()
    entries["grid"]["follow"] = {"boundary": "footing", "place": [HALF, 2.0], "axes": ["x"]}
    found = []
    for origin in (0.0, 0.11):
        entries["grid"]["origin"][0] = origin
        model = Model.from_dict(entries)
        assert model.origin == (HALF, -0.3 * H)
        found.append(owners(model, monkeypatch)[0])
    assert found[0] == found[1]
