# SPDX-License-Identifier: BSD-3-Clause
"""Contact surfaces and rigid bodies for the results, the same ones in every output of a run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tilth.analysis.rigid_shapes import placed, rigid_shapes
from tilth.analysis.state import State
from tilth.analysis.step_result import StepResult
from tilth.model import ImplicitBoundary, Model
from tilth.mpm.points import MaterialPoints
from tilth.output.snapshot import ContactShape, SurfaceShape
from tilth.terms.outcome import ContactState


def contact_names(model: Model) -> list[str]:
    """Returns the names of all boundaries with a law of contact, rigid bodies and contact pairs."""
    laws = [b.name for b in model.boundaries if isinstance(b, ImplicitBoundary) and b.contact]
    bodies, pairs = (body.name for body in model.rigid_bodies), model.contact_pairs
    return [*laws, *bodies, *(pair.name for pair in pairs)]


class ContactOutput:
    """What the outputs of a run show of contact and rigid bodies.

    Args:
        model: the whole model.
        initial: its undeformed points.

    Raises:
        BadInput: see `rigid_shapes`.
    """

    def __init__(self, model: Model, initial: MaterialPoints) -> None:
        self._names, self._dim = contact_names(model), model.dimension
        self._shapes = rigid_shapes(model, initial)

    def contacts(self, result: StepResult | None) -> tuple[ContactShape, ...]:
        """Returns the contact surfaces after a step (`result` None: before the first one)."""
        found: Mapping[str, ContactState] = {} if result is None else result.contacts
        return tuple(
            _shape(name, found[name]) if name in found else ContactShape.empty(name, self._dim)
            for name in self._names
        )

    def rigid_bodies(self, state: State) -> tuple[SurfaceShape, ...]:
        """Returns the surfaces of the rigid bodies where they are."""
        return tuple(shape.at(*placed(state, name)) for name, shape in self._shapes.items())


def _shape(name: str, state: ContactState) -> ContactShape:
    return ContactShape(
        name,
        state.position,
        {
            "normal": state.normal,
            "area": state.weight,
            "normal_stress": state.normal_stress,
            "shear_stress": state.shear_stress,
            "gap": state.gap,
            "in_contact": state.in_contact.astype(np.int8),
            "sliding": state.sliding.astype(np.int8),
        },
    )
