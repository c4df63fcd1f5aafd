# SPDX-License-Identifier: BSD-3-Clause
"""Whether terms change no state while they are evaluated, for tests of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest

from tilth.algebra.block_matrix import BlockMatrix
from tilth.algebra.unknowns import Unknowns
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.terms.balance import Balance, Residual
from tilth.terms.protocol import GlobalUnknowns

OFTEN = 4
"""Evaluations elsewhere. As each assembles twice a term would count enough linearisations to lose
its patience."""


def leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Numbers and arrays of nested data classes, mappings and sequences, with their names."""
    if is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in fields(value)}
    if isinstance(value, list | tuple):
        value = {str(number): each for number, each in enumerate(value)}
    if isinstance(value, dict):
        for key, each in value.items():
            yield from leaves(f"{name} {key}", each)
    elif value is not None:
        yield name, np.array(value)


def assert_same(one: dict[str, Any], other: dict[str, Any]) -> None:
    """Every entry has the same bits in both."""
    assert one.keys() == other.keys()
    for name, value in one.items():
        np.testing.assert_array_equal(other[name], value, err_msg=name)


def evaluated(balance: Balance, u: Floats, g: Floats) -> dict[str, Any]:
    """What all terms tell at nodal displacements and global unknowns."""
    found: dict[str, Any] = {}
    for number, (term, own) in enumerate(zip(balance.terms, balance._slices, strict=True)):
        part = term.evaluate(balance.at(u, g[own]))
        found[f"{number} force"] = part.u.copy()
        found[f"{number} global residual"] = part.globals
    once, again = (_asked(balance, u, g) for _ in range(2))
    assert_same(once, again)
    return found | once


def _asked(balance: Balance, u: Floats, g: Floats) -> dict[str, Any]:
    """What the terms tell besides their forces, at the displacement of these."""
    found: dict[str, Any] = {}
    for number, (term, own) in enumerate(zip(balance.terms, balance._slices, strict=True)):
        x, matrix = balance.at(u, g[own]), balance.space.matrix()
        matrix.clear()
        term.assemble(x, matrix)
        told = {
            "stiffness": matrix["u", "u"].values.copy(),
            "magnitude": term.magnitude(x),
            "outcome": term.outcome(x),
            "check": term.check(x),
            "constant force": term.constant_force(),
            "forces before": (term.load_before(), term.inertia_before(), term.carried_force()),
            "nodes": (term.joined_nodes(), term.yielding_nodes()),
        }
        if isinstance(term, GlobalUnknowns):
            told["border"] = term.border(u, g[own])
            told["first unknowns"] = term.first_unknowns()
        found |= dict(leaves(f"{number}", told))
    return found


def random_values(balance: Balance, size: float, seed: int) -> tuple[Floats, Floats]:
    """Displacements of the nodes and global unknowns, normal with a standard deviation [length]."""
    random = np.random.default_rng([17, seed])
    u = size * random.normal(size=(balance.active.nodes, balance.active.grid.dim))
    return u, size * random.normal(size=len(balance.global_scale)) / balance.global_scale


def assert_pure(balance: Balance, size: float, lifted: float = 0.0) -> None:
    """What the terms tell at one place depends neither on evaluations there nor elsewhere.

    Before and after the matrix at the one place counts as filled. size: of the motion [length].
    lifted: motion of all nodes upwards at this place [length].
    """
    u, g = random_values(balance, size, 0)
    u[:, -1] += lifted
    for _ in range(2):
        first = evaluated(balance, u, g)
        assert_same(first, evaluated(balance, u, g))
        for seed in range(1, OFTEN + 1):
            elsewhere = random_values(balance, (2.0 if seed % 2 else -0.5) * size, seed)
            with suppress(StepFailed):
                evaluated(balance, *elsewhere)
        assert_same(first, evaluated(balance, u, g))
        balance.linearised()


@contextmanager
def disturbed(size: float) -> Iterator[list[int]]:
    """Evaluates and assembles elsewhere, too, before each evaluation, and everything twice.

    size: how far away [length]. Gives the number of evaluations elsewhere.
    """
    evaluate, linearise = Balance.evaluate, Balance.linearise
    count = [0]

    def disturbed_residual(self: Balance, x: Unknowns) -> Residual:
        count[0] += 1
        moved, turned = random_values(self, size, count[0])
        with suppress(StepFailed):
            evaluated(self, x.u + moved, x.globals + turned)
            elsewhere = self.at(x.u + moved, x.globals + turned)
            evaluate(self, elsewhere)
            linearise(self, elsewhere, self.space.matrix())
        first = dict(leaves("", evaluate(self, x)))
        found = evaluate(self, x)
        assert_same(first, dict(leaves("", found)))
        return found

    def filled_twice(self: Balance, x: Unknowns, matrix: BlockMatrix) -> None:
        linearise(self, x, matrix)
        once = matrix["u", "u"].values.copy()
        linearise(self, x, matrix)
        np.testing.assert_array_equal(matrix["u", "u"].values, once)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Balance, "evaluate", disturbed_residual)
        patch.setattr(Balance, "linearise", filled_twice)
        yield count


def state_after(simulation: Simulation, times: list[float]) -> dict[str, Any]:
    """The state after steps from one time to the next, and what those that succeed have told."""
    found: dict[str, Any] = {}
    with suppress(StepFailed):  # then the last of the attempts fails in both
        for number in range(len(times) - 1):
            result = simulation.advance(times[number], times[number + 1])
            found |= dict(leaves(f"step {number}", told(result)))
    for body in simulation.state.bodies:
        found |= dict(leaves(body.name, body.state()))
    return found | simulation.state.arrays()


def told(result: StepResult) -> dict[str, Any]:
    """Numbers of a step: residuals, forces, work, contact."""
    names = ("work", "friction_work", "gap_work", "damping_work", "stabilisation_work")
    return {name: getattr(result, name) for name in names} | {
        "residuals": result.equilibrium.residuals,
        "forces": result.forces,
        "contacts": result.contacts,
    }
