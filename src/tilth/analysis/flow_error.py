# SPDX-License-Identifier: BSD-3-Clause
"""The local error of steps with flowing water."""

from __future__ import annotations

import math

import numpy as np

from tilth import _core
from tilth.algebra.unknowns import Unknowns
from tilth.analysis.dynamics import SAFETY, WITHIN
from tilth.arrays import Floats, Integers
from tilth.errors import StepFailed
from tilth.grid.keys import find_keys
from tilth.terms.balance import Balance
from tilth.terms.filled_cells import cell_places, centre_radii
from tilth.terms.pore_water import PORE_PRESSURE, WaterInStep
from tilth.terms.protocol import Role


class FlowError:
    """The local error of the pore pressure in a step of backward Euler (Sloan and Abbo 1999).

    Half of the size of the step times the change, since the last step, of the rate at which water
    flows to a node, times the modulus of the soil there. The pressure's own rate would jump with
    the load. Before the first step of a stage nothing flows.

    Args:
        most: largest one [stress].

    Attributes:
        rate: of the water that flows to the nodes of the last step, over the volume of soil there
            [1/time], shape (nodes, 1).
    """

    def __init__(self, most: float) -> None:
        self._most = most
        self.rate: Floats = np.zeros((0, 1))
        self._rate = self.rate  # in the step that is not committed yet

    def possible_size(
        self, water: WaterInStep, balance: Balance, x: Unknowns, key: Integers
    ) -> float:
        """Returns the size of a step, relative to this one, that keeps the error in limits.

        Where the pressure is not given; all processes call it.

        key: of the nodes of the last step.

        Raises:
            StepFailed: it must be shorter.
        """
        active, field = balance.active, balance.fields[PORE_PRESSURE]
        self._rate = np.zeros((active.nodes, 1))
        if water.size == 0.0:
            return math.inf
        volume = np.maximum(water.nodal_volume, _least_volume(water))
        for term in balance.of_role(Role.FLOW):
            self._rate += term.evaluate(x)[PORE_PRESSURE] / (water.size * volume[:, None])
        before = np.zeros_like(self._rate)
        if len(self.rate):
            found = find_keys(key, active.key)
            before = np.where(found[:, None] >= 0, self.rate[found], self._rate)
        change = np.abs(self._rate - before)[:, 0]
        if field.prescribed is not None:
            change[field.prescribed.constrained[:, 0]] = 0.0
        stiff = water.nodal_sums(water.soil.elastic_moduli.constrained)
        stiff /= np.maximum(water.nodal_volume, 1e-300)
        error = 0.5 * water.formula.size * (stiff * change)[field.owned]
        largest = balance.comm.max(float(error.max(initial=0.0)))
        possible = math.sqrt(self._most / max(largest, 1e-300))
        if possible < WITHIN:
            what = f"the local error of the pore pressure in the step is {largest:.3g}, but "
            remedy = "give a smaller schedule.minimum_step, or a larger flow.largest_error"
            what += f"flow.largest_error = {self._most:g}"
            raise StepFailed(what, remedy, share=SAFETY * possible)
        return possible

    def commit(self) -> None:
        """Keeps the rate of the step."""
        self.rate = self._rate


def _least_volume(water: WaterInStep) -> Floats:
    """Returns the least volume that counts for a node, of a corner of its cells, (nodes,).

    Less soil has rates that the accuracy in space decides.
    """
    active = water.soil.active
    cell = active.grid.sizes(cell_places(active, active.cell_keys)).prod(axis=1)
    if water.soil.kind == "axisymmetric":
        cell = cell * 2.0 * np.pi * centre_radii(active, active.cell_keys)
    node = active.corners(np.asarray(_core.lattice(active.cell_keys)))
    largest = np.zeros(active.nodes)
    np.maximum.at(largest, node, np.broadcast_to(cell[:, None], node.shape))
    return np.asarray(active.updated(largest) / node.shape[1])
