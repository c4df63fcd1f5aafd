# SPDX-License-Identifier: BSD-3-Clause
"""The surface of a body that moves as it is told, against the exact outline: errors and rates."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tilth import Model
from tilth.analysis.march import march
from tilth.arrays import Floats
from tilth.boundaries.affine import Affine
from tilth.boundaries.protocol import Prescribed
from tilth.curves import Chain
from tilth.mpm.active_grid import ActiveGrid
from tilth.surface.tracked import TrackedSurface
from tilth_verification.pressure_cantilever import mean_distance

ROTATION = np.array([[0.0, -1.0], [1.0, 0.0]])
SHEAR = np.array([[1.0, 2.0], [0.0, 1.0]])
CENTRE = np.array([1.3, 1.3])
BOX = {"type": "box", "lower": [0.3, 0.3], "upper": [2.3, 2.3]}
DISC = {"type": "circle", "centre": CENTRE.tolist(), "radius": 1.0}

every_motion = pytest.mark.parametrize("end", [ROTATION, SHEAR], ids=["rotation", "shear"])


def moved(shape: dict[str, Any], end: Floats, **changed: Any) -> Chain:
    """The surface of a body after an affine motion of all nodes, by default on 10 cells a side."""
    settings = {"h": 0.2, "steps": 20, "points_per_cell": 2, "surface": {}, **changed}
    path = "exponential" if end is ROTATION else "linear"
    body = {
        "name": "block",
        "material": "soil",
        "shape": shape,
        "basis": "linear",
        "points_per_cell": settings["points_per_cell"],
        "surface": settings["surface"],
    }
    elastic = {"model": "hencky_elastic", "young_modulus": 1.0, "poisson_ratio": 0.3}
    drive = {
        "type": "affine", "name": "drive", "deformation_gradient": end.tolist(), "path": path,
    }  # fmt: skip
    model = Model.from_dict(
        {
            "analysis": {"kind": "plane_strain"},
            "grid": {"cell_size": settings["h"]},
            "materials": {"soil": elastic},
            "bodies": [body],
            "boundaries": [drive],
            "schedule": {"steps": settings["steps"]},
        }
    )
    surface = march(model).state.surfaces["block"]
    assert isinstance(surface, TrackedSurface)
    (chain,) = surface.chains
    return chain.current


def box_outline(parts: int = 400) -> Floats:
    """Places along the box's outline, anticlockwise and closed, shape (4 parts + 1, 2)."""
    corners = np.array([[0.3, 0.3], [2.3, 0.3], [2.3, 2.3], [0.3, 2.3], [0.3, 0.3]])
    at = np.arange(4 * parts + 1) / parts
    return np.stack([np.interp(at, np.arange(5), x) for x in corners.T], axis=1)


def disc_outline(parts: int = 1600) -> Floats:
    """Places along the disc's outline, shape (parts + 1, 2)."""
    angle = 2.0 * np.pi * np.arange(parts + 1) / parts
    return CENTRE + np.stack([np.cos(angle), np.sin(angle)], axis=1)


@every_motion
@pytest.mark.parametrize("changed", [{}, {"h": 0.13}, {"steps": 7}, {"surface": {"spacing": 0.3}}])
def test_a_block_keeps_its_outline_in_an_affine_motion(end: Floats, changed: Any) -> None:
    """To round-off on any grid, with any spacing and steps: straight edges and corners stay."""
    chain = moved(BOX, end, **changed)
    assert mean_distance(chain, box_outline() @ end.T) < 1e-13
    assert chain.corner.sum() == 4
    corners = box_outline(1)[:4] @ end.T
    np.testing.assert_allclose(chain.points[chain.corner], corners, rtol=0, atol=1e-13)


@every_motion
def test_a_disc_keeps_its_outline_to_fourth_order_in_the_spacing(end: Floats) -> None:
    """Its spline is of fourth order, also through points inserted between the others."""
    exact = disc_outline() @ end.T
    chains = [moved(DISC, end, surface={"spacing": s}) for s in (0.2, 0.1, 0.05)]
    error = np.array([mean_distance(chain, exact) for chain in chains])
    assert (np.log2(error[:-1] / error[1:]) > 3.5).all()
    assert error[-1] < 1e-6
    if end is SHEAR:  # 2.4 times as long in one direction
        assert len(chains[-1]) > 1.2 * 2.0 * np.pi / 0.05


@every_motion
def test_the_outer_layer_lies_half_a_spacing_inside(end: Floats) -> None:
    """First order in the points' distance, where extra points have no error at all."""
    error = np.array(
        [
            mean_distance(
                moved(BOX, end, points_per_cell=n, surface={"points": "outer_layer"}),
                box_outline() @ end.T,
            )
            for n in (2, 4, 8)
        ]
    )
    np.testing.assert_allclose(np.log2(error[:-1] / error[1:]), 1.0, atol=0.15)
    if end is ROTATION:
        np.testing.assert_allclose(error, 0.2 / np.array([4, 8, 16]), rtol=0.1)


def turned(place: Floats, time: float) -> Floats:
    """Places turned about the centre by an angle that falls with the radius: it keeps areas."""
    arm = place - CENTRE
    angle = 0.5 * np.pi * time * np.exp(-(arm**2).sum(axis=1) / 2.0)
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = arm.T
    return CENTRE + np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)


def swirl(self: Affine, active: ActiveGrid, before: float, after: float) -> Prescribed:
    """Prescribes `turned` on all nodes in place of an affine motion."""
    increment = turned(active.position, after - before) - active.position
    return Prescribed(np.ones(increment.shape, dtype=bool), increment)


@pytest.fixture
def swirling(monkeypatch: pytest.MonkeyPatch) -> Callable[..., float]:
    """A block in a swirl: mean distance of its surface from the exact outline [length]."""
    monkeypatch.setattr(Affine, "prescribe", swirl)

    def error(**changed: Any) -> float:
        return mean_distance(moved(BOX, ROTATION, **changed), turned(box_outline(), 1.0))

    return error


def test_a_swirl_is_followed_to_second_order_in_the_cells(swirling: Callable[..., float]) -> None:
    """The grid's displacement is of second order, however many steps it is divided into."""
    error = np.array([swirling(h=h, steps=20) for h in (0.4, 0.2, 0.1)])
    assert (np.log2(error[:-1] / error[1:]) > 1.8).all()
    assert error[-1] < 2e-3
    assert swirling(h=0.2, steps=40) == pytest.approx(error[1], rel=0.1)
    outer = swirling(h=0.1, surface={"points": "outer_layer"})
    assert outer > 5.0 * error[-1]
