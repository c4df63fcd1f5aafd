# SPDX-License-Identifier: BSD-3-Clause
"""`ElementPoint`: the state of one material point, and the stress update that analyses use."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tilth import _core
from tilth.arrays import Floats
from tilth.errors import BadInput, StepFailed
from tilth.model.laws import EXCESS_PORE_PRESSURE, Law
from tilth.model.materials import Material
from tilth.mpm.interval import INSTANT, Interval
from tilth.mpm.soil import INVERTED

ROWS, COLUMNS = (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)
"""Rows and columns of the six components xx yy zz xy yz xz in a 3 x 3 matrix."""

_KIND = "3d"  # a point of every kind of analysis has six components of strain


@dataclass(frozen=True)
class Updates:
    """Stress updates for `n` displacement gradients of a step.

    Attributes:
        kirchhoff: Kirchhoff stress [stress], shape (n, 6).
        tangent: its derivative by the displacement gradient [stress], shape (n, 6, 3, 3).
        elastic, plastic, state: as those of `ElementPoint`, at the end, one row for each.
    """

    kirchhoff: Floats
    tangent: Floats
    elastic: Floats
    plastic: Floats
    state: Floats


@dataclass(frozen=True)
class ElementPoint:
    """A material point; tension positive. Components of symmetric tensors: xx yy zz xy yz xz.

    Attributes:
        law: the constitutive law.
        parameters: its parameters in the order of `law.parameters`, shape (count,).
        deformation_gradient: F since the start [-], shape (3, 3).
        elastic_deformation: elastic left Cauchy-Green tensor less the identity [-], shape (6,).
        plastic: equivalent plastic strain [-] and dissipated energy per initial volume
            [stress], shape (2,).
        state: state variables of the law, in the order of `law.state_variables`, shape (count,).
        stress: Cauchy stress [stress], shape (6,).
    """

    law: Law
    parameters: Floats
    deformation_gradient: Floats
    elastic_deformation: Floats
    plastic: Floats
    state: Floats
    stress: Floats

    @classmethod
    def at_start(cls, material: Material, stress: Floats, law: Law | None = None) -> ElementPoint:
        """Returns an undeformed point.

        Args:
            material: the declared material.
            stress: Cauchy stress at the start [stress], shape (6,), tension positive.
            law: that of the material; None for one of the core.

        Raises:
            BadInput: the law cannot have this stress.
        """
        law = material.law if law is None else law
        width = getattr(material, "softening_length", None) or 1.0  # of the band that softens
        parameters = np.array([material.parameter(name, width) for name in law.parameters])
        state = np.zeros((1, len(law.state_variables)))
        failed = _core.initial_state(_KIND, law.core, parameters, stress[None], state)
        elastic = np.zeros((1, 6))
        if failed < 0:
            failed = _core.elastic_deformation_of(
                _KIND, law.core, parameters, stress[None], state, elastic
            )
        point = cls(law, parameters, np.eye(3), elastic[0], np.zeros(2), state[0], stress)
        try:
            if failed >= 0:
                raise StepFailed("no elastic strain has this stress")
            found, _ = point.deformed(point.deformation_gradient)
        except StepFailed:
            what = "the law has no state with this stress"
            remedy = "check the parameters, or start from another stress, such as a compression"
            raise BadInput(what, remedy) from None
        if np.abs(found.stress - stress).max() > 1e-9 * np.abs(stress).max():
            what = "this stress is beyond the strength of the material"
            raise BadInput(what, "start from a stress inside the yield surface")
        return replace(point, state=found.state)

    def deformed(
        self, deformation_gradient: Floats, interval: Interval = INSTANT
    ) -> tuple[ElementPoint, Floats]:
        """Returns the point after one step, and the tangent d stress / d F [stress], (6, 3, 3).

        The derivative is the consistent one, of the Cauchy stress at the end of the step.

        Args:
            deformation_gradient: F at the end of the step, shape (3, 3).
            interval: the time that the step takes.

        Raises:
            StepFailed: the point inverts, or its return mapping fails.
        """
        backward = np.linalg.inv(self.deformation_gradient)
        updates = self.update((deformation_gradient @ backward - np.eye(3))[None], interval)
        jacobian = np.linalg.det(deformation_gradient)
        stress = updates.kirchhoff[0] / jacobian
        inverse = np.linalg.inv(deformation_gradient)
        slope = updates.tangent[0] @ backward.T
        after = replace(
            self,
            deformation_gradient=deformation_gradient,
            elastic_deformation=updates.elastic[0],
            plastic=updates.plastic[0],
            state=updates.state[0],
            stress=stress,
        )
        return after, slope / jacobian - np.multiply.outer(stress, inverse.T)

    def update(self, gradients: Floats, interval: Interval = INSTANT) -> Updates:
        """Returns what `n` different steps from this state give.

        Args:
            gradients: displacement gradients of the steps [-], shape (n, 3, 3).
            interval: the time that each of the steps takes.

        Raises:
            StepFailed: as `deformed`, for any of the steps.
        """
        count = len(gradients)

        def repeated(array: Floats) -> Floats:
            return np.repeat(array[None], count, axis=0)

        found = Updates(
            kirchhoff=np.empty((count, 6)),
            tangent=np.empty((count, 6, 3, 3)),
            elastic=np.empty((count, 6)),
            plastic=np.empty((count, 2)),
            state=np.zeros((count, len(self.state))),
        )
        _, status = _core.update_of_gradients(
            _KIND, self.law.core, self.parameters, gradients, repeated(self.elastic_deformation),
            repeated(self.plastic), repeated(self.state), found.elastic, found.plastic,
            found.state, found.kirchhoff, found.tangent, interval.array,
        )  # fmt: skip
        if status:
            inverted = "the material point inverted (det F <= 0)"
            raise StepFailed(inverted if status == INVERTED else self.law.failure)
        return found

    @property
    def jacobian(self) -> float:
        """Current over initial volume [-]."""
        return float(np.linalg.det(self.deformation_gradient))

    @property
    def has_pore_fluid(self) -> bool:
        """Whether the law itself has a pore fluid: its stress is then the total one."""
        return EXCESS_PORE_PRESSURE in self.law.state_variables

    @property
    def excess_pore_pressure(self) -> float:
        """That of the law's own pore fluid [stress], compression positive; 0 if it has none.

        The law's state variable belongs to the Kirchhoff stress, this one to the Cauchy stress.
        """
        if not self.has_pore_fluid:
            return 0.0
        number = list(self.law.state_variables).index(EXCESS_PORE_PRESSURE)
        return float(self.state[number]) / self.jacobian
