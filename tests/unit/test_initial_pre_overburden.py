# SPDX-License-Identifier: BSD-3-Clause
"""Stress at rest of soil that bore more in the past: OCR, POP, and elastic unloading from K0_nc."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_problems import block_entries, material_entries, rollers, weight

from tilth import BadInput, Model
from tilth.arrays import Floats
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.report.initial import initial_stress

SAND = material_entries("mohr_coulomb", 1.8, friction_angle=30.0, cohesion=500.0)
HEIGHT, WATER = 8.0, 10.0
OCR, POP = "overconsolidation_ratio", "pre_overburden_pressure"


def column(kind: str = "plane_strain", material: Any = SAND, **entry: Any) -> dict[str, Any]:
    """Level ground, 8 high, with the density 1.8 and gravity 10."""
    up = 3 if kind == "3d" else 2
    entries = block_entries(
        kind, "linear", "mohr_coulomb", boundaries=rollers(kind, sides=False),
        loads=[weight(kind, 10.0) | {"factor": [[0.0, 1.0], [1.0, 1.0]]}],
    )  # fmt: skip
    entries["materials"] = {"soil": material}
    entries["bodies"][0]["shape"] = {
        "type": "box", "lower": [0.0] * up, "upper": [1.0] * (up - 1) + [HEIGHT]
    }  # fmt: skip
    entries["initial"] = {"stress": [{"type": "k0", "body": "block", **entry}]}
    return entries


def made(entries: dict[str, Any]) -> tuple[MaterialPoints, Floats, Floats, Floats]:
    """Points, their depths, and vertical and horizontal pressures."""
    points = initial_points(Model.from_dict(entries))
    up = points.position.shape[1] - 1
    across = points.stress[:, [0, 2] if up == 1 else [0, 1]]
    np.testing.assert_array_equal(across[:, 0], across[:, 1])
    return points, HEIGHT - points.position[:, -1], -points.stress[:, up], -across[:, 0]


def require(found: Floats, depth: Floats, by_hand: dict[float, float]) -> None:
    """Values at some depths, to the digits that they are written with."""
    for at, value in by_hand.items():
        here = np.isclose(depth, at)
        assert here.any()
        np.testing.assert_allclose(found[here], value, rtol=2e-5)


@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric", "3d"])
def test_pre_overburden_of_dry_sand(kind: str) -> None:
    """By hand: OCR = (18 d + 20) / (18 d) and K0 = 0.5 sqrt(OCR), where that is at most Kp = 3.

    At the depth 0.25: 4.5, OCR 5.4444, K0 1.16667; at 3.75: 67.5, 1.296296, 0.569275.
    """
    _, depth, vertical, lateral = made(column(kind, K0="1-sin_phi", **{POP: 20.0}))
    require(vertical, depth, {0.25: 4.5, 3.75: 67.5})
    require(lateral, depth, {0.25: 5.25, 3.75: 38.42607, 7.75: 74.58259})
    np.testing.assert_allclose(lateral, 0.5 * np.sqrt(vertical * (vertical + 20.0)), rtol=1e-12)


@pytest.mark.parametrize(
    ("level", "by_hand"), [(5.0, {3.25: 56.5, 3.75: 61.5}), (10.0, {3.25: 32.5, 3.75: 37.5})]
)
def test_pre_overburden_with_water(level: float, by_hand: dict[float, float]) -> None:
    """The past stress is an effective one; water stands in the ground, or 2 above it.

    By hand with the saturated density 2: at the depth 3.25, 0.25 below the level of 5,
    18 x 3 + (20 - 10) x 0.25 = 56.5; under free water (20 - 10) x 3.25 = 32.5.
    """
    entries = column(K0="1-sin_phi", **{POP: 40.0})
    entries["materials"]["soil"] = {**SAND, "saturated_density": 2.0}
    entries["water"] = {"level": level, "unit_weight": WATER}
    _, depth, vertical, lateral = made(entries)
    require(vertical, depth, by_hand)
    expected = {at: 0.5 * np.sqrt(value * (value + 40.0)) for at, value in by_hand.items()}
    require(lateral, depth, expected)


def test_each_layer_has_its_own_past() -> None:
    """POP 30 of the upper 3 m, OCR 2 of what is below, K0_nc 0.6 with Poisson's ratio 0.3 there.

    By hand: at 2.75 49.5 and 0.5 sqrt(49.5 x 79.5) = 31.3658; at 3.25 58.5 and
    0.6 x 117 - 3/7 x 58.5 = 45.1286.
    """
    entries = column(K0="1-sin_phi", **{POP: 30.0})
    entries["materials"]["low"] = material_entries("hencky_elastic", 1.8, poisson_ratio=0.3)
    body = entries["bodies"][0]
    del body["material"]
    body["layers"] = [{"material": "soil", "bottom": HEIGHT - 3.0}, {"material": "low"}]
    entries["initial"]["stress"][0]["materials"] = {"low": {"K0_nc": 0.6, OCR: 2.0}}
    _, depth, _, lateral = made(entries)
    require(lateral, depth, {2.75: 31.36579, 3.25: 45.12857, 7.75: 139.5 * (1.2 - 3.0 / 7.0)})
    words = initial_stress(Model.from_dict(entries).initial.stress[0], Model.from_dict(entries))
    assert "K0 1-sin_phi (POP 30 Pa) of soil, K0_nc 0.6 (OCR 2) of low" in words


@pytest.mark.parametrize("coefficient", [0.45, "1-sin_phi"])
def test_elastic_unloading(coefficient: Any) -> None:
    """K0_nc (sigma_v + POP) - nu / (1 - nu) POP, at most Kp sigma_v; nu = 0.25, so a third of POP.

    By hand with 0.45: at 0.25 0.45 x 124.5 - 40 = 16.025, more than 3 x 4.5 = 13.5.
    """
    soil = {**SAND, "poisson_ratio": 0.25}
    _, depth, vertical, lateral = made(column(material=soil, K0_nc=coefficient, **{POP: 120.0}))
    first = 0.5 if coefficient == "1-sin_phi" else coefficient
    expected = np.minimum(first * (vertical + 120.0) - 40.0, 3.0 * vertical)
    np.testing.assert_allclose(lateral, expected, rtol=1e-12)
    require(lateral, depth, {0.25: 13.5})
    if first == 0.45:
        require(lateral, depth, {0.75: 20.075, 7.75: 76.775})


def test_the_strength_bounds_the_coefficient() -> None:
    """Sand without cohesion: the stress just below the ground is on the yield surface."""
    sand = {**SAND, "cohesion": 0.0}
    _, depth, vertical, lateral = made(column(material=sand, K0="1-sin_phi", **{POP: 200.0}))
    expected = np.minimum(0.5 * np.sqrt(vertical * (vertical + 200.0)), 3.0 * vertical)
    np.testing.assert_allclose(lateral, expected, rtol=1e-12)
    require(lateral, depth, {0.25: 13.5, 0.75: 26.84330})


CLAY = material_entries(
    "modified_cam_clay", 1.8, preconsolidation_pressure=None, critical_state_slope=1.2
)


@pytest.mark.parametrize(
    ("entry", "first"),
    [({"K0": "1-sin_phi"}, 0.5), ({"K0": 0.8}, 0.5), ({"K0_nc": 0.7}, 0.7)],
)
def test_preconsolidation_of_cam_clay(entry: dict[str, Any], first: float) -> None:
    """The tip of the ellipse through sigma_v + POP, and the coefficient of first loading sideways.

    M = 1.2 is a friction angle of 30 degrees. By hand at 3.75 with 0.5: the past 107.5 has
    p = 71.6667 and q = 53.75, so 71.6667 + 53.75^2 / (1.44 x 71.6667) = 99.6615.
    """
    clay = {**CLAY, "poisson_ratio": 0.1, "shear_modulus": None} if "K0_nc" in entry else CLAY
    clay = {key: value for key, value in clay.items() if value is not None}
    points, depth, vertical, lateral = made(column(material=clay, **entry, **{POP: 40.0}))
    past = vertical + 40.0
    p, q = past * (1.0 + 2.0 * first) / 3.0, past * (1.0 - first)
    found = points.state_variable("preconsolidation_pressure")
    np.testing.assert_allclose(found, p + q**2 / (1.44 * p), rtol=1e-9)
    if first == 0.5:
        require(found, depth, {3.75: 99.66146})
    expected = {
        "1-sin_phi": np.minimum(0.5 * np.sqrt(vertical * past), 3.0 * vertical),
        0.8: 0.8 * vertical,
        0.7: np.minimum(0.7 * past - 40.0 / 9.0, 3.0 * vertical),
    }
    (given,) = entry.values()
    np.testing.assert_allclose(lateral, expected[given], rtol=1e-12)


@pytest.mark.parametrize("key", [OCR, POP])
def test_fields_of_depth(key: str) -> None:
    """In the forms of material parameters: rows of depth, a function of the user."""
    values = [[0.0, 4.0], [4.0, 2.0], [8.0, 1.0]] if key == OCR else [[0.0, 0.0], [8.0, 80.0]]
    field = {"depth": values, "surface": HEIGHT}
    _, depth, vertical, lateral = made(column(K0="1-sin_phi", **{key: field}))
    at = np.interp(depth, *np.array(values).T)
    ratio = at if key == OCR else 1.0 + at / vertical
    np.testing.assert_allclose(lateral, 0.5 * np.sqrt(ratio) * vertical, rtol=1e-12)


def test_a_function_is_named_before_it_runs(tmp_path: Path) -> None:
    file = tmp_path / "past.py"
    file.write_text("def past(position):\n    return 10.0 + 0.0 * position[:, 0]\n")
    entries = column(K0=0.5)
    entries["materials"]["soil"] = CLAY | {"preconsolidation_pressure": None}
    entries["materials"]["soil"].pop("preconsolidation_pressure")
    entries["initial"]["stress"][0]["materials"] = {"soil": {POP: f"{file}:past"}}
    assert Model.from_dict(entries).functions == (f"{file}:past",)
    points, _, vertical, _ = made(entries)
    past = vertical + 10.0
    expected = past * (2.0 / 3.0 + 0.25 / (1.44 * 2.0 / 3.0))
    np.testing.assert_allclose(points.state_variable("preconsolidation_pressure"), expected)


ELASTIC = material_entries("hencky_elastic", 1.8)
BY_DEPTH = {"depth": [[0.0, 2.0], [8.0, 0.5]], "surface": HEIGHT}


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        (column(K0="1-sin_phi", **{OCR: 2.0, POP: 1.0}), f"{POP} = 1.0: is given together with"),
        (column(K0=0.5, K0_nc=0.5, **{OCR: 2.0}), "K0_nc = 0.5: is given together with `K0`"),
        (column(K0=0.5, materials={"soil": {OCR: 2.0, POP: 1.0}}), f"soil.{POP} = 1.0: is"),
        (column(K0=0.5, **{POP: 20.0}), f"{POP} = 20.0: is of no use for the material 'soil'"),
        (column(K0=0.5, materials={"soil": {POP: 20.0}}), f"materials.soil.{POP} = 20.0: is of no"),
        (column(K0="1-sin_phi", **{POP: -1.0}), f"{POP} = -1.0: must not be negative"),
        (column(K0_nc=0.5), "K0_nc = 0.5: no overconsolidation of the material 'soil' is given"),
        (column(material=ELASTIC, K0_nc="1-sin_phi", **{POP: 1.0}), "K0_nc = .*no friction angle"),
        (column(material=CLAY, K0_nc=0.5, **{POP: 1.0}), "K0_nc = 0.5: .*no Poisson's ratio"),
        (column(**{POP: 20.0}), "K0: missing for the material 'soil'"),
        (column(K0="1-sin_phi", **{OCR: BY_DEPTH}), f"{OCR} = 0.5.*: must be at least 1, at"),
        (column(K0="1-sin_phi", pop=20.0), f"pop: unknown key|known keys: .*{POP}"),
    ],
)  # fmt: skip
def test_wrong_entries(entries: dict[str, Any], message: str) -> None:
    entries["materials"]["soil"] = {
        key: value for key, value in entries["materials"]["soil"].items() if value is not None
    }
    with pytest.raises(BadInput, match=f"(?s){message}"):
        initial_points(Model.from_dict(entries))
