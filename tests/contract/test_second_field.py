# SPDX-License-Identifier: BSD-3-Clause
"""A second field that is coupled to the displacement: tangents, a known answer, units, stages."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scalar_field import NAME, Scalar, with_scalar
from small_problems import (
    BASES,
    CORNER_BASES,
    ELASTIC,
    block_entries,
    dimension,
    plane,
    rollers,
    spaced,
)

from tilth import Model
from tilth.algebra.field import Field, GivenChange
from tilth.algebra.nodes import MeshNodes
from tilth.algebra.unknowns import Unknowns
from tilth.analysis.initial_equilibrium import find_initial_equilibrium
from tilth.analysis.residual import Equations, Newton
from tilth.analysis.simulation import Simulation
from tilth.analysis.stage_change import next_stage, points_of_stages
from tilth.analysis.step_terms import TERMS
from tilth.arrays import Flags, Floats
from tilth.errors import StepFailed
from tilth.terms.balance import Balance
from tilth.terms.protocol import AssembledTerm, Term
from tilth.terms.space import Space

SOLVERS = ("superlu", "multigrid")
E, NU = ELASTIC["young_modulus"], ELASTIC["poisson_ratio"]
CONSTRAINED = E * (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU))
HEIGHT = 12
PRESSURE = 1e-4 * CONSTRAINED


def at_top(height: float) -> Callable[[Floats], Flags]:
    return lambda x: np.asarray(np.abs(x[:, -1] - height) < 1e-9)


def balance_in(simulation: Simulation, before: float, after: float) -> Balance:
    """The balance of a step, with all fields."""
    step = simulation.prepare(before, after)
    return simulation.balance(step, simulation.soil_on(step.active), holds_others=False)


def random_unknowns(balance: Balance, sizes: dict[str, float], seed: int) -> Unknowns:
    random = np.random.default_rng(seed)
    of = {name: sizes[name] * random.normal(size=f.shape) for name, f in balance.fields.items()}
    return Unknowns(of, np.zeros_like(balance.global_scale))


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@pytest.mark.parametrize("basis", [*BASES, *CORNER_BASES])
@pytest.mark.parametrize("spacing", ["uniform", "graded"])
def test_the_matrix_is_the_derivative_of_all_residuals(kind: str, basis: str, spacing: str) -> None:
    entries = spaced(block_entries(kind, basis, "von_mises"), spacing)
    scalar = Scalar(conductivity=0.3, storage=0.02, coupling=0.8, nonlinear=0.02, source=0.1)
    simulation = with_scalar(Model.from_dict(entries), scalar)
    balance = balance_in(simulation, 0.0, 1.0)
    assert list(balance.fields) == ["u", NAME]
    sizes = {"u": 1e-2, NAME: 5.0}
    x, way = random_unknowns(balance, sizes, 1), random_unknowns(balance, sizes, 2)
    matrix = balance.space.matrix()
    balance.evaluate(x)
    balance.linearise(x, matrix)
    found, step = matrix.times(way), 1e-5
    ahead, behind = (balance.evaluate(x.plus(way, share)) for share in (step, -step))
    for name, values in found.of.items():
        difference = (ahead.of[name] - behind.of[name]) / (2.0 * step)
        scale = np.abs(difference).max()
        np.testing.assert_allclose(values, difference, rtol=0, atol=1e-6 * scale)


def column(
    kind: str = "plane_strain", solver: str = "superlu", steps: int = 60, **changed: Any
) -> dict[str, Any]:
    """A column that cannot widen, loaded on its top at once; its time factor ends at 0.5."""
    dim = dimension(kind)
    upper = [1.0] * (dim - 1) + [float(HEIGHT)]
    entries = block_entries(kind, "linear", "hencky_elastic")
    entries["bodies"][0]["shape"]["upper"] = upper
    entries["bodies"][0]["surface"] = {}
    entries["boundaries"] = rollers(kind, 1.0)
    entries["analysis"] |= {"solver": solver, "tolerance": 1e-8}
    top = {"start": [1.0, HEIGHT], "end": [0.0, HEIGHT]} if dim == 2 else {
        "rectangle": [[0.0, 0.0, HEIGHT], [1.0, 0.0, HEIGHT], [1.0, 1.0, HEIGHT]]
    }  # fmt: skip
    entries["loads"] = [
        {"type": "surface", "body": "block", "pressure": PRESSURE, "factor": [[0, 1], [1e9, 1]]}
        | top
    ]
    end = 0.5 * HEIGHT**2 / CONSTRAINED
    entries["schedule"] = {"steps": steps, "end": end}
    return entries | changed


def settled(entries: dict[str, Any], scalar: Scalar) -> tuple[float, Simulation]:
    """The settlement of the top over the final one, after all steps."""
    simulation = with_scalar(Model.from_dict(entries), scalar)
    steps, end = entries["schedule"]["steps"], entries["schedule"]["end"]
    times = np.linspace(0.0, end, steps + 1)
    for before, after in itertools.pairwise(times):
        simulation.advance(before, after)
    points = simulation.state.points
    top = points.position[:, -1] > HEIGHT - 0.5
    place = points.position[top, -1] - points.displacement[top, -1]
    settlement = -float(np.mean(points.displacement[top, -1] * HEIGHT / place))
    return settlement / (PRESSURE * HEIGHT / CONSTRAINED), simulation


def degree(factor: float) -> float:
    """Terzaghi's degree of consolidation at a time factor."""
    m = 0.5 * np.pi * (2.0 * np.arange(200) + 1.0)
    return float(1.0 - (2.0 / m**2 * np.exp(-(m**2) * factor)).sum())


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_column_consolidates_as_by_terzaghi(solver: str) -> None:
    scalar = Scalar(conductivity=1.0, drained=at_top(HEIGHT), bulk=CONSTRAINED)
    found, simulation = settled(column(solver=solver), scalar)
    assert found == pytest.approx(degree(0.5), rel=0.01)
    if solver == "multigrid":
        assert "multigrid" in simulation.services.solver.summary
        assert simulation.services.solver.iterations


def block(kind: str = "plane_strain", solver: str = "superlu", **changed: Any) -> dict[str, Any]:
    """A block of 4 cells along each axis under gravity that grows over four steps."""
    entries = block_entries(kind, "gimp", "hencky_elastic", cells=4)
    entries["boundaries"] = rollers(kind, 4.0)
    entries["analysis"] |= {"solver": solver, "tolerance": 1e-10}
    gravity = [0.0] * (dimension(kind) - 1) + [-2.0]
    entries["loads"] = [{"type": "body_force", "acceleration": gravity}]
    entries["schedule"] = {"steps": 4}
    return entries | changed


def block_scalar(**changed: Any) -> Scalar:
    usual = {"conductivity": 2e-2, "storage": 1e-4, "drained": at_top(4.0), "bulk": CONSTRAINED}
    return Scalar(**usual | changed)


def advanced(simulation: Simulation, first: int, last: int) -> Simulation:
    """After some of the four steps."""
    for step in range(first, last):
        simulation.advance(step / 4, (step + 1) / 4)
    return simulation


def result(simulation: Simulation, scalar: Scalar) -> tuple[Floats, Floats]:
    """Displacements of the points and values of the scalar."""
    points = simulation.state.points
    return points.displacement[np.argsort(points.point_id)], scalar.value / scalar.unit


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@pytest.mark.parametrize("nonlinear", [0.0, 0.02])
def test_all_solvers_find_the_same(kind: str, nonlinear: float) -> None:
    found = []
    for solver in SOLVERS:
        scalar = block_scalar(nonlinear=nonlinear, source=1e-3)
        simulation = advanced(with_scalar(Model.from_dict(block(kind, solver)), scalar), 0, 4)
        found.append(result(simulation, scalar))
        summary = simulation.services.solver.summary
        assert ("multigrid" in summary) == (solver == "multigrid"), summary
    assert np.abs(found[0][1]).max() > 1.0
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-6 * np.abs(one).max())


def test_the_unit_of_the_scalar_does_not_matter() -> None:
    """Nor does it change what Newton's iteration counts as converged."""
    found, residuals = [], []
    for unit in (1.0, 1e-6, 1e6):
        scalar = block_scalar(nonlinear=0.02, unit=unit)
        simulation = advanced(with_scalar(Model.from_dict(block()), scalar), 0, 3)
        residuals.append(simulation.advance(0.75, 1.0).equilibrium.residuals)
        found.append(result(simulation, scalar))
    for other, of_other in zip(found[1:], residuals[1:], strict=True):
        assert len(of_other) == len(residuals[0])
        for a, b in zip(found[0], other, strict=True):
            np.testing.assert_allclose(b, a, rtol=0, atol=1e-9 * np.abs(a).max())


def test_a_scalar_without_coupling_leaves_the_soil_as_it_is() -> None:
    alone = advanced(Simulation(Model.from_dict(block())), 0, 4).state.points
    scalar = block_scalar(coupling=0.0, source=1.0)
    points = advanced(with_scalar(Model.from_dict(block()), scalar), 0, 4).state.points
    scale = np.abs(alone.displacement).max()
    np.testing.assert_allclose(points.displacement, alone.displacement, rtol=0, atol=1e-12 * scale)
    assert np.abs(scalar.value).max() > 0.0


def test_a_scalar_that_is_in_part_of_the_soil() -> None:
    """Where it is not it keeps its start, and the soil there is as without it."""
    scalar = block_scalar(wet=lambda x: x[:, 1] < 2.5, drained=at_top(1e9))
    simulation = advanced(with_scalar(Model.from_dict(block()), scalar), 0, 4)
    height = simulation.locate(1.0).position[:, 1]
    assert (scalar.value[height > 2.5] == 0.0).all()
    assert (np.abs(scalar.value[height < 2.0]) > 1.0).any()


def test_a_resumed_analysis_goes_on_with_the_same_bits() -> None:
    """The scalar is an owner: its values are in the checkpoint."""
    whole = block_scalar(nonlinear=0.02)
    model = Model.from_dict(block())
    simulation = advanced(with_scalar(model, whole), 0, 2)
    arrays = {name: each.copy() for name, each in simulation.state.arrays().items()}
    assert {f"field {NAME}.key", f"field {NAME}.value"} <= set(arrays)
    advanced(simulation, 2, 4)
    again = block_scalar(nonlinear=0.02)
    terms, fields = simulation.setup.terms[:-1], [again]
    resumed = Simulation.restored(model, arrays, terms=[*terms, again.terms()], fields=fields)
    resumed.locate(0.5)
    advanced(resumed, 2, 4)
    for one, other in zip(result(simulation, whole), result(resumed, again), strict=True):
        assert np.array_equal(one, other)


def test_the_next_stage_begins_with_the_scalar_of_the_last_one() -> None:
    entries = block()
    schedule = entries.pop("schedule")
    entries["stages"] = [{"name": name, "schedule": schedule} for name in ("one", "two")]
    models = Model.from_dict(entries).of_stages
    initial = points_of_stages(models)
    scalar = block_scalar()
    last = advanced(with_scalar(models[0], scalar, initial=initial[0]), 0, 4)
    before = scalar.value.copy()
    after = next_stage(last, models[1], initial[1])
    (field,) = [f for f in balance_in(after, 0.0, 0.25).fields.values() if f.name == NAME]
    np.testing.assert_array_equal(field.first(), before)
    after.advance(0.0, 0.25)
    assert np.abs(scalar.value).max() < np.abs(before).max()  # it drains on


def test_only_the_displacement_is_looked_for_where_the_scalar_is_held() -> None:
    """As in the search for a starting state, and where strength is reduced."""
    scalar = block_scalar()
    light = [{"type": "body_force", "acceleration": [0.0, -2e-4]}]
    simulation = advanced(with_scalar(Model.from_dict(block(loads=light)), scalar), 0, 2)
    step = simulation.prepare(0.5, 0.5)
    balance = simulation.balance(step, simulation.soil_on(step.active))
    assert balance.fields[NAME].constrained.all()
    assert not balance.fields[NAME].increment.any()
    now = Equations(balance).at(balance.first())
    assert now.sizes["momentum"].relative < 1e-6  # as it was, but for the soil's motion
    assert now.sizes["volume"].free == 0.0
    balance.linearise(now.x, balance.space.matrix())  # whose blocks nobody asks for


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@pytest.mark.parametrize("basis", ["linear", "gimp"])
@pytest.mark.parametrize("cell", [0.5, 0.3])
def test_a_uniform_scalar_at_rest_stays(kind: str, basis: str, cell: float) -> None:
    """Nothing is stored and nothing flows: what is left is round-off over round-off."""
    entries = block_entries(kind, basis, cells=2)
    entries["grid"]["cell_size"] = cell
    scalar = block_scalar(storage=1.0, coupling=0.0, drained=at_top(1e9))
    simulation = with_scalar(Model.from_dict(entries), scalar)
    scalar.key = simulation.locate(0.0).key.copy()
    scalar.value = np.full((len(scalar.key), 1), 20.3)
    residuals = simulation.advance(0.0, 1.0).equilibrium.residuals
    assert len(residuals) <= 5
    np.testing.assert_allclose(scalar.value, 20.3, rtol=1e-12)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_second_body_without_the_scalar(solver: str) -> None:
    """It is in no block of it, and moves as without it."""
    entries = block(solver=solver)
    other = {**entries["bodies"][0], "name": "dry"}
    other["shape"] = {"type": "box", "lower": [0.0, 8.0], "upper": [4.0, 10.0]}
    entries["bodies"] = [entries["bodies"][0], other]
    entries["boundaries"] = [*entries["boundaries"], plane("floor", "y", 8.0)]
    found = []
    for coupling in (1.0, 0.0):
        scalar = block_scalar(wet=lambda x: x[:, 1] < 6.0, coupling=coupling)
        points = advanced(with_scalar(Model.from_dict(entries), scalar), 0, 2).state.points
        dry = points.body_id == 1
        found.append(points.displacement[dry][np.argsort(points.point_id[dry])])
    scale = np.abs(found[0]).max()
    assert scale > 0.0
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-9 * scale)


def test_a_scalar_in_soil_that_starts_in_equilibrium_or_with_inertia() -> None:
    """The searches for the state and for the accelerations at the start hold it."""
    moving = {
        "analysis": {"kind": "plane_strain", "inertia": {"scheme": "newmark"}},
        "units": {"length": "m", "force": "N", "time": "s"},
        "schedule": {"steps": 4, "end": 1.0},
    }
    for changed in ({"initial": {"equilibrium": True}}, moving):
        scalar = block_scalar()
        simulation = with_scalar(Model.from_dict(block(**changed)), scalar)
        if "initial" in changed:
            find_initial_equilibrium(simulation)
        advanced(simulation, 0, 1)
        assert np.abs(scalar.value).max() > 0.0


WRONG = {
    "rows": (lambda own, x: Unknowns({NAME: np.zeros((1, 1))}), "Wrong returns a residual of 'p'"),
    "field": (lambda own, x: Unknowns({"d": x.u}), "'d', a field that the step does not have"),
    "type": (lambda own, x: x.u, "`evaluate` of Wrong returns no `Unknowns`"),
}


class Wrong(Term, AssembledTerm):
    """A term with a mistake in what it returns."""

    pairs_at_points: Any = ()
    evaluate: Any = None
    found: Any = None

    def assembled(self, space: Space, elements: Any) -> Any:
        return self.found

    def assemble(self, x: Unknowns, matrix: Any) -> None:
        matrix["u", NAME].values[:] = 0.0


def wrong(**attributes: Any) -> Wrong:
    term = Wrong()
    term.found = term
    for name, value in attributes.items():
        setattr(term, name, value)
    return term


@pytest.mark.parametrize("mistake", WRONG)
def test_what_a_term_returns_is_checked(mistake: str) -> None:
    returns, told = WRONG[mistake]
    simulation = Simulation(
        Model.from_dict(block()),
        terms=[*TERMS, lambda of: [wrong(evaluate=lambda x: returns(None, x))]],
        fields=[block_scalar()],
    )
    with pytest.raises((TypeError, ValueError), match=re.escape(told)):
        simulation.advance(0.0, 0.25)


@pytest.mark.parametrize(
    ("attributes", "told"),
    [
        ({"pairs_at_points": [("u", "d")]}, "Wrong couples a field 'd'"),
        ({"pairs_at_points": ("u", NAME)}, "is no list of pairs"),
        ({"found": None}, "`assembled` of Wrong returns no term"),
        ({"evaluate": lambda x: Unknowns({})}, "no block of 'u' by 'p'"),
    ],
)
def test_what_a_term_couples_is_checked(attributes: dict[str, Any], told: str) -> None:
    simulation = Simulation(
        Model.from_dict(block()),
        terms=[*TERMS, lambda of: [wrong(**attributes)]],
        fields=[block_scalar(coupling=0.0)],
    )
    with pytest.raises((TypeError, ValueError), match=re.escape(told)):
        simulation.advance(0.0, 0.25)


@pytest.mark.parametrize(
    ("attributes", "told"),
    [
        ({"start": np.zeros(3)}, "start has the shape (3,) instead of (4, 1)"),
        ({"active": np.ones((4, 1), dtype=bool)}, "active has the shape (4, 1) instead of (4,)"),
        ({"scale": np.ones(2)}, "scale has the shape (2,) instead of (1,)"),
        (
            {"prescribed": GivenChange(np.zeros(4, dtype=bool), np.zeros((4, 1)))},
            "prescribed.constrained has the shape (4,)",
        ),
    ],
)
def test_the_shapes_of_a_field_are_checked(attributes: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=re.escape(f"the field 'p': {told}")):
        Field(NAME, MeshNodes(np.zeros((4, 2))), 1, "volume", **attributes)


def test_an_owner_and_its_field_have_one_name() -> None:
    scalar = block_scalar()
    scalar.name = "d"
    simulation = Simulation(Model.from_dict(block()), fields=[scalar])
    scalar.name, give = "e", scalar.in_step
    scalar.in_step = lambda of: replace(give(of), name="d")  # type: ignore[method-assign]
    with pytest.raises(ValueError, match="the owner 'e' gives a field of the name 'd'"):
        simulation.advance(0.0, 0.25)


def test_a_failed_step_names_the_equation() -> None:
    scalar = block_scalar(nonlinear=0.5, source=10.0, conductivity=1e-6)
    entries = block()
    entries["analysis"] |= {"maximum_iterations": 1, "line_search": False, "tolerance": 1e-13}
    with pytest.raises(StepFailed, match=r"the equation '(volume|momentum)' of"):
        with_scalar(Model.from_dict(entries), scalar).advance(0.0, 0.25)


def test_each_equation_must_be_balanced() -> None:
    """A residual of one equation is not small because that of the other is."""
    simulation = with_scalar(Model.from_dict(block()), block_scalar())
    balance = balance_in(simulation, 0.0, 0.25)
    equations = Equations(balance)
    now = equations.at(balance.first())
    newton = Newton(1e-6, 10, False, {})
    momentum, volume = (now.sizes[name] for name in ("momentum", "volume"))
    small = {"free": 1e-9, "of_forces": 1.0}
    for sizes, balanced in (
        ({"momentum": small, "volume": small}, True),
        ({"momentum": {"free": 1e-3, "of_forces": 1.0}, "volume": small}, False),
        ({"momentum": small, "volume": {"free": 1e-3, "of_forces": 1.0}}, False),
    ):
        given = {
            "momentum": replace(momentum, **sizes["momentum"]),
            "volume": replace(volume, **sizes["volume"]),
        }
        assert equations.balanced(replace(now, sizes=given), newton, 1) is balanced
    loose = replace(newton, round_off={"volume": 1e-2})
    given = {"momentum": replace(momentum, **small), "volume": replace(volume, free=1e-3)}
    assert equations.balanced(replace(now, sizes=given), loose, 1)


@pytest.mark.parametrize("name", ["u", NAME])
@pytest.mark.parametrize("constrained", [False, True])
@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_a_residual_that_is_not_a_number_is_noticed(
    name: str, constrained: bool, wrong: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In whichever equation, and also where it is only what holds the rest."""
    simulation = with_scalar(Model.from_dict(block()), block_scalar())
    balance = balance_in(simulation, 0.0, 0.25)
    found = balance.evaluate(balance.first())
    place = tuple(np.argwhere(balance.fields[name].constrained == constrained)[0])
    found.of[name][place] = wrong
    monkeypatch.setattr(balance, "evaluate", lambda x: found)
    now = Equations(balance).at(balance.first())
    assert np.isnan(now.relative)
    assert not Equations(balance).balanced(now, Newton(1e-6, 10, False, {}), 1)


def test_a_step_whose_scalar_has_no_solution_fails() -> None:
    """A field that nothing holds and nothing stores, with a source."""
    scalar = block_scalar(storage=0.0, coupling=0.0, source=1.0, drained=at_top(1e9))
    simulation = with_scalar(Model.from_dict(block()), scalar)
    with pytest.raises(StepFailed):
        simulation.advance(0.0, 0.25)
    assert len(scalar.value) == 0
