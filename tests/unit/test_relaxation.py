# SPDX-License-Identifier: BSD-3-Clause
"""Soil beyond a limit load that comes to rest by damped inertia, and what its files say of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from resumed_runs import assert_same_results, restored, run_in_pieces
from small_problems import block_entries, by_number, material_entries, plane, rollers, weight

from tilth import AnalysisFailed, BadInput, Model, resume, run, steps
from tilth.analysis.clock import Clock
from tilth.analysis.load_steps import load_steps
from tilth.analysis.relaxation import Relaxation
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.errors import StepFailed
from tilth.mpm.wet_mass import total_mass
from tilth.output import read_history, read_results

RELAX = {"beyond_limit": "relax"}


def cut(length: float = 1.0, stress: float = 1.0, **changed: Any) -> dict[str, Any]:
    """A block of clay with a free side that collapses before it carries its whole weight.

    `length` and `stress` are units: how often the ones of the numbers below go into them.
    """
    entries = block_entries("plane_strain", "gimp", "von_mises", cells=3)
    entries["analysis"] |= RELAX
    entries["grid"]["cell_size"] = 0.5 * length
    entries["bodies"][0]["shape"] |= {"upper": [3.0 * length, 3.0 * length]}
    entries["bodies"][0]["anti_locking"] = "f_bar"
    entries["materials"]["soil"] = material_entries(
        "von_mises", yield_stress=20.0 * stress, hardening_modulus=0.0,
        young_modulus=5e3 * stress, poisson_ratio=0.45,
    )  # fmt: skip
    entries["boundaries"] = [
        plane("base", "y", 0.0, condition="fixed"),
        plane("side", "x", 0.0),
    ]
    entries["loads"] = [weight("plane_strain", 10.0 * stress / length)]
    entries["schedule"] = {"steps": 10, "minimum_step": 0.25, "outputs": 5}
    entries["output"] = {"report": False}
    entries["track"] = [
        {"name": "base", "quantity": "reaction", "boundary": "base", "component": "y"},
        {"name": "front", "quantity": "run_out", "axis": "x", "of": "domains"},
        {"name": "kinetic", "quantity": "energy", "kind": "kinetic"},
        {"name": "damping", "quantity": "energy", "kind": "damping_dissipation"},
    ]
    return {**entries, **changed}


def marched(
    model: Model, each: Callable[[Simulation, StepResult], None] = lambda *_: None
) -> Simulation:
    """The simulation at the end of its schedule."""
    simulation = Simulation(model)
    simulation.check()
    for _, result in load_steps(simulation, Clock(model.schedule)):
        each(simulation, result)
    return simulation


@pytest.fixture
def no_equilibrium(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each step in equilibrium fails unless its load is that of its start."""
    advance = Simulation.advance

    def failing(self: Simulation, before: float, after: float, *more: Any) -> StepResult:
        if self.state.dynamics is None and after > before:
            raise StepFailed("none is found")
        return advance(self, before, after, *more)

    monkeypatch.setattr(Simulation, "advance", failing)


@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric", "3d"])
@pytest.mark.parametrize(("basis", "tolerance"), [("linear", 1e-5), ("cpdi2", 2e-3)])
def test_soil_at_rest_is_in_the_equilibrium_of_its_load(
    kind: str, basis: str, tolerance: float, request: pytest.FixtureRequest
) -> None:
    """An elastic block relaxes to where a step in equilibrium takes it, to its strain (5e-7).

    Domains that end at grid lines begin to fill the next cells: there 4 steps in equilibrium
    differ from one by 7e-4, too.
    """
    entries = block_entries(kind, basis, boundaries=rollers(kind, sides=False))
    entries["loads"] = [weight(kind, 2e-4)]
    entries["schedule"] = {"steps": 1, "adaptive": False}
    expected = by_number(marched(Model.from_dict(entries)).state.points)
    entries["analysis"] |= RELAX
    request.getfixturevalue("no_equilibrium")
    simulation = marched(Model.from_dict(entries))
    assert simulation.state.relaxation is not None
    assert (simulation.state.relaxation.number, simulation.state.relaxation.active) == (1, False)
    found = by_number(simulation.state.points)
    one, other = found["displacement"], expected["displacement"]
    np.testing.assert_allclose(one, other, atol=tolerance * np.abs(other).max())
    assert not simulation.state.points.motion.any()


def test_the_damping_is_critical_for_the_slowest_shear_wave() -> None:
    """That of a layer of the greatest extent L, fixed at one side: 2 omega = pi c / L."""
    entries = block_entries("plane_strain", "gimp", boundaries=rollers("plane_strain"))
    entries["bodies"][0]["shape"] |= {"upper": [1.0, 3.0]}
    material = {"young_modulus": 5e3, "poisson_ratio": 0.25, "density": 1.6}
    entries["materials"]["soil"] = material_entries("hencky_elastic", **material)
    entries["analysis"] |= RELAX
    simulation = Simulation(Model.from_dict(entries))
    relaxation = simulation.state.relaxation
    assert relaxation is not None
    relaxation.start(
        simulation.state.points, simulation.state.distribution, simulation.setup.water, 0.0
    )
    speed = np.sqrt(5e3 / 2.5 / 1.6)
    assert relaxation.size == pytest.approx(3.0 / speed)
    assert relaxation.damping == pytest.approx(2.0 * 0.5 * np.pi * speed / 3.0)


@pytest.mark.parametrize("motion", [{"force": {"y": -4.0}}, {"displacement": {"y": -0.02}}])
def test_a_rigid_body_comes_to_rest_with_the_soil(
    motion: dict[str, Any], request: pytest.FixtureRequest
) -> None:
    """A plate pressed by a force or driven: as in equilibrium, to the number of steps."""
    entries = block_entries("plane_strain", "gimp", boundaries=rollers("plane_strain", sides=False))
    entries["rigid_bodies"] = [
        {
            "name": "plate", "centre": [0.0, 2.5], "displacement": {"x": 0.0}, "rotation": 0.0,
            "geometries": [
                {"type": "box", "lower": [-1.0, 2.0], "upper": [1.2, 3.0], "soil": "outside"}
            ],
            "contact": {"normal": "unilateral", "tangential": "friction", "friction": 0.3},
        }
    ]  # fmt: skip
    plate = entries["rigid_bodies"][0]
    plate |= {key: plate.get(key, {}) | value for key, value in motion.items()}
    entries["schedule"] = {"steps": 4, "adaptive": False}
    expected = marched(Model.from_dict(entries)).state.rigid_bodies["plate"]
    entries["analysis"] |= RELAX
    request.getfixturevalue("no_equilibrium")
    simulation = marched(Model.from_dict(entries))
    assert simulation.state.relaxation is not None
    assert simulation.state.relaxation.number == 4
    found = simulation.state.rigid_bodies["plate"]
    assert found.displacement[1] == pytest.approx(expected.displacement[1], rel=2e-3)
    assert found.force[1] == pytest.approx(expected.force[1], rel=2e-3)


@pytest.mark.slow
def test_a_collapse_is_gone_through(tmp_path: Path) -> None:
    """The last equilibrium carries the whole weight, beyond what was the limit load."""
    entries = cut()
    with pytest.raises(AnalysisFailed, match="limit load") as failure:
        run(
            Model.from_dict({**entries, "analysis": {**entries["analysis"], "beyond_limit": "stop"},
                             "track": []}),
            tmp_path / "stop", quiet=True,
        )  # fmt: skip
    assert 'go on through a collapse with analysis.beyond_limit = "relax"' in failure.value.remedy
    model = Model.from_dict({**entries, "output": {}})
    result = run(model, tmp_path / "out", quiet=True)
    assert result.finished
    history, log = result.history, (tmp_path / "out" / "log.txt").read_text()
    number = history["relaxation"]
    assert number.max() >= 1.0
    still = number == 0.0
    weights = 2.0 * 10.0 * 9.0 * history["time"]
    np.testing.assert_allclose(history["base [N/m]"][still], weights[still], rtol=1e-7, atol=1e-7)
    assert not history["kinetic [N m/m]"][still].any()
    assert (np.diff(history["damping [N m/m]"])[still[1:]] == 0.0).all()
    for k in range(1, int(number.max()) + 1):
        rows = np.flatnonzero(number == k)
        assert len(set(history["time"][rows])) == 1
        energy, work = (
            history[f"{name} in relaxation [N m/m]"][rows] for name in ("kinetic energy", "work")
        )
        assert energy[:-1].min() > 0.0
        assert energy[-1] == 0.0  # at rest, and in equilibrium:
        assert history["base [N/m]"][rows[-1]] == pytest.approx(weights[rows[-1]], rel=1e-7)
        share = 100.0 * energy.max() / work[-1]
        assert 0.0 < share < 100.0
        assert f"{share:.2g} % of the work" in log
        assert f"relaxation {k}: from the equilibrium at time" in log
    assert list(read_results(tmp_path / "out" / "results.vtkhdf").times) == [
        0,
        0.2,
        0.4,
        0.6,
        0.8,
        1,
    ]
    report = (tmp_path / "out" / "report.html").read_text()
    assert "Beyond the limit load" in report
    assert f"{share:.2g} %" in report


@pytest.mark.slow
def test_no_unit_matters() -> None:
    """The same steps and the same place in other units of length, stress and so of time."""
    one = marched(Model.from_dict(cut()))
    other = marched(Model.from_dict(cut(length=10.0, stress=1e3)))
    assert one.state.relaxation is not None
    assert other.state.relaxation is not None
    assert one.state.relaxation.number == other.state.relaxation.number > 0
    moved, same = (by_number(each.state.points)["displacement"] for each in (one, other))
    np.testing.assert_allclose(same / 10.0, moved, atol=1e-3)


@pytest.mark.slow
def test_resumed_in_the_middle_of_a_relaxation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After its first, second and later steps, and after the last one."""
    model = Model.from_dict(cut())
    run(model, tmp_path / "whole", quiet=True)
    history = read_history(tmp_path / "whole" / "history.csv")
    steps = history["step"][history["relaxation"] == 1.0][[0, 1, 5, -2, -1]].astype(int)
    run_in_pieces(model, tmp_path / "stopped", steps, monkeypatch)
    assert_same_results(tmp_path / "whole", tmp_path / "stopped")


@pytest.mark.slow
def test_a_loop_is_left_in_the_middle_of_a_relaxation(tmp_path: Path) -> None:
    """It has no output there; a stop waits until the soil is at rest."""
    model = Model.from_dict(cut())
    for step in steps(model, tmp_path / "stopped"):
        if step.relaxation and step.size > 0.0:
            with pytest.raises(BadInput, match="while soil comes to rest"):
                step.change_load("weight", [(1.0, 1.0)])
            step.stop()
    assert step.size == 0.0
    run(model, tmp_path / "whole", until=step.time, quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "stopped")
    for step in steps(model, tmp_path / "left"):
        if step.relaxation and step.size > 0.0:
            break
    outputs = read_results(tmp_path / "left" / "results.vtkhdf").times
    assert outputs[-1] < step.time
    resume(tmp_path / "left", until=step.time, quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "left")


@pytest.mark.slow
def test_stages_count_their_relaxations_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Gravity goes beyond the limit load in one stage, and further in the next; resumed in each."""
    entries = cut()
    del entries["schedule"]
    entries["loads"][0]["name"] = "gravity"
    schedule = {"steps": 5, "minimum_step": 0.25, "outputs": 2}
    entries["stages"] = [
        {"name": "one", "schedule": schedule},
        {"name": "two", "schedule": schedule, "factors": {"gravity": [[0.0, 1.0], [1.0, 1.6]]}},
    ]
    model = Model.from_dict(entries)
    run(model, tmp_path / "whole", quiet=True)
    history = read_history(tmp_path / "whole" / "history.csv")
    found = history["relaxation"]
    assert {1.0, 2.0} <= set(found)
    steps = [int(history["step"][found == number][1]) for number in (1, 2)]
    run_in_pieces(model, tmp_path / "stopped", steps, monkeypatch)
    assert_same_results(tmp_path / "whole", tmp_path / "stopped")


def test_the_state_of_a_relaxation_is_restored() -> None:
    seen: list[dict[str, Any]] = []

    def check(simulation: Simulation, result: StepResult) -> None:
        if result.relaxing is not None and not seen:
            again = restored(simulation)
            assert isinstance(again.state.relaxation, Relaxation)
            assert again.state.dynamics is again.state.relaxation
            seen.append(vars(again.state.relaxation))
            own = vars(simulation.state.relaxation)
            assert {k: v for k, v in own.items() if k != "_norm"} == {
                k: v for k, v in seen[0].items() if k != "_norm"
            }

    marched(Model.from_dict(cut()), check)
    assert seen


def test_soil_that_nothing_stops_ends_the_analysis() -> None:
    """A block that is pulled off a plane that it may slide along."""
    entries = block_entries("plane_strain", "gimp", boundaries=[plane("base", "y", 0.0)])
    entries["loads"] = [{"type": "body_force", "acceleration": [1.0, -1.0]}]
    entries["boundaries"].append(plane("wall", "x", 50.0))
    entries["schedule"] = {"steps": 2, "minimum_step": 0.5}
    entries["analysis"] |= RELAX | {"relaxation_steps": 30}
    model = Model.from_dict(entries)
    simulation = Simulation(model)
    with pytest.raises(AnalysisFailed, match="not at rest after 30 steps") as failure:
        for _ in load_steps(simulation, Clock(model.schedule)):
            pass
    assert "relaxation 1" in failure.value.message
    assert "analysis.relaxation_steps" in failure.value.remedy


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"materials": {"soil": material_entries("hencky_elastic") | {"density": None}}},
         "materials.soil.density"),
        ({"analysis": {"kind": "plane_strain", **RELAX, "inertia": {"scheme": "newmark"}}},
         "analysis.beyond_limit"),
        ({"analysis": {"kind": "plane_strain", "relaxation_steps": 3}},
         "analysis.relaxation_steps"),
        ({"track": [{"name": "relaxation", "quantity": "top_height", "of": "points"}]},
         "track[0].name"),
    ],
)  # fmt: skip
def test_what_cannot_relax_is_refused(changes: dict[str, Any], key: str) -> None:
    entries = block_entries("plane_strain", "gimp", boundaries=rollers("plane_strain"))
    entries["analysis"] |= RELAX
    with pytest.raises(BadInput) as failure:
        Model.from_dict({**entries, "units": {"time": "s"}, **changes})
    assert key in str(failure.value)


def _on_soil(entries: dict[str, Any]) -> None:
    """A stiff slab on the block, in contact with it, which slides down with it."""
    entries["bodies"][0]["surface"] = {}
    entries["materials"]["stiff"] = material_entries("hencky_elastic", young_modulus=1e4)
    entries["bodies"].append({
        "name": "slab", "material": "stiff", "basis": "gimp", "points_per_cell": 2,
        "shape": {"type": "box", "lower": [0.0, 3.0], "upper": [2.0, 3.5]},
    })  # fmt: skip
    entries["contact_pairs"] = [{
        "name": "pair", "bodies": ["block", "slab"],
        "contact": {"normal": "unilateral", "tangential": "friction", "friction": 0.3},
    }]  # fmt: skip


def _in_water(entries: dict[str, Any]) -> None:
    """Water up to a third of the block, whose weight comes with that of the soil."""
    entries["materials"]["soil"] |= {"saturated_density": 2.2, "yield_stress": 12.0}
    entries["water"] = {"level": 1.0, "unit_weight": 10.0, "factor": [[0.0, 0.0], [1.0, 1.0]]}


def _undrained(entries: dict[str, Any]) -> None:
    """Clay with excess pore pressures."""
    entries["materials"]["soil"] = material_entries(
        "undrained_mohr_coulomb", cohesion=9.0, friction_angle=5.0, dilation_angle=0.0,
        young_modulus=5e3, pore_fluid_bulk_modulus=5e4,
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("change", [_on_soil, _in_water, _undrained])
def test_soil_with_another_body_or_with_water_comes_to_rest(
    change: Callable[[dict[str, Any]], None],
) -> None:
    """The base then carries all of the weight, but for what the water carries."""
    entries = cut()
    del entries["track"]
    change(entries)
    base: list[float] = []
    model = Model.from_dict(entries)
    found = marched(model, lambda _, result: base.append(float(result.resultant("base")[1])))
    assert found.state.relaxation is not None
    assert found.state.relaxation.number >= 1
    assert not found.state.points.motion.any()
    whole = 10.0 * float(total_mass(found.state.points, found.setup.water, 1.0).sum())
    if found.setup.water is None:
        assert base[-1] == pytest.approx(whole, rel=1e-6)
    assert 0.5 * whole < base[-1] < (1.0 + 1e-6) * whole
    assert np.isfinite(found.state.points.stress).all()
