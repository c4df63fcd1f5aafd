# SPDX-License-Identifier: BSD-3-Clause
"""What is declared of an analysis, or follows from it before the first step; it never changes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from tilth.algebra.field import MOMENTUM, Field
from tilth.analysis.grid_motion import GridMotion
from tilth.analysis.owners import Stateful
from tilth.analysis.residual import Newton, newton_attempts
from tilth.analysis.state import State
from tilth.analysis.step_result import PreparedStep
from tilth.grid.background import largest_face
from tilth.model import Model
from tilth.mpm.shear_strength import shear_strength
from tilth.mpm.soil import Soil
from tilth.mpm.water import PhreaticSurface
from tilth.surface.loads import DeclaredLoad, declared_loads
from tilth.terms.loads import Loads
from tilth.terms.protocol import Term

ROUND_OFF = 1e-14
"""Residual forces below this share of Young's modulus times a cell's face count as zero."""


@dataclass(frozen=True)
class Setup:
    """What steps of an analysis, or of one of its stages, are taken by.

    Attributes:
        model: the declared problem.
        loads: on its points.
        surface_loads: those on surfaces.
        water: the phreatic surface; None without water.
        grid_motion: the background grid over time.
        has_friction: whether some soil has friction by a law that says what its strength is.
        round_off: residual that counts as zero [force].
        attempts: settings of Newton's iteration with which a step is tried, one after the other.
        terms: makers of the terms of the balance, in their order; weak springs follow.
        fields: further fields than the displacement and those of the state.
    """

    model: Model
    loads: Loads
    surface_loads: Sequence[DeclaredLoad]
    water: PhreaticSurface | None
    grid_motion: GridMotion
    has_friction: bool
    round_off: float
    attempts: Sequence[Newton]
    terms: Sequence[Maker]
    fields: Sequence[FieldOwner] = ()

    @classmethod
    def of(
        cls,
        model: Model,
        loads: Loads,
        state: State,
        terms: Sequence[Maker],
        fields: Sequence[FieldOwner] = (),
    ) -> Setup:
        """Returns that of a model; state: with which it begins."""
        young = float(state.points.elastic_moduli().young.max())
        round_off = ROUND_OFF * young * largest_face(state.grid)
        touching = bool(state.contact_surfaces or state.body_contacts)
        return cls(
            model=model,
            loads=loads,
            surface_loads=declared_loads(model),
            water=PhreaticSurface.of(model),
            grid_motion=GridMotion(model, state.implicit),
            has_friction=bool((shear_strength(state.points, model)[1] > 0.0).any()),
            round_off=round_off,
            attempts=newton_attempts(model.analysis, {MOMENTUM: round_off}, touching),
            terms=terms,
            fields=fields,
        )

    @property
    def kind(self) -> str:
        """Kind of analysis: "plane_strain", "axisymmetric" or "3d"."""
        return self.model.analysis.kind

    def with_tolerance(self, largest: float) -> Setup:
        """Returns the same with a relative residual of at most `largest` in each attempt [-]."""
        least = min(largest, self.model.analysis.tolerance)
        attempts = [replace(newton, tolerance=least) for newton in self.attempts]
        return replace(self, attempts=attempts)


@dataclass(frozen=True)
class InStep:
    """What the terms of a step are made from.

    Attributes:
        setup, state: of the analysis.
        step: the grid and the conditions.
        soil: on the grid of the step.
        stiffening: factor of the moduli of points on a frozen geometry [-].
    """

    setup: Setup
    state: State
    step: PreparedStep
    soil: Soil
    stiffening: float = 1.0


Maker = Callable[[InStep], Sequence[Term]]
"""Makes the terms of one kind in a step; none where they do not act."""


class FieldOwner(Stateful, Protocol):
    """Has the values of a field from step to step; a term of the balance stores them.

    Attributes:
        name: of the field.
    """

    name: str

    def in_step(self, of: InStep) -> Field:
        """Returns the field on the nodes of a step, with its start and what is prescribed."""
        ...
