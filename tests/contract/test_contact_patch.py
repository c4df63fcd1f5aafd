# SPDX-License-Identifier: BSD-3-Clause
"""Patch tests of contact: uniform stress passes through surfaces that cut the cells anywhere."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mesh_bodies import write

from tilth import Model
from tilth.arrays import Floats
from tilth.boundaries.contact.rotation import rotation_by
from tilth.terms.outcome import ContactState
from tilth_verification.cases import example, varied, with_basis
from tilth_verification.contact_patch import (
    PROBLEM,
    Spread,
    directions,
    spreads,
    stress_in_layer,
    turned,
)
from tilth_verification.contact_runs import run_contact

SMOOTH = {"normal": "unilateral", "tangential": "smooth"}
STICKS = {"normal": "unilateral", "tangential": "friction", "friction": 0.5}

LARGEST = 1e-3
"""Greatest deviation of a traction from uniform: ten times below the aim."""

ANGLES = (0.0, 17.0, 30.0, 45.0)


@pytest.mark.slow
@pytest.mark.parametrize("basis", ["cpdi1", "cpdi2"])
@pytest.mark.parametrize("angle", ANGLES)
def test_pressure_and_shear_are_uniform(basis: str, angle: float) -> None:
    """At once on four cells, any place; the means are those of the closed form."""
    for shift in (0.0, 0.37, 0.73):
        model = with_basis(turned(example(PROBLEM), angle, shift), basis)
        for found in spreads(model, angle, shift).values():
            for spread, exact in zip(found, stress_in_layer(), strict=True):
                assert spread.largest < LARGEST
                assert spread.mean == pytest.approx(exact, rel=1e-3)


def test_pressure_and_shear_are_uniform_at_17_degrees() -> None:
    """The short form of the above."""
    for found in spreads(turned(example(PROBLEM), 17.0, 0.37, 0.2), 17.0, 0.37).values():
        assert max(spread.largest for spread in found) < LARGEST


@pytest.mark.parametrize("angle", ANGLES)
def test_pressure_and_shear_are_uniform_on_unequal_cells(angle: float) -> None:
    """Cells of 0.08 to 0.12, and domains that follow them."""
    entries = turned(example(PROBLEM), angle, 0.37).to_dict()
    entries["grid"]["cell_size"] = {
        "x": [[0.0, 0.12], [2.5, 0.08], [6.0, 0.12]],
        "y": [[-1.0, 0.08], [1.0, 0.12], [6.0, 0.08]],
    }
    model = Model.from_dict(entries)
    for found in spreads(model, angle, 0.037 / model.cell_size[0]).values():
        for spread, exact in zip(found, stress_in_layer(), strict=True):
            assert spread.largest < LARGEST
            assert spread.mean == pytest.approx(exact, rel=1e-3)


@pytest.mark.slow
def test_the_deviation_does_not_depend_on_the_cells() -> None:
    """It is that of the quadrature in each cell; the means converge with the first order."""
    errors = []
    for cell in (0.2, 0.1, 0.05):
        found = spreads(turned(example(PROBLEM), 17.0, 0.37, cell), 17.0, 0.37)["floor"]
        assert max(spread.largest for spread in found) < LARGEST
        errors.append(abs(found[0].mean / stress_in_layer()[0] - 1.0))
    assert errors[0] / errors[2] == pytest.approx(4.0, rel=0.5)


def imbalance(angle: float, points: int) -> float:
    """Greatest nodal force that a uniform stress leaves inside a turned block of GIMP points.

    Over stress times a cell's face, by the gradients of S, hats averaged over the points' boxes.
    """
    spacing = 1.0 / points
    half = 0.5 * spacing
    lattice = (np.arange(-40, 40) + 0.5) * spacing
    place = np.stack(np.meshgrid(lattice, lattice, indexing="ij"), axis=-1).reshape(-1, 2)
    normal, tangent = directions(angle)
    place = place @ np.array([tangent, normal]) + [0.37, 0.21]

    def integral(x: Floats) -> Floats:  # of a hat, from -1
        x = x.clip(-1.0, 1.0)
        return np.where(x < 0.0, 0.5 * (x + 1.0) ** 2, 1.0 - 0.5 * (1.0 - x) ** 2)

    largest = 0.0
    for node in np.ndindex(9, 9):
        x, y = (place - np.array(node) + 4.0).T
        mean = (integral(y + half) - integral(y - half)) / spacing
        hat = (1.0 - np.abs(x + half)).clip(0.0), (1.0 - np.abs(x - half)).clip(0.0)
        largest = max(largest, abs(float(spacing * ((hat[0] - hat[1]) * mean).sum())))
    return largest


@pytest.mark.slow
@pytest.mark.parametrize(
    ("angle", "pressure", "shear"),
    [(0.0, 1e-3, 1e-3), (17.0, 0.01, 0.03), (30.0, 0.025, 0.06), (45.0, 0.025, 0.06)],
)
def test_gimp_is_uniform_as_far_as_its_boxes_tile(
    angle: float, pressure: float, shear: float
) -> None:
    """A turned block of boxes has holes and overlaps: uniform stress is no equilibrium inside.

    Shear deviates more, as it is 0.28 of the pressure.
    """
    model = with_basis(turned(example(PROBLEM), angle, 0.37), "gimp")
    model = varied(model, {"bodies.0.surface": {"spacing": 0.05}})
    for found in spreads(model, angle, 0.37).values():
        for spread, largest in zip(found, (pressure, shear), strict=True):
            assert spread.largest < largest
    assert pressure < max(2.0 * imbalance(angle, 2), 2e-3)


def test_uniform_stress_in_turned_boxes_is_no_equilibrium() -> None:
    found = [imbalance(angle, 2) for angle in ANGLES]
    np.testing.assert_allclose(found, [0.0, 0.013, 0.026, 0.050], atol=0.002)


def block_between(angle: float, shift: float, law: dict[str, Any], *, side: bool) -> Model:
    """A block 1 x 1 m, pressed by 1 % between a floor and a plate beyond its sides."""
    cell = 0.125
    normal, tangent = directions(angle)
    corner = np.array([0.43, 0.17]) + shift * cell

    def place(x: float, y: float) -> list[float]:
        return (corner + x * tangent + y * normal).tolist()

    floor = {
        "name": "floor", "type": "implicit", "contact": law, "wished_in_place": True,
        "geometry": {"type": "plane", "point": corner.tolist(), "normal": normal.tolist()},
    }  # fmt: skip
    held = {
        "name": "side", "type": "implicit", "condition": "roller",
        "geometry": {"type": "plane", "point": corner.tolist(), "normal": tangent.tolist()},
    }  # fmt: skip
    outline = [place(*at) for at in ((-0.3, 1.0), (1.3, 1.0), (1.3, 1.4), (-0.3, 1.4))]
    down = -0.01 * normal
    return Model.from_dict({
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": cell},
        "materials": {
            "stone": {"model": "hencky_elastic", "young_modulus": 1e7,
                      "poisson_ratio": 0.3 if side else 0.0}
        },
        "bodies": [
            {"name": "block", "material": "stone", "basis": "cpdi2", "points_per_cell": 2,
             "shape": {"type": "box", "lower": corner.tolist(),
                       "upper": (corner + 1.0).tolist(), "angle": angle}}
        ],
        "boundaries": [floor, held] if side else [floor],
        "rigid_bodies": [
            {"name": "plate", "contact": law, "wished_in_place": True, "centre": outline[0],
             "geometry": {"type": "polyline", "vertices": outline, "closed": True,
                          "soil": "right"},
             "displacement": {"x": down[0], "y": down[1]}, "rotation": 0.0}
        ],
        "track": [{"name": "force", "quantity": "reaction", "boundary": "floor",
                   "component": "x"}],
        "schedule": {"steps": 2},
    })  # fmt: skip


def deviation(state: ContactState) -> float:
    """The greatest deviation of the normal traction from its mean, over it."""
    pressure = -state.normal_stress[state.in_contact]
    mean = np.average(pressure, weights=state.weight[state.in_contact])
    return float(np.abs(pressure / mean - 1.0).max())


@pytest.mark.parametrize("angle", [17.0, 45.0])
@pytest.mark.parametrize("law", ["smooth", "sticks"])
def test_pressure_is_uniform_to_the_ends_of_a_block(angle: float, law: str) -> None:
    """The surfaces go on beyond the block: only what lies opposite soil counts, all of it.

    Smooth surfaces let the block widen: the force is E / (1 - nu^2) times Hencky's strain over the
    stretch. With nu = 0 it does not widen.
    """
    smooth = law == "smooth"
    nu = 0.3 if smooth else 0.0
    force = -1e7 / (1.0 - nu**2) * math.log(0.99) / 0.99
    for shift in (0.0, 0.37):
        run = run_contact(block_between(angle, shift, SMOOTH if smooth else STICKS, side=smooth))
        for name in ("floor", "plate"):
            assert deviation(run.contacts[name]) < 4e-3
        along = float(run.force["floor"][-1] @ directions(angle)[0])
        assert along == pytest.approx(force, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("basis", ["cpdi1", "cpdi2"])
def test_pressure_is_uniform_in_space(basis: str) -> None:
    """On floor and plate of a block that is turned about y, three by four by four cells."""
    cell, corner = 0.25, np.array([0.43, 0.17, 0.31])
    turn = rotation_by(np.array([0.0, math.radians(25.0), 0.0]))
    normal = turn[:, 2]
    middle = corner + turn @ [0.5, 0.5, 0.75 + 0.15]
    down = -0.01 * 0.75 * normal
    upper = (corner + np.array([1.0, 1.0, 0.75])).tolist()
    block = {
        "type": "box", "lower": corner.tolist(), "upper": upper, "angle": 25.0, "axis": "y"
    }  # fmt: skip
    model = Model.from_dict({
        "analysis": {"kind": "3d"},
        "grid": {"cell_size": cell},
        "materials": {
            "stone": {"model": "hencky_elastic", "young_modulus": 1e7, "poisson_ratio": 0.0}
        },
        "bodies": [
            {"name": "block", "material": "stone", "basis": basis, "points_per_cell": 2,
             "shape": block}
        ],
        "boundaries": [
            {"name": "floor", "type": "implicit", "contact": STICKS, "wished_in_place": True,
             "geometry": {"type": "plane", "point": corner.tolist(), "normal": normal.tolist()}}
        ],
        "rigid_bodies": [
            {"name": "plate", "contact": STICKS, "wished_in_place": True,
             "centre": middle.tolist(),
             "geometry": {"type": "plate", "centre": middle.tolist(), "normal": normal.tolist(),
                          "along": turn[:, 0].tolist(), "width": [1.4, 1.4], "thickness": 0.3},
             "displacement": dict(zip("xyz", down.tolist(), strict=True)),
             "rotation": {"x": 0.0, "y": 0.0, "z": 0.0}}
        ],
        "track": [{"name": "force", "quantity": "reaction", "boundary": "floor",
                   "component": "x"}],
        "schedule": {"steps": 2},
    })  # fmt: skip
    run = run_contact(model)
    exact = -1e7 * math.log(0.99) / 0.99
    assert float(run.force["floor"][-1] @ normal) == pytest.approx(exact, rel=2e-3)
    for name in ("floor", "plate"):
        assert deviation(run.contacts[name]) < 0.01


INNER, OUTER, CENTRE = 1.0, 1.8, np.array([0.03, 0.07])
LOAD = 1e4


def ring_on_a_core(cell: float, path: Path) -> Model:
    """A ring of CPDI2 points around a rigid core, under an outer pressure.

    The friction is next to nothing: only against rotation.
    """
    radial, around = round((OUTER - INNER) * 2 / cell), round(4.0 * np.pi * INNER / cell)
    angle = np.arange(around) * 2.0 * np.pi / around
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    nodes = CENTRE + np.concatenate([r * circle for r in np.linspace(INNER, OUTER, radial + 1)])
    first = np.arange(around) + around * np.arange(radial)[:, None]
    after = np.roll(first, -1, axis=1)
    quads = np.stack([first, first + around, after + around, after], axis=-1).reshape(-1, 4)
    start = nodes[-around].tolist()
    return Model.from_dict({
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": cell},
        "materials": {
            "rubber": {"model": "hencky_elastic", "young_modulus": 1e7, "poisson_ratio": 0.3}
        },
        "bodies": [
            {"name": "ring", "material": "rubber", "basis": "cpdi2", "points_per_cell": 2,
             "shape": {"type": "mesh", "file": str(write(path, nodes, [("quad", quads)]))},
             "surface": {"spacing": 2.0 * cell}}
        ],
        "boundaries": [
            {"name": "core", "type": "implicit", "wished_in_place": True,
             "contact": {"normal": "unilateral", "tangential": "friction", "friction": 1e-4},
             "geometry": {"type": "circle", "centre": CENTRE.tolist(), "radius": INNER,
                          "soil": "outside"}}
        ],
        "loads": [{"type": "surface", "body": "ring", "start": start, "end": start,
                   "pressure": LOAD}],
        "track": [{"name": "force", "quantity": "reaction", "boundary": "core",
                   "component": "x"}],
        "schedule": {"steps": 2},
    })  # fmt: skip


@pytest.mark.slow
def test_pressure_of_a_ring_on_a_rigid_core(tmp_path: Path) -> None:
    """Lame: 2 (1 - nu) times the load over 1 + (1 - 2 nu) (a / b)^2; strains of 1e-3.

    The soil's displacement is curved and so is the surface: the pressure converges with the first
    order, its mean with the second.
    """
    nu = 0.3
    exact = 2.0 * (1.0 - nu) * LOAD / (1.0 + (1.0 - 2.0 * nu) * (INNER / OUTER) ** 2)
    means, variations = [], []
    for cell in (0.1, 0.05):
        state = run_contact(ring_on_a_core(cell, tmp_path / "ring.msh")).contacts["core"]
        assert state.in_contact.all()
        spread = Spread.of(-state.normal_stress, state.weight)
        means.append(abs(spread.mean / exact - 1.0))
        variations.append(spread.variation)
    assert means[0] < 1e-3
    assert means[1] < 2.5e-4
    assert variations[1] < 0.01
    assert math.log2(variations[0] / variations[1]) > 0.8
