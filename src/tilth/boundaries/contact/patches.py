# SPDX-License-Identifier: BSD-3-Clause
"""One surface in contact in one step: mean gaps and slips of its multipliers, and its tractions.

The patches are those of the implicit boundary method (`boundaries/surfaces/multipliers.py`),
selected for the normal direction; the shear tractions have the same patches. With the quadrature
weights a_q of the active points, f_q the normal and the tangents, d the displacement of the
surface and g_q the gap at the start of the step,

    A = sum_q a_q,   m = (1/A) sum_q a_q [f_q . (u(y_q) - d_q) + g_q (normal only)],
    traction of each point: f_q sigma(m), with the law of `law.py`.

u is taken at y_q, where the normal through the point meets the soil. A point is active if its gap
and slip count in the means of its patch.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.contact.constraint import NEAR, ContactConstraint
from tilth.boundaries.contact.law import ContactLaw, ContactResponse, first_slip, respond
from tilth.terms.space import Coupled, entries_of

INEXACT_DRIFT, SCATTER_OF_MEANS = 0.02, 0.25
"""Difference, in the mean over a patch, between measured and carried gaps that is not drift: in
cells, and as a share of the scatter of measured gaps."""

LARGEST_DRIFT = 0.01
"""By how much a patch follows what is measured in one step, in cells."""

RENEWAL = 1e-3
"""Relative difference of a given shear strength from that of the pressure that is left."""

LARGEST_GAP = 0.005
"""Gap in cells at which points of a body with inertia have no share; it increases linearly to 1 at
the soil. A wider layer lets a body on stiff soil sink in, a thinner one lets it roll on its points.
"""

LEAST_TURN = 1e-12
"""Angle [rad] from which a surface turns in a step."""


class Patches:
    """The patches of a surface's m multipliers and their mean gaps and slips.

    Args:
        part: the points, with the multiplier of each.
        nodes: number of nodes of the grid.
        still: whether what is in contact at the start, or holds soil by a bilateral law, keeps its
            gaps: the step is only to give the accelerations at the start, and a gap that is closed
            in it would be one of them; or the geometry is frozen, and the soil too stiff to close
            one.

    Attributes:
        active: which points are active, shape (n,).
        area: of the patches [length^(dim - 1)], shape (m,); 0 where no point is active.
        node_start, node: nodes of each multiplier, ragged, shapes (m + 1,), (entries,).
        row: integrals of N f over the patches, shape (dim, entries, dim), normal first.
        frame: normal and tangents at the points, shape (dim, n, dim).
        first_gap: gaps of the points at the start of the step [length], shape (n,), less
        left: what of them is left to the next step, shape (n,).
        before: carried mean tractions [stress], shape (m, dim).
        law_before: `law` beside the water at the start of the step.
        stiffness: e_n and e_t [stress/length], shape (m, 2).
        law: of each multiplier.
        slip: directions in which they slide at the last linearisation, shape (m, dim - 1).
        given: whether the shear strength is given: that of the pressure at the start of the step,
        strength: or this one [stress], shape (m,).
        share: of each point in the mean over its patch [-], shape (n,).
        fixed: which are closed, whatever their traction, shape (m,); None by the law.
    """

    slip: Floats
    given: bool
    strength: Floats | None
    fixed: Flags | None
    node_start: Integers
    node: npt.NDArray[np.int32]

    def __init__(self, part: ContactConstraint, nodes: int, still: bool = False) -> None:
        self.part, self._still = part, still
        multiplier, normal = part.multiplier, part.pose.normal
        self.count = int(multiplier.max(initial=-1)) + 1
        self.frame = frames(normal, part.pose.weight, multiplier, self.count)
        trace = part.trace
        code = multiplier[trace.place] * np.int64(nodes) + trace.node
        found, self._entry = np.unique(code, return_inverse=True)
        self.entry_multiplier = found // nodes
        self.node = (found % nodes).astype(np.int32)
        self.node_start = np.searchsorted(self.entry_multiplier, np.arange(self.count + 1))
        self.restart()

    def restart(self, cautious: bool = False, deferring: bool = False) -> None:
        """Sets the state at the start of the step.

        cautious: whether the shear strength is that at the start of the step, and patches in
            contact begin without points near the soil, whose gap in the mean would open them.
        deferring: whether patches close no more of their mean gap than the surface moves in this
            step, so that a smaller step has less to close, and leave the rest to the next one. The
            mean gap is drift, and the mean of carried gaps where the points were in other patches.
        """
        self.given, self.strength = cautious, None
        self.fixed = None
        self.share = np.ones(len(self.part.chosen))
        self.added = np.zeros((self.count, len(self.frame)))
        touch, cell = self.part.touch, self.part.boundary.cell
        drift = self._drift()
        mean_gap = self._mean_in_contact(touch.gap) + drift
        motion = np.linalg.norm(self.part.pose.increment, axis=1).max(initial=0.0)
        left = mean_gap - mean_gap.clip(-motion, motion)
        self.left = left if deferring else np.zeros_like(mean_gap)
        self.first_gap = touch.gap + drift - self.left
        nearest = max(float(touch.gap.min(initial=np.inf)), 0.0)
        near = touch.gap < nearest + NEAR * cell
        if cautious:
            multiplier = self.part.multiplier
            near &= np.bincount(multiplier[touch.closed], minlength=self.count)[multiplier] == 0
        self.activate(touch.closed | near)
        self.slip = first_slip(self.law_before, self.before)

    def fix(self, slip: Floats) -> None:
        """Fixes which multipliers are closed by their mean gaps [length], shape (m, dim)."""
        self.fixed = self.law.holds(self.trial(slip)[:, 0])

    def select(self, gap: Floats, level: float) -> None:
        """Makes points active by their gaps at the end of the step for a predicted motion.

        A body that rolls leaves soil behind and comes to other soil ahead; the mean gaps, and so
        the path of the body, must not jump.

        gap: [length], shape (n,). level: gap from which on the share decreases [length].
        """
        share = 1.0 - (gap - level) / (LARGEST_GAP * self.part.boundary.cell)
        self.share = np.clip(share, 0.0, 1.0)
        self.activate(self.share > 0.0)

    def _drift(self) -> Floats:
        """Returns by how much points in contact follow what is measured in a step [length], (n,).

        The gaps carried are those of patches; along a curved surface soil drifts off it while it
        slides. The measured gaps are followed in the mean over a patch, beyond their inexactness.
        They are not followed along flat faces that do not turn: there nothing drifts, and domains
        of sheared soil do not end at the surface.
        """
        touch, cell = self.part.touch, self.part.boundary.cell
        if self.part.boundary.is_flat and not self._turns():
            return np.zeros(len(touch.gap))
        drift = self._mean_in_contact(touch.moved - touch.gap)
        unknown = INEXACT_DRIFT * cell + SCATTER_OF_MEANS * self._mean_in_contact(touch.scatter)
        beyond = np.sign(drift) * np.maximum(np.abs(drift) - unknown, 0.0)
        return np.asarray(np.clip(beyond, -LARGEST_DRIFT * cell, LARGEST_DRIFT * cell))

    def _turns(self) -> bool:
        """Returns whether the surface turns in the step by a prescribed motion."""
        gradient = self.part.pose.gradient
        return bool((np.abs(gradient - gradient.transpose(0, 2, 1)) > LEAST_TURN).any())

    def _mean_in_contact(self, value: Floats) -> Floats:
        """Returns at points in contact at the start the means over their patch, others 0, (n,).

        value: of the points, shape (n,).
        """
        multiplier, closed = self.part.multiplier, self.part.touch.closed
        weight = np.where(closed, self.part.pose.weight, 0.0)
        area = np.bincount(multiplier, weight, self.count)
        mean = np.bincount(multiplier, weight * value, self.count) / np.where(area > 0.0, area, 1.0)
        return np.where(closed, mean[multiplier], 0.0)

    def activate(self, active: Flags) -> None:
        """Sets which points are active, shape (n,)."""
        part, dim = self.part, len(self.frame)
        self.active = active
        self.weight = np.where(active, part.pose.weight * self.share, 0.0)
        self.area = self._sum(np.ones(len(active)))
        self._divisor = np.where(self.area > 0.0, self.area, 1.0)
        self.row = np.zeros((dim, len(self.node), dim))
        for a in range(dim):
            for j in range(dim):
                self.row[a, :, j] = self._integrals(self.frame[a, :, j])
        self._value: Floats | None = None
        self.gap = self._sum(self.first_gap) / self._divisor
        self.before = self.mean(part.before)
        soft = np.stack([self._sum(1.0 / each) for each in part.stiffness.T], axis=1)
        self.stiffness = self._divisor[:, None] / np.where(soft > 0.0, soft, 1.0)
        law = part.law
        self.law = ContactLaw(
            self._mean_of(law.cohesion),
            self._mean_of(law.friction),
            self._mean_of(law.limit),
            self._mean_of(law.tension),
            self._sum(law.bilateral.astype(np.float64)) > 0.5 * self.area,
        )
        self.law_before = self.law.under(self._mean_of(part.pore_pressure))
        if self._still:
            self.gap[part.multiplier[part.touch.closed]] = 0.0
            self.gap[self.law.bilateral] = 0.0

    def _integrals(self, factor: Floats) -> Floats:
        """Returns the integrals of N times a factor of the points (n,) over the patches."""
        trace = self.part.trace
        value = (self.weight * factor)[trace.place] * trace.value
        return np.asarray(np.bincount(self._entry, value, len(self.node)), dtype=np.float64)

    def _sum(self, value: Floats) -> Floats:
        total = np.bincount(self.part.multiplier, self.weight * value, minlength=self.count)
        return np.asarray(total, dtype=np.float64)

    def _mean_of(self, value: Floats) -> Floats:
        if np.isfinite(value).all():
            return np.asarray(self._sum(value) / self._divisor)
        unbounded = self._sum(np.isinf(value).astype(np.float64)) > 0.5 * self.area
        finite = np.isfinite(value)
        weight = self._sum(finite.astype(np.float64))
        mean = self._sum(np.where(finite, value, 0.0)) / np.where(weight > 0.0, weight, 1.0)
        return np.where(unbounded, np.inf, mean)

    def mean(self, vector: Floats) -> Floats:
        """Returns the means of vectors (n, dim) along normal and tangents, shape (m, dim)."""
        along = np.einsum("ani,ni->na", self.frame, vector)
        total = np.stack([self._sum(each) for each in along.T], axis=1)
        return np.asarray(total / self._divisor[:, None])

    def slips(self, displacement: Floats, moved: Floats) -> Floats:
        """Returns mean gaps and slips [length], shape (m, dim).

        displacement: of the nodes, (nodes, dim). moved: displacement of the surface's points,
        (n, dim).
        """
        along = np.einsum("aei,ei->ea", self.row, displacement[self.node])
        total = np.add.reduceat(along, self.node_start[:-1], axis=0)
        slip = total / self._divisor[:, None] - self.mean(moved)
        slip[:, 0] += self.gap
        return np.asarray(slip)

    @property
    def value(self) -> Floats:
        """Integrals of N over the patches [length^(dim - 1)], shape (entries,)."""
        if self._value is None:
            self._value = self._integrals(np.ones(len(self.active)))
        return self._value

    def pore_pressure(self, nodal: Floats) -> Floats:
        """Returns the mean excess pore pressures [stress], shape (m,), of nodal ones (nodes, 1)."""
        total = np.add.reduceat(self.value * nodal[self.node, 0], self.node_start[:-1])
        return np.asarray(total / self._divisor)

    def trial(self, slip: Floats) -> Floats:
        """Returns the trial tractions [stress], (m, dim), of mean gaps and slips of this shape."""
        stiffness = np.repeat(self.stiffness, (1, slip.shape[1] - 1), axis=1)
        trial = self.before + self.added + stiffness * slip
        trial[self.area <= 0.0] = 0.0
        return trial

    def respond(
        self, slip: Floats, pore_pressure: Floats, held: Flags | None = None
    ) -> ContactResponse:
        """Returns the response to mean gaps and slips [length], shape (m, dim).

        pore_pressure: mean excess [stress], shape (m,).
        held: which multipliers are not to open now, shape (m,).
        """
        given = self._given_strength if self.given else None
        law, trial, fixed = self.law.under(pore_pressure), self.trial(slip), self.fixed
        return respond(law, trial, self.stiffness, self.slip, given, held, fixed)

    def respond_at_guess(self, slip: Floats, pore_pressure: Floats) -> ContactResponse:
        """As `respond`, but what was pressed, or stuck, at the start of the step still is."""
        pressed = (self.before[:, 0] < 0.0) & (self.area > 0.0)
        strength = self.law_before.strength(-self.before[:, 0])[0]
        given = np.where(pressed & ~self.slip.any(axis=1), np.inf, strength)
        law, trial, fixed = self.law.under(pore_pressure), self.trial(slip), self.fixed
        return respond(law, trial, self.stiffness, self.slip, given, pressed, fixed)

    def renew_strength(self, slip: Floats, pore_pressure: Floats) -> bool:
        """Sets a given shear strength to that of the pressures now; returns whether it changes.

        slip: mean gaps and slips [length], shape (m, dim). pore_pressure: as in `respond`.
        """
        if not self.given:
            return False
        response = self.respond(slip, pore_pressure)
        closed, law = response.closed & (self.area > 0.0), self.law.under(pore_pressure)
        now = np.where(closed, law.strength(-response.traction[:, 0])[0], 0.0)
        used = np.where(closed, self._given_strength, 0.0)
        self.strength = now
        return bool(np.abs(now - used).max(initial=0.0) > RENEWAL * np.abs(now).max(initial=0.0))

    @property
    def _given_strength(self) -> Floats:
        """Shear strength in place of that of the pressure [stress], shape (m,)."""
        if self.strength is not None:
            return self.strength
        return self.law_before.strength(-self.before[:, 0])[0]

    def violation(self, slip: Floats) -> Floats:
        """Returns by how much fixed contact is against the law [stress], shape (m,), 0 if not.

        Tension beyond the tensile strength where it is closed, pressure where it is open.
        """
        assert self.fixed is not None
        normal = self.trial(slip)[:, 0]
        wrong = (self.law.holds(normal) != self.fixed) & (self.area > 0.0)
        return np.where(wrong, np.abs(normal - self.law.tension), 0.0)

    def augment(self, slip: Floats, chosen: Flags) -> None:
        """Adds the normal tractions of the chosen multipliers, (m,), to the carried ones."""
        self.added[:, 0] += np.where(chosen, self.stiffness[:, 0] * slip[:, 0], 0.0)

    def close(self, chosen: Integers, gap: Floats) -> None:
        """Takes the gaps (k,) of the chosen points, (k,), for inexact knowledge of the surface."""
        self.first_gap[chosen] -= gap

    @property
    def has_friction(self) -> bool:
        """Whether some point has friction."""
        return bool((self.part.law.friction > 0.0).any())

    def by_pore_pressure(self, response: ContactResponse) -> Floats:
        """Returns the derivatives of `entry_force` by nodal pressures, (entry pairs, dim, 1).

        Of all pairs of entries of a multiplier, row by row, as `entries_of` has them.
        """
        number = np.arange(len(self.node), dtype=np.int32)
        row, column = entries_of(Coupled(self.node_start, number))
        force = self.entry_force(response.by_pore_pressure / self._divisor[:, None])
        return np.asarray((force[row] * self.value[column, None])[:, :, None])

    def columns(self, response: ContactResponse) -> Floats:
        """Returns sum_a B^a D^ab / A for each b, shape (dim, entries, dim)."""
        by_area = response.derivative / self._divisor[:, None, None]
        return np.ascontiguousarray(
            np.einsum("aei,eab->bei", self.row, by_area[self.entry_multiplier])
        )

    def entry_force(self, traction: Floats) -> Floats:
        """Returns the internal force of mean tractions (m, dim) on each entry, (entries, dim)."""
        return np.asarray(np.einsum("aei,ea->ei", self.row, traction[self.entry_multiplier]))

    def distribute(self, traction: Floats) -> Floats:
        """Returns the points' tractions [stress], (n, dim), for those of the multipliers."""
        at_points = np.einsum("na,ani->ni", traction[self.part.multiplier], self.frame)
        return np.where(self.active[:, None], at_points, 0.0)

    def gaps(self, displacement: Floats, moved: Floats) -> Floats:
        """Returns the gaps at all points after a displacement [length], shape (n,)."""
        slip = self.part.trace.interpolate(displacement) - moved
        return np.asarray(self.first_gap + np.einsum("ni,ni->n", self.part.pose.normal, slip))


def select_by_gaps(patches: Sequence[Patches], gaps: Sequence[Floats]) -> None:
    """Makes points of a body active by their gaps at the end of the step, as `Patches.select`.

    Without contact before only those nearest to the soil, not all that would be in it after free
    fall. gaps: for a predicted motion, of each patch's points [length].
    """
    own = [g[s.part.pose.weight > 0.0] for g, s in zip(gaps, patches, strict=True)]
    lowest = min((float(each.min(initial=np.inf)) for each in own), default=np.inf)
    if any(patch.part.touch.closed.any() for patch in patches):
        lowest = max(lowest, 0.0)
    for patch, gap in zip(patches, gaps, strict=True):
        patch.select(gap, lowest)


def frames(normal: Floats, weight: Floats, multiplier: Integers, count: int) -> Floats:
    """Returns normals and tangents of points, shape (dim, n, dim), continuous in each patch.

    The tangents follow from those of a patch's mean normal by the smallest rotation onto the
    point's normal. In the mean the points of a patch without any weight count alike.
    """
    dim = normal.shape[1]
    if dim == 2:
        return np.stack([normal, np.stack([-normal[:, 1], normal[:, 0]], axis=1)])
    weight = np.where(
        np.bincount(multiplier, weight, minlength=count)[multiplier] > 0.0, weight, 1.0
    )
    total = np.stack(
        [np.bincount(multiplier, weight * each, minlength=count) for each in normal.T], axis=1
    )
    mean = (total / np.linalg.norm(total, axis=1)[:, None])[multiplier]
    one = np.eye(3)[np.abs(mean).argmin(axis=1)]
    one = one - np.einsum("ni,ni->n", one, mean)[:, None] * mean
    one /= np.linalg.norm(one, axis=1)[:, None]
    tangents = []
    for tangent in (one, np.cross(mean, one)):
        along = np.einsum("ni,ni->n", normal, tangent)
        factor = along / (1.0 + np.einsum("ni,ni->n", normal, mean))
        turned = tangent - factor[:, None] * (mean + normal)
        tangents.append(turned / np.linalg.norm(turned, axis=1)[:, None])
    return np.stack([normal, *tangents])
