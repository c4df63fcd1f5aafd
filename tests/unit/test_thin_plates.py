# SPDX-License-Identifier: BSD-3-Clause
"""Contact of soil with both sides of a thin plate in it."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

import tilth
from tilth import BadInput, Model
from tilth.analysis.simulation import Simulation

STRENGTH, ADHESION, DEPTH = 1e4, 0.4, 0.5
TRACTION = ADHESION * STRENGTH


def simulation(normal: str, cell: float = 0.25, tangential: str = "adhesion", **motion: Any) -> Any:
    """Returns clay in which a thin skirt stands to DEPTH, at x = 0 (a grid line with 0.25)."""
    planes = {"base": ("y", -1.0), "left": ("x", -1.0), "right": ("x", 1.0)}
    factor = {"adhesion_factor": ADHESION} if tangential == "adhesion" else {}
    return Simulation(
        Model.from_dict(
            {
                "title": "skirt",
                "analysis": {"kind": "plane_strain"},
                "grid": {"cell_size": cell},
                "materials": {
                    "clay": {
                        "model": "tresca", "young_modulus": 1e7, "poisson_ratio": 0.3,
                        "undrained_shear_strength": STRENGTH,
                    }
                },
                "bodies": [
                    {
                        "name": "clay", "material": "clay", "basis": "gimp", "points_per_cell": 2,
                        "shape": {"type": "box", "lower": [-1.0, -1.0], "upper": [1.0, 0.0]},
                    }
                ],
                "boundaries": [
                    {"name": n, "type": "plane", "axis": a, "at": at, "condition": "fixed"}
                    for n, (a, at) in planes.items()
                ],
                "rigid_bodies": [
                    {
                        "name": "skirt", "centre": [0.0, 0.0], "rotation": 0.0,
                        "geometry": {
                            "type": "polyline", "vertices": [[0.0, 0.25], [0.0, -DEPTH]],
                            "soil": "both",
                        },
                        "contact": {"normal": normal, "tangential": tangential, **factor},
                        "displacement": {"x": 0.0, "y": 0.0, **motion},
                    }
                ],
                "schedule": {"steps": 1},
            }
        )
    )  # fmt: skip


@pytest.mark.parametrize("cell", [0.25, 0.2])
def test_a_skirt_in_intact_clay_has_adhesion_on_both_sides(cell: float) -> None:
    moved = simulation("bilateral", cell, y=-0.05)
    moved.advance(0.0, 1.0)
    force = moved.state.rigid_bodies["skirt"].force
    exact = 2.0 * TRACTION * DEPTH
    # the part of a quadrature point at the surface is measured to a 16th
    np.testing.assert_allclose(force, [0.0, exact], atol=0.01 * exact)


def test_a_skirt_that_is_pushed_aside_is_pressed_on_one_side() -> None:
    moved = simulation("unilateral", tangential="smooth", x=1e-4)
    result = moved.advance(0.0, 1.0)
    state = result.contacts["skirt"]
    pressure = -(state.weight * state.normal_stress)
    front = state.normal[:, 0] > 0.0
    assert pressure[front].sum() > 100.0
    np.testing.assert_allclose(pressure[~front].sum(), 0.0, atol=1e-3 * pressure.sum())
    force = moved.state.rigid_bodies["skirt"].force
    np.testing.assert_allclose(force, [-pressure.sum(), 0.0], rtol=1e-9, atol=1e-6)


def test_each_side_takes_over_its_own_tractions_on_another_grid() -> None:
    last, finer = (simulation("bilateral", cell, y=-0.05) for cell in (0.25, 0.125))
    last.advance(0.0, 1.0)
    before, after = last.state.contact_surfaces[0], finer.state.contact_surfaces[0]
    above = before.quadrature.surface[:, 1] > -0.2
    before.carried[above] *= np.sign(before.quadrature.normal[above, :1])
    after.carry_from(before)
    place, side = after.quadrature.surface[:, 1], np.sign(after.quadrature.normal[:, 0])
    along = after.carried[:, 1]
    chosen = (place > -0.1) & (place < -0.02)
    np.testing.assert_allclose(np.abs(along[chosen]), TRACTION, rtol=1e-9)
    np.testing.assert_array_equal(np.sign(along[chosen]), side[chosen])


# --- thin shapes that soil is to part from -------------------------------------------------------

LINE = {"type": "polyline", "vertices": [[-0.5, -0.5], [0.5, -0.5]], "soil": "both"}
PLATE = {"type": "plate", "centre": [0.0, -0.5], "normal": [0.0, 1.0], "width": 1.0}
BOX = {"type": "box", "lower": [-0.5, 0.5], "upper": [0.5, 1.0], "soil": "outside"}
UNILATERAL = {"normal": "unilateral", "tangential": "adhesion", "adhesion_factor": 1.0}
BILATERAL = {**UNILATERAL, "normal": "bilateral"}


def anchor(shape: Any, contact: Any = UNILATERAL, dim: int = 2, **changed: Any) -> dict[str, Any]:
    """Clay, 1 deep and 2 wide, with a thin body in it that is lifted."""
    entries = simulation("bilateral").setup.model.to_dict()
    lower, upper = [-1.0] * dim, [1.0] * (dim - 1) + [0.0]
    entries["bodies"][0]["shape"] = {"type": "box", "lower": lower, "upper": upper}
    base = {"name": "base", "type": "plane", "axis": "xyz"[dim - 1], "at": -1.0}
    body = {
        "name": "anchor", "contact": contact, "centre": [0.0] * dim, "wished_in_place": True,
        "geometries": shape if isinstance(shape, list) else [shape],
        "displacement": {**dict.fromkeys("xyz"[:dim], 0.0), "xyz"[dim - 1]: 0.05},
        "rotation": 0.0,
    }  # fmt: skip
    entries |= {"boundaries": [{**base, "condition": "fixed"}], "rigid_bodies": [body]}
    if dim == 3:
        body |= {"rotation": dict.fromkeys("xyz", 0.0)}
    entries["analysis"] = {"kind": "plane_strain" if dim == 2 else "3d"}
    return {**entries, **changed}


def refusal(entries: dict[str, Any]) -> str:
    with pytest.raises(BadInput) as error:
        Simulation(Model.from_dict(entries)).check()
    return str(error.value)


@pytest.mark.parametrize("shape", [LINE, PLATE, [BOX, LINE]], ids=["line", "plate", "of several"])
def test_a_unilateral_thin_shape_in_soil_is_refused(shape: Any) -> None:
    """It would hold the soil below it as a bilateral one does, at five times the force."""
    text = refusal(anchor(shape))
    for part in (
        "rigid_bodies[0]: the shape of 'anchor", "has no thickness and is in soil: at (",
        "there is 'clay' on both sides", "hardly parts from one side alone", "2 cells thick",
        'normal = "bilateral"', "a contact pair",
    ):  # fmt: skip
        assert part in text
    Simulation(Model.from_dict(anchor(shape, BILATERAL))).check()


def slot(thickness: float, contact: Any = UNILATERAL) -> dict[str, Any]:
    """A box in a slot of the clay in which it fits."""
    corners = {"lower": [-0.5, -0.25 - thickness], "upper": [0.5, -0.25]}
    entries = anchor({**BOX, **corners}, contact)
    hole = {"type": "box", **corners}
    entries["bodies"][0]["shape"]["holes"] = [hole]
    return entries


def test_a_body_thinner_than_a_cell_is_refused_and_one_below_two_warned_of() -> None:
    """On cells of 0.25 and of 0.125."""
    assert "is only 0.2 thick, 0.8 cells, and is in soil" in refusal(slot(0.2))
    warned = {0.25: True, 0.375: True, 0.5: False}
    fine = slot(0.375)
    fine["grid"] = {"cell_size": 0.125}
    cases = [(slot(thickness), is_warned) for thickness, is_warned in warned.items()]
    for entries, is_warned in [*cases, (slot(0.375, BILATERAL), False), (fine, False)]:
        texts = tilth.check(Model.from_dict(entries)).warnings
        found = [text for text in texts if "hardly parts from one side alone" in text]
        assert len(found) == is_warned
        assert all("rigid_bodies[0]: the shape of 'anchor' is only" in text for text in found)


def test_a_unilateral_thin_plate_in_space_is_refused() -> None:
    plate = {
        "type": "plate", "centre": [0.0, 0.0, -0.5], "normal": [0, 0, 1], "width": [1.0, 1.0],
        "along": [1, 0, 0],
    }  # fmt: skip
    assert "has no thickness and is in soil" in refusal(anchor(plate, dim=3))
    Simulation(Model.from_dict(anchor(plate, BILATERAL, dim=3))).check()


def test_a_unilateral_thin_boundary_in_soil_is_refused() -> None:
    entries = anchor(LINE)
    boundary = {"name": "lining", "type": "implicit", "geometry": LINE, "contact": UNILATERAL}
    entries = {**entries, "rigid_bodies": [], "boundaries": [*entries["boundaries"], boundary]}
    assert "boundaries[1]: the shape of 'lining' has no thickness" in refusal(entries)


@pytest.mark.parametrize(
    "vertices",
    [[[-0.5, 0.0], [0.5, 0.0]], [[-0.5, 0.4], [0.5, 0.4]], [[-1.0, -1.0], [-1.0, 0.0]]],
    ids=["on the soil", "above it", "beside it"],
)
def test_a_thin_shape_with_soil_on_one_side_is_taken(vertices: Any) -> None:
    entries = anchor({**LINE, "vertices": vertices}, {**UNILATERAL, "tangential": "rough"})
    entries["rigid_bodies"][0]["contact"].pop("adhesion_factor")
    Simulation(Model.from_dict(entries)).check()


def test_soil_of_two_fields_parts_from_a_thin_shape() -> None:
    """Two blocks in a contact pair with a plate between; the law with each body counts."""
    entries = anchor(LINE)
    clay = entries["bodies"][0]
    boxes = {"lower": ([-1.0, -1.0], [1.0, -0.5]), "upper": ([-1.0, -0.5], [1.0, 0.0])}
    entries["bodies"] = [
        {**clay, "name": name, "shape": {"type": "box", "lower": low, "upper": high}}
        for name, (low, high) in boxes.items()
    ]
    entries["bodies"][0]["surface"] = {}
    assert "there is 'lower' and 'upper' on both sides" in refusal(entries)
    bonded = copy.deepcopy(entries)
    bonded["rigid_bodies"][0]["contact_with"] = {"lower": BILATERAL, "upper": BILATERAL}
    Simulation(Model.from_dict(bonded)).check()
    contact = {"normal": "unilateral", "tangential": "smooth"}
    entries["contact_pairs"] = [{"name": "joint", "bodies": ["lower", "upper"], "contact": contact}]
    Simulation(Model.from_dict(entries)).check()
