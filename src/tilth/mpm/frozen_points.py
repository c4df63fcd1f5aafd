# SPDX-License-Identifier: BSD-3-Clause
"""Material points on a frozen geometry, with reduced strength (docs/theory/strength_reduction.md).

A copy of the points in which all moduli are multiplied, and all elastic strains divided, by the
same large factor has the same stresses. Its displacements are divided by the factor, too, so that
they do not change the geometry.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.comm import SERIAL, Communicator, total
from tilth.errors import BadInput
from tilth.model import Model
from tilth.model.davis import DavisForm
from tilth.model.isotropic import AnyMaterial
from tilth.model.laws import Law
from tilth.model.parameter_kinds import has_strength, reduced, stiffened
from tilth.model.problems import dotted
from tilth.mpm.points import MaterialPoints, PointRange

FROZEN_STRAIN = 1e-7
"""Mean elastic strain on the frozen geometry [-]."""


def require_reducible(model: Model, davis: DavisForm | None = None) -> None:
    """Checks that the strength of all materials can be reduced, and that one of them can fail.

    davis: form of Davis' equivalent that is asked for.

    Raises:
        BadInput: names each material whose strength cannot be reduced; a law of the user cannot be
            loaded.
    """
    used = dict.fromkeys(name for body in model.present_bodies for name in body.materials)
    materials = {name: (model.materials[name], model.laws[name]) for name in used}
    problems = [
        problem
        for name, (material, law) in materials.items()
        for problem in material.irreducible(dotted(("materials", name)), law, davis)
    ]
    if problems:
        raise BadInput.of(problems)
    if not any(
        has_strength(material.parameter_kinds_of(law)) or has_strength(material.state_kinds_of(law))
        for material, law in materials.values()
    ):
        raise BadInput(
            "all materials are elastic: nothing can fail",
            "give the soil a strength, such as that of mohr_coulomb or tresca",
            key="materials",
        )


def thickness(points: MaterialPoints, comm: Communicator = SERIAL) -> float:
    """Returns the thickness of the soil of all processes [length], whatever its direction.

    It is exact for a layer: the extent along the principal axis of its volume with the least
    variance, which is thickness^2 / 12.

    points: those that this process owns.
    """
    volume, position = points.volume, points.position
    whole = comm.sum(float(volume.sum()))
    centre = total(comm, (position * volume[:, None]).sum(axis=0)) / whole
    arm = position - centre
    variance = np.linalg.eigvalsh(total(comm, (arm * volume[:, None]).T @ arm) / whole)
    return float(np.sqrt(12.0 * max(float(variance[0]), 0.0)))


def mean_elastic_strain(points: MaterialPoints, comm: Communicator = SERIAL) -> float:
    """Returns the mean norm of the elastic strain over the volume of all processes' soil [-].

    points: those that this process owns.
    """
    strain = points.elastic_strain
    norm = np.sqrt((strain[:, :3] ** 2).sum(axis=1) + 2.0 * (strain[:, 3:] ** 2).sum(axis=1))
    volume = points.volume
    return comm.sum(float((norm * volume).sum())) / comm.sum(float(volume.sum()))


class FrozenPoints:
    """A copy of the points of a model with moduli so large that the geometry does not change.

    All soil counts as flowing, so that the ghost stabilisation does not carry load in its place.

    Attributes:
        points: the copy, with the strength as it is.
        stiffening: factor of the moduli [-].
    """

    def __init__(self, model: Model, points: MaterialPoints, stiffening: float) -> None:
        self.stiffening = stiffening
        self._model = model
        self._laws: dict[tuple[int, int], Law] = {}
        arrays: dict[str, Any] = {name: each.copy() for name, each in points.arrays().items()}
        copy = MaterialPoints(ranges=points.ranges, varying=points.varying, **arrays)
        copy.elastic_strain = points.elastic_strain / stiffening
        copy.plastic[:, 0] /= stiffening
        copy.elastic_share[:] = 0.0
        for range_ in points.ranges:
            kinds = self._material(range_).state_kinds_of(range_.law)
            for column, name in enumerate(range_.law.state_variables):
                state = copy.state[range_.points, column]
                copy.state[range_.points, column] = stiffened(kinds[name], state, stiffening)
        self.points = copy
        self.points = self._with(
            [
                self._material(range_).stiffened_parameters(
                    points.parameters_of(range_), stiffening
                )
                for range_ in points.ranges
            ],
            [self._law(range_) for range_ in points.ranges],
        )

    def _material(self, range_: PointRange) -> AnyMaterial:
        """Returns the material of a range of points."""
        return self._model.materials[self._model.bodies[range_.body].materials[range_.layer]]

    def _law(self, range_: PointRange) -> Law:
        """Returns the stiffened law of a range of points, one for all ranges of a layer."""
        key = (range_.body, range_.layer)
        if key not in self._laws:
            material = self._material(range_)
            self._laws[key] = material.stiffened_law(range_.law, self.stiffening)
        return self._laws[key]

    def range(self, range_: PointRange) -> PointRange:
        """Returns a range of points on the frozen geometry, with the strength as it is."""
        own = range_.parameters
        if own is not None:
            own = self._material(range_).stiffened_parameters(own, self.stiffening)
        return replace(range_, parameters=own, law=self._law(range_))

    def reduced(self, factor: float, davis: DavisForm | None = None) -> MaterialPoints:
        """Returns the points with their strength over a factor [-].

        The state is shared, except where state variables are strengths.

        davis: form of Davis' associated equivalent, see `AnyMaterial.reduced_strength`.
        """
        points = self.points
        weaker = self._with(
            [
                self._material(range_).reduced_parameters(
                    points.parameters_of(range_), factor, davis
                )
                for range_ in points.ranges
            ],
            [self._material(range_).reduced_law(range_.law, factor) for range_ in points.ranges],
        )
        return replace(weaker, state=self._reduced_state(factor))

    def _reduced_state(self, factor: float) -> Floats:
        """Returns the state variables with their strengths over a factor, shape (n, columns)."""
        state = self.points.state
        for range_ in self.points.ranges:
            kinds = self._material(range_).state_kinds_of(range_.law)
            if not has_strength(kinds):
                continue
            if state is self.points.state:
                state = state.copy()
            columns = {
                name: state[range_.points, i] for i, name in enumerate(range_.law.state_variables)
            }
            for i, column in enumerate(reduced(kinds, columns, factor).values()):
                state[range_.points, i] = column
        return state

    def _with(self, parameters: Sequence[Floats], laws: Sequence[Law]) -> MaterialPoints:
        """Returns the points with other parameters of each range, (m,) or (n, m), and laws."""
        ranges, varying = [], self.points.parameters.copy()
        for range_, own, law in zip(self.points.ranges, parameters, laws, strict=True):
            if range_.parameters is None:
                varying[range_.points, : own.shape[1]] = own
            fixed = None if range_.parameters is None else own
            ranges.append(replace(range_, parameters=fixed, law=law))
        return replace(self.points, ranges=ranges, parameters=varying)
