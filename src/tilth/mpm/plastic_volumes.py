# SPDX-License-Identifier: BSD-3-Clause
"""F-bar and plastic volume changes: each point keeps its own (docs/theory/f_bar.md).

With one volume change for all points of a cell only the cell's mean pressure enters equilibrium.
Where plastic flow dilates by different amounts d, the pressures of the points drift apart without
end: they rise where the soil shears most, which makes it the stronger the more it shears, and the
load never reaches a limit. So a point's volume change has what its own flow differs by from the
mean of its cells,

    ln J_bar_p = ln J0_p + k_p,    k_p = d_p - sum_e w_pe mean_e(d),

and the elastic parts, and with them the pressures, change alike within a cell. The mean of k in a
cell is zero.

k is fixed during Newton's iteration and revised at its solutions, with Anderson's acceleration
(1965), until the equilibrium belongs to it. That is done in the trials of strength reduction
only (docs/decisions/0044-own-plastic-volume.md).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats
from tilth.comm import Communicator, total
from tilth.mpm.f_bar import Centres
from tilth.mpm.points import MaterialPoints, PointRange

LAWS = ("mohr_coulomb", "drucker_prager")
"""Laws whose plastic volume change follows from the shear."""

SETTLED = 1e-3
"""Mean change of k over the mean elastic volumetric strain with which it is settled [-]."""

RELAXATION = 1.3
"""Factor of the changes: a plain revision leaves 0.3 to 0.5 of them."""

REMEMBERED = 5
"""Revisions from which the next one is extrapolated."""

REGULAR = 1e-10
"""Share of the trace that is added to the diagonal of the normal equations."""


def with_volume_change(elastic: Floats, change: Floats) -> Floats:
    """Returns elastic left Cauchy-Green tensors less the identity, (n, 6), of changed volume.

    change: of the logarithmic volumetric strain [-], shape (n,).
    """
    identity = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    return np.asarray(elastic + np.expm1(2.0 / 3.0 * change)[:, None] * (elastic + identity))


class PlasticVolumes:
    """The differences of plastic volume change within the cells in one step.

    Args:
        points: at the start of the step.
        centres: the cells of each range with F-bar, None for others.
        own: which points this process owns, shape (n,).
        comm: the processes that share the points.

    Attributes:
        difference: k of the points [-], shape (n,).
    """

    def __init__(
        self,
        points: MaterialPoints,
        centres: Sequence[Centres | None],
        own: Flags | None,
        comm: Communicator,
    ) -> None:
        self._points, self._own, self._comm = points, own, comm
        self._ranges: list[tuple[PointRange, Centres]] = [
            (range_, each)
            for range_, each in zip(points.ranges, centres, strict=True)
            if each is not None and range_.law.name in LAWS
        ]
        self.difference = np.zeros(len(points))
        self._tried: list[tuple[Floats, Floats]] = []

    def scaled(self, elastic: Floats, before: Floats | float = 0.0) -> Floats:
        """Returns elastic deformation [-], (n, 6), with the differences.

        before: those that it has already, shape (n,).
        """
        missing = self.difference - before
        if not missing.any():
            return elastic
        return with_volume_change(elastic, missing)

    def restart(self) -> None:
        """Begins anew with the revisions; the differences stay."""
        self._tried.clear()

    def revise(self, elastic: Floats, plastic_strain: Floats) -> float:
        """Revises the differences by those of a trial state; returns how far they are from settled.

        Args:
            elastic: elastic deformation of the trial state [-], shape (n, 6).
            plastic_strain: equivalent plastic strain in the step [-], shape (n,).

        Returns:
            Mean change over the mean elastic volumetric strain and `SETTLED`, by volume: at most 1
            if they are settled, and have not been changed.
        """
        if not self._ranges:
            return 0.0
        before = _core.volumetric_strains(self._points.elastic_deformation)
        after = _core.volumetric_strains(elastic)
        change = np.zeros_like(after)
        for range_, centres in self._ranges:
            s = range_.points
            flow = before[s] + np.log(centres.jacobian) + self.difference[s] - after[s]
            flow[plastic_strain[s] == 0.0] = 0.0
            change[s] = centres.differences(flow, self._points.volume[s]) - self.difference[s]
        own = slice(None) if self._own is None else self._own
        weight = self._points.volume[own]
        size = self._comm.sum(float(weight @ np.abs(change[own])))
        most = SETTLED * self._comm.sum(float(weight @ np.abs(after[own])))
        if size <= most:
            return size / most if most > 0.0 else 0.0
        self._tried = [*self._tried[-REMEMBERED:], (self.difference, change)]
        self.difference = self._extrapolated(own)
        return size / most if most > 0.0 else np.inf

    def _extrapolated(self, own: Flags | slice) -> Floats:
        """Returns the differences at which the changes would vanish, were they linear in them."""
        *earlier, (last, change) = self._tried
        if not earlier:
            return last + RELAXATION * change
        moves = np.array([last - each for each, _ in earlier])
        changes = np.array([change - each for _, each in earlier])
        normal = total(self._comm, changes[:, own] @ changes[:, own].T)
        right = total(self._comm, changes[:, own] @ change[own])
        normal += REGULAR * np.trace(normal) * np.eye(len(normal))
        share = np.linalg.lstsq(normal, right, rcond=None)[0]
        return np.asarray(last - share @ moves + RELAXATION * (change - share @ changes))
