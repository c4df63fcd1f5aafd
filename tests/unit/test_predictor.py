# SPDX-License-Identifier: BSD-3-Clause
"""The predictor: a load step begins with the displacement of the last one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from newton_problems import leaning_block
from resumed_runs import assert_same_results, entries_of, run_until
from small_problems import (
    BASES,
    KINDS,
    STEP_MATERIALS,
    assert_same_bits,
    block_entries,
    by_number,
    dimension,
    plane,
    rollers,
    weight,
)

from tilth import Model, resume, run
from tilth.analysis.march import march
from tilth.analysis.predictor import LARGEST_MOTION, Predictor
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.grid.keys import find_keys
from tilth.model.load_curve import LoadCurve
from tilth.mpm.active_grid import Buffers, locate
from tilth.mpm.soil import Soil
from tilth.terms.weak_springs import covered_nodes
from tilth_verification.cases import example, varied

pytestmark = pytest.mark.slow

every_kind = pytest.mark.parametrize("kind", KINDS)
every_basis = pytest.mark.parametrize("basis", BASES)
STEPS = 20


def squeezed(
    kind: str, basis: str, predictor: bool, material: str = "hencky_elastic", **analysis: Any
) -> Model:
    """A block under its weight whose top is pushed down by a tenth, smoothly."""
    up = "xyz"[dimension(kind) - 1]
    entries = block_entries(
        kind, basis, material, loads=[weight(kind, 2.0)],
        boundaries=[*rollers(kind, sides=False), plane(
            "top", up, 2.0, condition="prescribed", displacement={up: -0.2},
        )],
        schedule={"steps": STEPS},
    )  # fmt: skip
    entries["analysis"] |= {"tolerance": 1e-6, "predictor": predictor, **analysis}
    return Model.from_dict(entries)


def marched(model: Model) -> tuple[Simulation, int]:
    """The final state, and the Newton iterations of all steps."""
    counts: list[int] = []
    simulation = march(model, lambda _, result, __: counts.append(result.equilibrium.iterations))
    assert len(counts) == STEPS
    return simulation, sum(counts)


@every_kind
@every_basis
@pytest.mark.parametrize("material", STEP_MATERIALS)
def test_the_result_is_the_same(kind: str, basis: str, material: str) -> None:
    states = []
    for predictor in (True, False):
        model = squeezed(kind, basis, predictor, material, tolerance=1e-10)
        states.append(by_number(marched(model)[0].state.points))
    # nodes that domains hardly reach may move by far more than the tolerance
    near = 1e-8 if basis == "linear" else 1e-6
    for name in ("position", "elastic_strain"):
        np.testing.assert_allclose(states[0][name], states[1][name], rtol=0, atol=near)


@every_kind
def test_a_smooth_path_takes_fewer_iterations(kind: str) -> None:
    with_predictor = marched(squeezed(kind, "linear", True))[1]
    without = marched(squeezed(kind, "linear", False))[1]
    assert with_predictor <= 0.7 * without


def pulled(**analysis: Any) -> Simulation:
    simulation = leaning_block("plane_strain", "linear", "hencky_elastic", 60.0, **analysis)
    simulation.advance(0.0, 0.1)
    return simulation


def test_nodes_of_a_moved_grid_take_the_guess_from_the_points() -> None:
    """An affine motion of the points is the same motion of all nodes."""
    simulation = pulled()
    gradient = np.array([[0.01, 0.02], [-0.03, 0.005]])
    points = simulation.state.points
    points.last_gradient[:] = gradient
    points.last_displacement[:] = [0.004, -0.002] + points.position @ gradient.T
    moved = replace(simulation.state.grid, origin=simulation.state.grid.origin + 0.3)
    active = locate(points, moved, Buffers())
    guess = simulation.state.predictor.guess(simulation.soil_on(active), 0.1, 0.15)
    expected = [0.002, -0.001] + 0.5 * active.position @ gradient.T
    assert guess is not None
    np.testing.assert_allclose(guess, expected, rtol=0, atol=1e-15)


def test_covered_nodes_keep_their_displacement() -> None:
    simulation = pulled()
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    last = simulation.state.predictor.displacement
    assert np.abs(last).max() > 1e-4
    guess = simulation.state.predictor.guess(simulation.soil_on(active), 0.1, 0.15)
    assert guess is not None
    kept = covered_nodes(simulation.soil_on(active))
    assert 0 < kept.sum() < active.nodes
    np.testing.assert_allclose(guess[kept], 0.5 * last[kept], rtol=1e-12)


@pytest.mark.parametrize(
    ("tables", "growth"),
    [
        ([[[0, 0], [1, 1], [2, 4]]], 3.0),
        ([[[0, 0], [1, 1], [2, 4]], [[0, 0], [1, 2], [2, 8]], [[0, 1], [2, 1]]], 3.0),
        ([[[0, 0], [1, 1], [2, 4]], [[0, 0], [1, 1], [2, 2]]], 1.0),  # not in proportion
        ([[[0, 0], [1, 0], [2, 1]]], 1.0),  # begins
        ([[[0, 0], [1, 1], [2, 1]]], 0.0),  # rests
        ([[[0, 0], [1, 1], [2, 0]]], 0.0),  # turns back
        ([], 1.0),
    ],
)
def test_the_guess_grows_with_loads_and_motions(tables: Any, growth: float) -> None:
    simulation = pulled()
    predictor = Predictor(2, [LoadCurve(table) for table in tables])
    predictor.restore(simulation.state.predictor.state() | {"size": np.array(1.0)})
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    guess = predictor.guess(simulation.soil_on(active), 1.0, 2.0)
    assert guess is not None
    kept = covered_nodes(simulation.soil_on(active))
    np.testing.assert_allclose(guess[kept], growth * predictor.displacement[kept], rtol=1e-12)


def test_larger_steps_of_a_flowing_footing_begin_near_their_end() -> None:
    """Three times the settlement of the step before, at the limit load: as with equal steps."""
    first = {}
    for name, table in (
        ("equal", [[0.0, 0.0], [4.0, 0.5], [8.0, 1.0]]),
        ("larger", [[0.0, 0.0], [6.0, 0.5], [8.0, 1.0]]),
    ):
        changes = {
            "grid.cell_size": 0.25,
            "boundaries.3.factor": table,
            "schedule.end": 8.0,
            "schedule.steps": 8,
        }
        found: list[float] = []
        march(
            varied(example("strip_footing"), changes),
            lambda _, result, __, into=found: into.append(result.equilibrium.residuals[0]),  # type: ignore[misc]
        )
        first[name] = found[6]
    assert first["larger"] < 3.0 * first["equal"]


def test_nodes_of_a_boundary_receive_the_displacement_upstream() -> None:
    """u(x - u) for a linear u, to the edge of the soil; also where the soil supports no node."""
    simulation = pulled()
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    predictor, soil = simulation.state.predictor, simulation.soil_on(active)
    position = active.position[find_keys(active.key, predictor.key)]
    gradient = np.array([[0.01, 0.02], [-0.03, 0.005]])
    predictor.displacement = np.array([0.004, -0.002]) + position @ gradient.T
    held = ~covered_nodes(soil) | (np.arange(active.nodes) % 2 == 0)
    guess = predictor.guess(soil, 0.1, 0.2, held)
    assert guess is not None
    own = predictor.displacement[find_keys(predictor.key, active.key)]
    expected = np.where(held[:, None], own - own @ gradient.T, own)
    np.testing.assert_allclose(guess, expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize(("share", "kept"), [(0.99, True), (1.01, False)])
def test_nodes_keep_it_only_while_the_soil_stays(share: float, kept: bool) -> None:
    simulation = pulled()
    predictor = simulation.state.predictor
    cells = np.abs(predictor.displacement / simulation.state.grid.cell_size).max()
    predictor.displacement = predictor.displacement * (share * LARGEST_MOTION / cells)
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    guess = predictor.guess(simulation.soil_on(active), 0.1, 0.2)
    assert guess is not None
    well = covered_nodes(simulation.soil_on(active))
    same = (guess[well] == predictor.displacement[find_keys(predictor.key, active.key)[well]]).all()
    assert same == kept


def test_a_slender_body_that_moves_by_cells() -> None:
    """Its tip moves by one to two and a half cells a step; nodes at other soil would mislead."""
    model = example("end_loaded_cantilever")
    iterations = {}
    for predictor in (True, False):
        simulation = Simulation(varied(model, {"analysis.predictor": predictor}))
        time = model.schedule.regular_time
        results = [simulation.advance(time(step), time(step + 1)) for step in range(8)]
        assert not simulation.services.warnings.texts
        iterations[predictor] = sum(result.equilibrium.iterations for result in results)
        moved = [np.abs(r.equilibrium.displacement).max() for r in results]
        assert min(moved) > simulation.state.grid.cell_size[0]
    assert iterations[True] < iterations[False]


def test_no_guess_without_a_predictor_or_a_step() -> None:
    simulation = leaning_block("plane_strain", "linear", "hencky_elastic", 60.0)
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    assert simulation.state.predictor.guess(simulation.soil_on(active), 0.0, 0.1) is None
    asked = pulled(predictor=False)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Predictor, "guess", lambda *arguments: pytest.fail("it was asked for"))
        asked.advance(0.1, 0.2)


def test_a_guess_that_inverts_points_is_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    """The step then is that without a predictor, to the bit."""
    plain, misled = pulled(predictor=False), pulled()
    asked = 0

    def huge(self: Predictor, soil: Soil, *arguments: object) -> Floats:
        nonlocal asked
        asked += 1
        return np.asarray(-3.0 * soil.active.position)

    expected = plain.advance(0.1, 0.2)
    with monkeypatch.context() as patch:
        patch.setattr(Predictor, "guess", huge)
        result = misled.advance(0.1, 0.2)
    assert asked == 1
    assert result.equilibrium.residuals == expected.equilibrium.residuals
    assert_same_bits(misled.state.points, plain.state.points)
    assert not misled.services.warnings.texts  # no second attempt was needed


# --- together with F-bar ---------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("basis", "step"), [("gimp", 1), *((basis, 4) for basis in BASES)])
def test_resumed_with_f_bar(
    kind: str, basis: str, step: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entries = entries_of(kind, basis)
    entries["bodies"][0]["anti_locking"] = "f_bar"
    entries["analysis"] |= {"predictor": True}
    model = Model.from_dict(entries)
    result = run(model, tmp_path / "whole", quiet=True)
    assert np.ptp(result.points.assumed_jacobian) > 1e-6
    run_until(model, tmp_path / "out", step, monkeypatch)
    resume(tmp_path / "out", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "out")


@every_kind
@every_basis
@pytest.mark.parametrize("material", ["hencky_elastic", "von_mises"])
def test_newton_converges_quadratically_with_f_bar(kind: str, basis: str, material: str) -> None:
    elastic = material == "hencky_elastic"
    # a soil that does not lock moves farther: elsewhere than in the stiff full disc, the loads of
    # the standard method are more than one step of plain Newton can take
    acceleration = (60.0 if elastic else 14.0) * (1.0 if kind == "axisymmetric" else 0.6)
    entries = leaning_block(kind, basis, material, acceleration).setup.model.to_dict()
    entries["bodies"][0]["anti_locking"] = "f_bar"
    simulation = Simulation(Model.from_dict(entries))
    residuals = np.array(simulation.advance(0.0, 1.0).equilibrium.residuals)
    assert np.ptp(simulation.state.points.assumed_jacobian) > 1e-4
    if not elastic:
        assert (simulation.state.points.plastic[:, 0] > 1e-3).mean() > 0.4
    tail = residuals[residuals < 0.05]
    clean = tail[tail > 1e-12]  # below that stands round-off
    assert len(clean) >= 2
    assert clean[0] / tail[-1] > 1e6
    constant = tail[1 : len(clean) + 1] / clean[: len(tail) - 1] ** 2
    assert constant[tail[1 : len(clean) + 1] > 1e-12].max() < 30.0
