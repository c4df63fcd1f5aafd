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
from tilth.errors import BadInput, Problem
from tilth.model import Model
from tilth.model.davis import DavisForm
from tilth.model.isotropic import AnyMaterial
from tilth.model.problems import dotted
from tilth.mpm.points import MaterialPoints, PointRange

FROZEN_STRAIN = 1e-7
"""Mean elastic strain on the frozen geometry [-]."""


def require_reducible(model: Model) -> None:
    """Checks that the strength of all materials can be reduced, and that one of them can fail.

    Raises:
        BadInput: names each material whose strength cannot be reduced.
    """
    used = dict.fromkeys(name for body in model.present_bodies for name in body.materials)
    materials = {name: model.materials[name] for name in used}
    problems = []
    for name, material in materials.items():
        if not material.is_reducible:
            what = "the strength of this law cannot be reduced"
            remedy = "choose a law with c and phi or s_u, such as mohr_coulomb or tresca"
            key = dotted(("materials", name, "model"))
            problems.append(Problem(key, what, remedy, material.model))
    if problems:
        raise BadInput.of(problems)
    if not any(material.is_plastic for material in materials.values()):
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
        arrays: dict[str, Any] = {name: each.copy() for name, each in points.arrays().items()}
        copy = MaterialPoints(bodies=points.bodies, varying=points.varying, **arrays)
        copy.elastic_strain = points.elastic_strain / stiffening
        copy.plastic[:, 0] /= stiffening
        copy.elastic_share[:] = 0.0
        for body in points.bodies:
            for column, unit in enumerate(body.law.state_variables.values()):
                if unit == "-":
                    copy.state[body.points, column] /= stiffening
        self.points = copy
        self.points = self._with(
            [
                self._material(body).stiffened_parameters(points.parameters_of(body), stiffening)
                for body in points.bodies
            ]
        )

    def _material(self, body: PointRange) -> AnyMaterial:
        """Returns the material of a range of points."""
        return self._model.materials[self._model.bodies[body.body].materials[body.layer]]

    def range(self, body: PointRange) -> PointRange:
        """Returns a range of points on the frozen geometry, with the strength as it is."""
        if body.parameters is None:
            return body
        stiffened = self._material(body).stiffened_parameters(body.parameters, self.stiffening)
        return replace(body, parameters=stiffened)

    def reduced(self, factor: float, davis: DavisForm | None = None) -> MaterialPoints:
        """Returns the points with their strength over a factor [-]; the state is shared.

        davis: form of Davis' associated equivalent, see `AnyMaterial.reduced_strength`.
        """
        points = self.points
        return self._with(
            [
                self._material(body).reduced_parameters(points.parameters_of(body), factor, davis)
                for body in points.bodies
            ]
        )

    def _with(self, parameters: Sequence[Floats]) -> MaterialPoints:
        """Returns the points with other parameters of each range, (m,) or (n, m)."""
        bodies, varying = [], self.points.parameters.copy()
        for body, own in zip(self.points.bodies, parameters, strict=True):
            if body.parameters is None:
                varying[body.points, : own.shape[1]] = own
            bodies.append(replace(body, parameters=None if body.parameters is None else own))
        return replace(self.points, bodies=bodies, parameters=varying)
