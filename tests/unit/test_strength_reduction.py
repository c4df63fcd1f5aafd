# SPDX-License-Identifier: BSD-3-Clause
"""The search for the factor of safety, on blocks whose collapse is known exactly.

A block in plane strain between smooth plates, free at one side, under the pressure p: with c and
phi it fails at p = 2 c tan(45 + phi / 2).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from tilth import AnalysisFailed, BadInput, Model, StrengthReduction
from tilth.analysis.march import march
from tilth.analysis.safety import SafetyResult, strength_reduction
from tilth.analysis.safety_search import Outcome, Search, Trial
from tilth.analysis.simulation import Simulation
from tilth.mpm.frozen_points import thickness
from tilth_verification.cases import varied

PRESSURE = 20.0
LAWS: dict[str, dict[str, Any]] = {
    "tresca": {"model": "tresca", "undrained_shear_strength": 14.0},
    "von_mises": {"model": "von_mises", "undrained_shear_strength": 14.0, "hardening_modulus": 0.0},
    "mohr_coulomb": {
        "model": "mohr_coulomb", "cohesion": 9.0, "friction_angle": 25.0, "dilation_angle": 25.0,
    },
    "drucker_prager": {
        "model": "drucker_prager", "cohesion": 9.0, "friction_angle": 25.0, "dilation_angle": 25.0,
        "fit": "plane_strain",
    },
}  # fmt: skip


def block(law: dict[str, Any], **changes: Any) -> Model:
    elastic = {"young_modulus": 1e4, "poisson_ratio": 0.3, "density": 1.0}
    entries = {
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": 0.5},
        "materials": {"soil": {**elastic, **law}},
        "bodies": [
            {
                "name": "block",
                "material": "soil",
                "shape": {"type": "box", "lower": [0.0, 0.0], "upper": [1.0, 1.0]},
                "basis": "gimp",
                "points_per_cell": 2,
                "surface": {},
            }
        ],
        "boundaries": [
            {"name": name, "type": "plane", "axis": axis, "at": 0.0, "condition": "roller"}
            for name, axis in (("left", "x"), ("below", "y"))
        ],
        "loads": [
            {
                "type": "surface", "body": "block", "start": [1.0, 1.0], "end": [0.0, 1.0],
                "pressure": PRESSURE,
            }
        ],
        "schedule": {"steps": 2},
    }  # fmt: skip
    return varied(Model.from_dict(entries), changes)


def reduced(model: Model, simulation: Simulation | None = None, **settings: Any) -> SafetyResult:
    return strength_reduction(
        simulation or march(model), model.schedule.end, StrengthReduction(**settings)
    )


def exact_factor(law: dict[str, Any]) -> float:
    if "undrained_shear_strength" in law:
        return float(2.0 * law["undrained_shear_strength"] / PRESSURE)
    c, tangent = law["cohesion"], math.tan(math.radians(law["friction_angle"]))

    def excess(factor: float) -> float:
        phi = math.atan(tangent / factor)
        return 2.0 * c / factor * math.tan(math.pi / 4 + phi / 2) - PRESSURE

    return float(brentq(excess, 0.1, 10.0))


@pytest.mark.parametrize("law", LAWS)
def test_exact_collapse_of_a_block(law: str) -> None:
    result = reduced(block(LAWS[law]), tolerance=0.001)
    exact = exact_factor(LAWS[law])
    assert result.above - result.factor <= 0.001 * (1 + 1e-9)
    assert result.factor - 0.002 <= exact <= result.above + 0.002
    assert result.trials[-1].factor == result.above
    assert not result.trials[-1].in_equilibrium


def test_the_state_does_not_change() -> None:
    model = block(LAWS["mohr_coulomb"])
    simulation = march(model)
    before = {name: each.copy() for name, each in simulation.state.arrays().items()}
    points = simulation.state.points
    first = reduced(model, simulation)
    assert simulation.state.points is points
    after = simulation.state.arrays()
    assert before.keys() == after.keys()
    for name, each in before.items():
        np.testing.assert_array_equal(after[name], each, err_msg=name)
    assert reduced(model, simulation).trials[-1].factor == first.trials[-1].factor


def test_displacements_are_those_of_the_declared_stiffness_to_first_order() -> None:
    """Tresca's block does not move until it yields everywhere; with hardening it then does."""
    hardening = {**LAWS["von_mises"], "hardening_modulus": 100.0}
    model = block(hardening, **{"analysis.tolerance": 1e-12})
    result = reduced(model, maximum_factor=2.0, displacement_ratio=40.0, tolerance=0.001)
    moved = {trial.factor: trial.displacement for trial in result.trials}
    factor = max(f for f, u in moved.items() if f < result.above and not math.isnan(u))
    # uniaxial in plane strain: sqrt(3)/2 p = (sigma_0 + H e_p) / F, e_y = sqrt(3)/2 e_p
    strength = math.sqrt(3.0) * 14.0
    plastic = (factor * math.sqrt(0.75) * PRESSURE - strength) / 100.0
    strain = math.sqrt(0.75) * plastic  # the farthest point is at (0.875, 0.875)
    assert moved[factor] == pytest.approx(math.hypot(strain, strain) * 0.875, rel=0.01)
    assert result.plastic_strain == pytest.approx(plastic, rel=0.03)


def test_the_factor_does_not_depend_on_the_stiffness() -> None:
    """On the frozen geometry even soft soil, which is compressed by percents, keeps its shape."""
    for young in (2e3, 1e4, 1e7):
        model = block(LAWS["tresca"], **{"materials.soil.young_modulus": young})
        result = reduced(model, tolerance=0.001)
        assert result.factor == pytest.approx(1.4, rel=0.01)


def test_a_factor_below_one() -> None:
    """A state that stronger soil had: its soil is replaced by one that is too weak for it."""
    strong = march(block(LAWS["tresca"]))
    weak = block({**LAWS["tresca"], "undrained_shear_strength": 6.0})
    simulation = Simulation.restored(weak, strong.state.arrays())
    result = reduced(weak, simulation, tolerance=0.002)
    assert result.trials[0].factor == 1.0
    assert not result.trials[0].in_equilibrium
    assert result.factor == pytest.approx(0.6, abs=0.004)
    with pytest.raises(AnalysisFailed, match=r"even at the factor 0\.7, the least one"):
        reduced(weak, simulation, minimum_factor=0.7)


def test_far_from_failure_the_steps_grow() -> None:
    model = block({**LAWS["tresca"], "undrained_shear_strength": 150.0})
    result = reduced(model)
    assert result.factor == pytest.approx(15.0, abs=0.03)
    assert len(result.trials) < 30
    with pytest.raises(AnalysisFailed, match="equilibrium up to the factor 5, the greatest"):
        reduced(model, maximum_factor=5.0)


def test_all_elastic_and_cam_clay_are_errors() -> None:
    elastic = {"model": "hencky_elastic"}
    with pytest.raises(BadInput, match="nothing can fail"):
        reduced(block(elastic))
    cam_clay = {
        "model": "modified_cam_clay", "compression_index": 0.1, "swelling_index": 0.02,
        "critical_state_slope": 1.0, "shear_modulus": 1e3, "overconsolidation_ratio": 1.5,
    }  # fmt: skip
    model = block(LAWS["tresca"])
    entries = model.to_dict()
    entries["materials"]["soil"] = {**cam_clay, "density": 1.0}
    entries["initial"] = {
        "stress": [{"body": "block", "type": "given", "stress": [-20.0, -20.0, -20.0, 0.0]}]
    }
    with pytest.raises(BadInput, match=r"materials\.soil\.model = .* cannot be reduced"):
        strength_reduction(Simulation(Model.from_dict(entries)), 0.0)


def test_soil_without_stress_is_an_error() -> None:
    with pytest.raises(BadInput, match="without stress"):
        strength_reduction(Simulation(block(LAWS["tresca"])), 0.0)


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        ({"tolerance": 0.0}, "greater than zero"),
        ({"tolerance": 1e-6}, "at least 0.0001"),
        ({"minimum_factor": 2.0}, "at most `start`"),
        ({"maximum_factor": 0.5}, "at least `start`"),
        ({"start": -1.0}, "greater than zero"),
    ],
)
def test_wrong_settings(entries: dict[str, float], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        StrengthReduction(**entries)


def test_a_failure_from_far_below_is_tried_again() -> None:
    """The search does not believe a failure of a large step."""
    search = Search(StrengthReduction(tolerance=0.01))
    refused = {1.2}  # once, although the soil holds up to 1.5
    factors = []
    while (factor := search.next_factor()) is not None:
        factors.append(factor)
        fails = factor > 1.5 or factor in refused
        if search.stable is not None and factor - search.stable < 0.02:
            refused.discard(factor)
            fails = factor > 1.5
        search.record(Trial(factor, 0.0, 1, Outcome.COLLAPSE if fails else Outcome.EQUILIBRIUM))
    assert search.stable is not None
    assert search.above is not None
    assert 1.49 <= search.stable <= 1.5 < search.above <= search.stable + 0.01 + 1e-9
    assert factors.count(1.2) == 2


def test_thickness_of_a_turned_layer() -> None:
    shape = {"type": "box", "lower": [0.0, 0.0], "upper": [20.0, 1.0], "angle": 30.0}
    model = block(LAWS["tresca"], **{"bodies.0.shape": shape, "loads": []})
    assert thickness(Simulation(model).state.points) == pytest.approx(1.0, rel=0.05)


def test_a_slice_in_3d_has_the_factor_of_plane_strain() -> None:
    """A cut, 1 cell thick between smooth walls, along the grid, so that all cells are full.

    Without F-bar, which takes the mean over volumes in space and over areas in the plane.
    """
    boxes = [([0.0, 0.0], [9.0, 1.5]), ([0.0, 1.5], [3.0, 3.0])]
    entries = block({**LAWS["mohr_coulomb"], "cohesion": 4.5}).to_dict()
    body = entries["bodies"][0] | {"surface": None}
    walls = {"left": ("x", 0.0, "roller"), "below": ("y", 0.0, "fixed")}

    def in_dimension(dim: int) -> Model:
        def of(x: list[float], thick: float) -> list[float]:
            return x if dim == 2 else [x[0], thick, x[1]]

        bodies = [
            {
                **body, "name": f"box {number}",
                "shape": {"type": "box", "lower": of(lower, 0.0), "upper": of(upper, 0.5)},
            }
            for number, (lower, upper) in enumerate(boxes)
        ]  # fmt: skip
        held = walls
        if dim == 3:
            held = {"left": walls["left"], "below": ("z", 0.0, "fixed")}
            held |= {"front": ("y", 0.0, "roller"), "back": ("y", 0.5, "roller")}
        boundaries = [
            {"name": name, "type": "plane", "axis": axis, "at": at, "condition": condition}
            for name, (axis, at, condition) in held.items()
        ]
        gravity = {"type": "body_force", "acceleration": of([0.0, -10.0], 0.0)}
        kind = {"kind": "plane_strain" if dim == 2 else "3d"}
        parts = {"analysis": entries["analysis"] | kind, "bodies": bodies}
        return Model.from_dict({**entries, **parts, "boundaries": boundaries, "loads": [gravity]})

    plane, slice_ = (in_dimension(dim) for dim in (2, 3))
    ratio = thickness(march(plane).state.points) / thickness(march(slice_).state.points)
    expected = reduced(plane, tolerance=0.002)
    found = reduced(slice_, tolerance=0.002, displacement_ratio=10.0 * ratio)
    assert found.largest_displacement == pytest.approx(expected.largest_displacement, rel=1e-6)
    assert found.factor == pytest.approx(expected.factor, rel=0.005)
