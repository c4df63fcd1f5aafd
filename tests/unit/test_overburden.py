# SPDX-License-Identifier: BSD-3-Clause
"""Stress at rest under any ground surface: weights by hand, K0 by friction angle and history."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_problems import block_entries, dimension, material_entries, rollers, weight

from tilth import BadInput, Model
from tilth.arrays import Floats
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints

STRONG = {"cohesion": 500.0}
LOOSE = 1.5
"""Density of the upper layer; that of the other one is 2."""

FACTOR = [[0.0, 1.0], [1.0, 1.0]]


def ground(kind: str, shape: dict[str, Any], **entry: Any) -> dict[str, Any]:
    """A body of strong soil under its own weight, 10 per unit mass."""
    entries = block_entries(
        kind, "linear", "mohr_coulomb", boundaries=rollers(kind, sides=False),
        loads=[weight(kind, 10.0) | {"factor": FACTOR}],
    )  # fmt: skip
    entries["materials"]["soil"] = material_entries("mohr_coulomb", **STRONG)
    entries["materials"]["loose"] = material_entries("mohr_coulomb", LOOSE, **STRONG)
    entries["bodies"][0]["shape"] = shape
    entries["initial"] = {"stress": [{"type": "k0", "body": "block", "K0": 0.5, **entry}]}
    return entries


def vertical(entries: dict[str, Any], body: str = "block") -> tuple[Floats, Floats]:
    """Positions of a body's points and their vertical stress, compression positive."""
    model = Model.from_dict(entries)
    points = initial_points(model)
    own = points.of_body(body)
    return points.position[own], -points.stress[own, model.dimension - 1]


BENCH = {
    "type": "polygon",
    "vertices": [[0.0, 0.0], [6.0, 0.0], [6.0, 1.0], [4.1, 1.0], [2.1, 3.0], [0.0, 3.0]],
}


def surface_of_bench(x: Floats) -> Floats:
    return np.asarray(np.interp(x, [2.1, 4.1], [3.0, 1.0]))


@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric"])
def test_weight_under_a_slope(kind: str) -> None:
    position, stress = vertical(ground(kind, BENCH))
    depth = surface_of_bench(position[:, 0]) - position[:, 1]
    np.testing.assert_allclose(stress, 20.0 * depth, rtol=1e-13, atol=1e-12)


def test_weight_of_layers_whose_horizons_are_polylines() -> None:
    entries = ground("plane_strain", BENCH)
    horizon = [[0.0, 2.0], [6.0, 0.5]]
    body = entries["bodies"][0]
    del body["material"]
    body["layers"] = [{"material": "loose", "bottom": horizon}, {"material": "soil"}]
    position, stress = vertical(entries)
    x, y = position.T
    top, bottom = surface_of_bench(x), 2.0 - 0.25 * x
    above = np.maximum(top - np.maximum(bottom, y), 0.0)
    below = np.maximum(np.minimum(bottom, top) - y, 0.0)
    np.testing.assert_allclose(stress, 15.0 * above + 20.0 * below, rtol=1e-13, atol=1e-12)
    assert (above > 0.0).any()
    assert (below > 0.0).any()


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_other_bodies_above_have_weight(kind: str) -> None:
    """A block that will be excavated lies on half of the ground; a gap below a lid has none."""
    dim = dimension(kind)
    entries = ground(kind, {"type": "box", "lower": [0.0] * dim, "upper": [2.0] * dim})
    block, lid = dict(entries["bodies"][0]), dict(entries["bodies"][0])
    block |= {"name": "dug", "material": "loose"}
    block["shape"] = {
        "type": "box", "lower": [0.0] * (dim - 1) + [2.0], "upper": [1.0] * (dim - 1) + [4.0]
    }  # fmt: skip
    lid |= {"name": "lid"}
    lid["shape"] = {
        "type": "box", "lower": [0.0] * (dim - 1) + [5.0], "upper": [1.0] * (dim - 1) + [6.0]
    }  # fmt: skip
    entries["bodies"] += [block, lid]
    position, stress = vertical(entries)
    under = (position[:, :-1] < 1.0).all(axis=1)
    expected = 20.0 * (2.0 - position[:, -1]) + under * (30.0 + 20.0)
    np.testing.assert_allclose(stress, expected, rtol=1e-13)
    entries["initial"]["stress"][0]["body"] = "dug"
    position, stress = vertical(entries, "dug")
    np.testing.assert_allclose(stress, 20.0 + 15.0 * (4.0 - position[:, -1]), rtol=1e-13)


def test_ground_above_the_bodies_counts_as_their_soil() -> None:
    """Where nothing is declared below the ground the body goes on; what is above has no weight."""
    entries = ground("plane_strain", {"type": "box", "lower": [0.0, 0.0], "upper": [2.0, 2.0]})
    entries["initial"]["stress"][0]["ground"] = [[0.0, 4.0], [2.0, 5.0]]
    block = dict(entries["bodies"][0]) | {"name": "loose", "material": "loose"}
    block["shape"] = {"type": "box", "lower": [0.0, 3.0], "upper": [1.0, 8.0]}
    entries["bodies"].append(block)
    position, stress = vertical(entries)
    x, y = position.T
    depth = 4.0 + 0.5 * x - y
    loose = np.where(x < 1.0, 1.0 + 0.5 * x, 0.0)
    np.testing.assert_allclose(stress, 20.0 * (depth - loose) + 15.0 * loose, rtol=1e-13)


def test_weight_in_three_dimensions_under_a_grid(tmp_path: Path) -> None:
    file = tmp_path / "ground.csv"
    file.write_text("x,y,value\n0,0,2\n2,0,3\n0,2,2\n2,2,5\n")
    entries = ground("3d", {"type": "box", "lower": [0.0] * 3, "upper": [2.0] * 3})
    entries["initial"]["stress"][0]["ground"] = {"file": str(file)}
    position, stress = vertical(entries)
    x, y, z = position.T
    np.testing.assert_allclose(stress, 20.0 * (2.0 + 0.5 * x * (1.0 + y) - z), rtol=1e-13)


WATER = 9.0


def wet(level: Any, shape: dict[str, Any] = BENCH) -> dict[str, Any]:
    entries = ground("plane_strain", shape)
    entries["materials"]["soil"]["saturated_density"] = 2.3
    entries["water"] = {"level": level, "unit_weight": WATER}
    return entries


@pytest.mark.parametrize("level", [0.4, 2.1, 3.0, 4.5])
def test_effective_stress_below_the_water(level: float) -> None:
    """Saturated below the level, less the pore pressure; free water on the low ground."""
    position, stress = vertical(wet(level))
    x, y = position.T
    top = surface_of_bench(x)
    saturated = np.maximum(np.minimum(top, level) - y, 0.0)
    free = np.maximum(level - np.maximum(top, y), 0.0)
    total = 20.0 * (top - y - saturated) + 23.0 * saturated + WATER * free
    expected = total - WATER * np.maximum(level - y, 0.0)
    np.testing.assert_allclose(stress, expected, rtol=1e-12, atol=1e-12)


def test_artesian_water_is_refused() -> None:
    entries = wet(3.0)
    entries["water"]["unit_weight"] = 40.0
    with pytest.raises(BadInput, match=r"pore pressure .* exceeds the weight"):
        vertical(entries)


def at_rest(material: dict[str, Any], **entry: Any) -> MaterialPoints:
    entries = ground("plane_strain", BENCH, K0="1-sin_phi", **entry)
    entries["materials"]["soil"] = material
    return initial_points(Model.from_dict(entries))


@pytest.mark.parametrize(
    ("changed", "sine"),
    [
        (material_entries("mohr_coulomb", friction_angle=30.0, cohesion=200.0), 0.5),
        (material_entries("drucker_prager", fit="compression", cohesion=200.0), 0.5),
        # inner cone: M = 6 sin/(3 + sin) = 6/7, so sin of compression is 3 M / (6 + M) = 3/8
        (material_entries("drucker_prager", fit="extension", cohesion=200.0), 0.375),
    ],
)
@pytest.mark.parametrize("ratio", [None, 1.0, 4.0])
def test_coefficient_by_the_friction_angle(
    changed: dict[str, Any], sine: float, ratio: float | None
) -> None:
    entry = {} if ratio is None else {"overconsolidation_ratio": ratio}
    points = at_rest(changed, **entry)
    expected = (1.0 - sine) * (ratio or 1.0) ** sine
    np.testing.assert_allclose(points.stress[:, 0] / points.stress[:, 1], expected, rtol=1e-12)
    np.testing.assert_array_equal(points.stress[:, 0], points.stress[:, 2])


def test_a_friction_angle_that_varies_gives_a_coefficient_that_varies() -> None:
    soil = material_entries("mohr_coulomb", cohesion=200.0)
    soil["friction_angle"] = {"axis": "x", "values": [[0.0, 20.0], [6.0, 40.0]]}
    points = at_rest(soil)
    phi = np.radians(20.0 + 20.0 * points.position[:, 0] / 6.0)
    ratio = points.stress[:, 0] / points.stress[:, 1]
    np.testing.assert_allclose(ratio, 1.0 - np.sin(phi), rtol=1e-12)


def clay(**changed: Any) -> dict[str, Any]:
    entries = {"preconsolidation_pressure": None, "critical_state_slope": 1.2, **changed}
    return material_entries("modified_cam_clay", **entries)


def slope_of(angle: Floats) -> Floats:
    """M = q / p of Mohr and Coulomb's failure in triaxial compression, by its principal stresses.

    (s1 - s3) / (s1 + s3) = sin(phi).
    """
    major, minor = 1.0 + np.sin(np.radians(angle)), 1.0 - np.sin(np.radians(angle))
    return np.asarray((major - minor) / ((major + 2.0 * minor) / 3.0))


def check_cam_clay(points: MaterialPoints, slope: Floats, angle: Floats, ratio: float) -> None:
    """Its past stress is on the yield surface; K0 by Jaky, and by Mayne and Kulhawy since."""
    sine, vertical = np.sin(np.radians(angle)), -points.stress[:, 1]
    np.testing.assert_allclose(
        -points.stress[:, 0], (1.0 - sine) * ratio**sine * vertical, rtol=1e-12
    )
    np.testing.assert_array_equal(points.stress[:, 0], points.stress[:, 2])
    past = np.zeros((len(points), 3, 3))
    past[:, 1, 1] = -ratio * vertical
    past[:, 0, 0] = past[:, 2, 2] = (1.0 - sine) * past[:, 1, 1]
    p = -np.trace(past, axis1=1, axis2=2) / 3.0
    deviator = past + p[:, None, None] * np.eye(3)
    square = 1.5 * (deviator**2).sum(axis=(1, 2))
    found = points.state_variable("preconsolidation_pressure")
    np.testing.assert_allclose(square / (slope * p) ** 2 + 1.0, found / p, rtol=1e-12)
    assert (found > p).all()


@pytest.mark.parametrize("ratio", [1.0, 2.5, 4.0])
@pytest.mark.parametrize("angle", [12.0, 22.0, 30.0, 41.0])
def test_overconsolidation_of_cam_clay(angle: float, ratio: float) -> None:
    """With sin(phi) above and below 1/2, where it is not 1 - sin(phi)."""
    slope = slope_of(np.array(angle))
    assert (angle == 30.0) == (slope == pytest.approx(1.2))
    soil = clay(critical_state_slope=float(slope))
    check_cam_clay(at_rest(soil, overconsolidation_ratio=ratio), slope, np.array(angle), ratio)


def test_a_critical_state_slope_that_varies_varies_the_stress_at_rest() -> None:
    soil = clay(critical_state_slope={"axis": "x", "values": [[0.0, 0.6], [6.0, 1.8]]})
    points = at_rest(soil, overconsolidation_ratio=3.0)
    slope = 0.6 + 0.2 * points.position[:, 0]
    angles = np.linspace(1.0, 60.0, 591)
    angle = np.interp(slope, slope_of(angles), angles)
    for _ in range(4):  # Newton, by differences
        rate = (slope_of(angle + 1e-4) - slope_of(angle - 1e-4)) / 2e-4
        angle = angle + (slope - slope_of(angle)) / rate
    assert angle.min() < 25.0
    assert angle.max() > 35.0
    check_cam_clay(points, slope, angle, 3.0)


def test_cam_clay_at_the_ground_itself_is_refused() -> None:
    """On a slope of 45 degrees points lie on the surface, where there is no stress."""
    entries = of_material(clay(), K0="1-sin_phi", overconsolidation_ratio=4.0)
    vertices = [[0.0, 0.0], [6.0, 0.0], [6.0, 1.0], [4.0, 1.0], [2.0, 3.0], [0.0, 3.0]]
    entries["bodies"][0]["shape"] = {"type": "polygon", "vertices": vertices}
    with pytest.raises(BadInput, match=r"is not possible with this law .*at \(3.75, 1.25\)"):
        initial_points(Model.from_dict(entries))


def test_overconsolidation_with_a_given_coefficient() -> None:
    """A number for K0 stays as it is; the preconsolidation of Cam Clay follows from the ratio."""
    entries = ground("plane_strain", BENCH, K0=0.7, overconsolidation_ratio=2.0)
    entries["materials"]["soil"] = clay()
    points = initial_points(Model.from_dict(entries))
    sigma = -points.stress[:, 1]
    np.testing.assert_allclose(points.stress[:, 0], -0.7 * sigma, rtol=1e-12)
    p, q = 2.0 * sigma * 2.0 / 3.0, sigma
    found = points.state_variable("preconsolidation_pressure")
    np.testing.assert_allclose(found, p + q**2 / (1.44 * p), rtol=1e-12)


def test_each_layer_has_its_own_coefficient() -> None:
    entries = ground("plane_strain", BENCH, K0=0.5)
    body = entries["bodies"][0]
    del body["material"]
    body["layers"] = [{"material": "loose", "bottom": 1.5}, {"material": "soil"}]
    entry = entries["initial"]["stress"][0]
    entry["materials"] = {"loose": {"K0": "1-sin_phi", "overconsolidation_ratio": 4.0}}
    points = initial_points(Model.from_dict(entries))
    ratio = points.stress[:, 0] / points.stress[:, 1]
    np.testing.assert_allclose(ratio[points.layer == 0], 0.5 * 4.0**0.5, rtol=1e-12)
    np.testing.assert_allclose(ratio[points.layer == 1], 0.5, rtol=1e-12)


def two_layers(**entry: Any) -> dict[str, Any]:
    entries = ground("plane_strain", BENCH, **entry)
    body = entries["bodies"][0]
    del body["material"]
    body["layers"] = [{"material": "loose", "bottom": 1.5}, {"material": "soil"}]
    return entries


def of_material(material: dict[str, Any], **entry: Any) -> dict[str, Any]:
    entries = ground("plane_strain", BENCH, **entry)
    entries["materials"]["soil"] = material
    return entries


JAKY = {"K0": "1-sin_phi"}
FIRM = material_entries("von_mises", yield_stress=1e4)
OCR = "overconsolidation_ratio"


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        (of_material(FIRM, **JAKY), r"stress\[0\].K0.*'soil' \(von_mises\) has no friction angle"),
        (of_material(clay(), K0=0.5), r"materials.soil.overconsolidation_ratio: missing"),
        (of_material(clay(overconsolidation_ratio=2.0), K0=0.5, **{OCR: 2.0}), "preconsolidation"),
        (two_layers(**JAKY, **{OCR: 0.9}), f"{OCR} = 0.9: must be at least 1"),
        (two_layers(**{OCR: 2.0}), f"{OCR} = 2.0: is of no use for the material 'loose'"),
        (two_layers(K0="2-sin_phi"), 'K0.*must be a number or "1-sin_phi"'),
        (two_layers(K0=-0.5), "K0 = -0.5: must be greater than zero"),
        (two_layers(materials={"lose": {"K0": 0.4}}), r"materials = .lose.: .*did you mean .loose"),
        (two_layers(materials={"soil": {"K": 0.4}}), r"materials.soil.K.*unknown key"),
        (two_layers(ground=2.0), "lies above the ground, which is at 2 there"),
        (two_layers(ground=[[0.0, 4.0], [3.0, 4.0]]), "is outside the table: its x is"),
        ({**two_layers(), "loads": []}, "no body force acts at time 0"),
    ],
)  # fmt: skip
def test_wrong_stress_at_rest(entries: dict[str, Any], message: str) -> None:
    with pytest.raises(BadInput, match=f"(?s){message}"):
        initial_points(Model.from_dict(entries))


def test_a_coefficient_is_needed_for_each_material() -> None:
    entries = two_layers()
    entry = entries["initial"]["stress"][0]
    del entry["K0"]
    entry["materials"] = {"loose": {"K0": 0.4}}
    with pytest.raises(BadInput, match=r"K0: missing for the material 'soil'"):
        Model.from_dict(entries)


def test_the_soil_above_a_hole_has_no_weight_of_the_hole() -> None:
    """But the hole counts as soil under a given ground, as before it was made."""
    hole = {"type": "box", "lower": [0.5, 1.0], "upper": [1.5, 2.0]}
    shape = {"type": "box", "lower": [0.0, 0.0], "upper": [2.0, 4.0], "holes": [hole]}
    entries = ground("plane_strain", shape)
    position, stress = vertical(entries)
    x, y = position.T
    above = (x > 0.5) & (x < 1.5) & (y < 1.0)
    np.testing.assert_allclose(stress, 20.0 * (4.0 - y - above), rtol=1e-13)
    assert above.any()
    assert not above.all()
    entries["initial"]["stress"][0]["ground"] = 4.0
    np.testing.assert_allclose(vertical(entries)[1], 20.0 * (4.0 - y), rtol=1e-13)
