# SPDX-License-Identifier: BSD-3-Clause
"""The forces of contact on one boundary or rigid body as a term of the balance.

Internal force of the soil: the sum over all multipliers of B^a sigma^a, with B^a the integral of
N f^a over the patch and sigma^a the traction along f^a, which depends on the mean gap and slips
m^a = B^a . u / A - D^a. Those of a rigid body depend on its free components g as well: with
G^a = dD^a/dg its balance is

    -sum_k A G^a sigma^a - applied forces = 0,

the derivative by m of the virtual work of the same tractions (docs/theory/contact.md). Where water
flows, friction depends on the mean excess pore pressure of each patch as well.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tilth import _core
from tilth.algebra.block_matrix import BlockMatrix
from tilth.algebra.border import Border
from tilth.algebra.field import DISPLACEMENT
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Flags, Floats
from tilth.boundaries.contact.approach import FIRST_OVERLAP, distance_to_soil
from tilth.boundaries.contact.between_bodies import BodyContact
from tilth.boundaries.contact.evaluation import Evaluated, Evaluation, Part
from tilth.boundaries.contact.outcome import contact_outcome
from tilth.boundaries.contact.patches import Patches, select_by_gaps
from tilth.boundaries.contact.rigid_body import WEAK_SPRING, RigidBody
from tilth.errors import StepFailed
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pattern import Elements
from tilth.terms.outcome import Outcome
from tilth.terms.pore_water import PORE_PRESSURE
from tilth.terms.protocol import Changes, GlobalUnknowns, Role
from tilth.terms.space import ElementBlocks

LARGEST_MEAN_GAP = 1e-4
"""Greatest mean gap of a multiplier in contact at the end of a step, in cells."""

LEAST_PATCH = 0.05
"""Least area of a patch, in faces of a cell, whose mean gap counts: where soil covers a surface's
edge only just, the patches on both sides can be more than the nodes there satisfy."""

OVERLAP = 2e-3
"""Depth of soil in the surface, in cells, from which a point becomes active within a step; where
the patch of its multiplier is in contact, gap up to which it does."""

LARGEST_HOLE = 0.05
"""Gap in cells up to which a point in the middle of the area in contact is in contact as well: the
soil's surface is not known more exactly there."""

MAXIMUM_REVISIONS = 20
"""Number of times that a step's contact is determined anew before the step counts as failed."""

PATIENCE = 10
"""Linearisations without equilibrium after which the shear strength is that of the pressure at the
start of the step.

Strength that increases with the pressure couples both: there may be no equilibrium, and Newton's
iteration can alternate between open, sliding and sticking multipliers. With a given strength the
balance is that of a minimum (of an elastic soil's energy) and has a solution.
"""

MAXIMUM_RENEWALS = 10
"""Number of times that a given shear strength is determined anew: before an impact, the pressure at
the start of the step is none."""

MAXIMUM_REVISIONS_FIXED = 60
"""As `MAXIMUM_REVISIONS`, where single patches change."""


class AssembledContact(GlobalUnknowns):
    """`ContactForces` (`terms.py`) in the matrix's pattern.

    Where changes are careful, the shear strength is that of the pressure at the start of the step
    from the first iteration on (`PATIENCE`), and points that join a patch in contact do not open
    it by their gap. Where they are single, patches open and close one at a time as well: within
    Newton's iteration they may do so in turn for ever. They also leave to the next step those gaps
    that a smaller step would not make smaller.
    """

    def __init__(
        self,
        name: str,
        patches: Sequence[Patches],
        elements: Sequence[Elements],
        body: RigidBody | None,
        after: float,
        force: float,
        active: ActiveGrid,
        normal_before: float | None,
        with_water: Sequence[ElementBlocks | None],
    ) -> None:
        self.name = name
        self.label = f"contact with {name!r}"
        self.body = body
        self._patches, self._elements = patches, elements
        self._after, self._active, self._normal_before = after, active, normal_before
        self._with_water = with_water  # places of the derivatives by the pore pressure
        self._water: Floats | None = None  # excess pore pressure of the nodes, (nodes, 1)
        between = any(isinstance(patch.part, BodyContact) for patch in patches)
        self.role = Role.BETWEEN_BODIES if between else Role.CONTACT
        self.scale = np.zeros(0) if body is None else body.scale
        self._cell = float(active.grid.cell_size.min())
        self._weak = np.zeros_like(self.scale)
        if body is not None and body.step is None:
            self._weak = WEAK_SPRING * force * body.weak_share * self.scale**2
        self._is_loaded = body is not None and body.step is None and body.is_loaded(after)
        self._revisions = self._linearisations = 0
        self._changes = Changes.USUAL
        self._may_hold = self._is_guessed = False
        self._at = Evaluation([], np.zeros_like(self.scale))  # at the last call of `forces`

    @property
    def _is_held(self) -> bool:
        """Whether only contact holds the body, against a force now or at the step's start."""
        if self.body is None or self.body.step is not None or len(self.scale) == 0:
            return False
        return self._is_loaded or any(patch.before.any() for patch in self._patches)

    def _increments(self, unknowns: Floats) -> Floats:
        assert self.body is not None
        return self.body.increments(unknowns)

    def _moved(self, patch: Patches, unknowns: Floats) -> Floats:
        """Returns the displacements of a surface's points in the step [length], shape (n, dim)."""
        pose = patch.part.pose
        if self.body is None:
            return pose.increment
        return self.body.displacements(self._increments(unknowns), pose.position)

    def _evaluate(self, displacement: Floats, unknowns: Floats) -> Evaluation:
        found = []
        for patch in self._patches:
            moved = self._moved(patch, unknowns)
            slip = patch.slips(displacement, moved)
            pore_pressure = np.zeros(patch.count)
            if self._water is not None:
                pore_pressure = patch.pore_pressure(self._water)
            respond = patch.respond_at_guess if self._is_guessed else patch.respond
            found.append(Evaluated(slip, pore_pressure, respond(slip, pore_pressure), moved))
        evaluation = Evaluation(found, unknowns.copy())
        return evaluation.holding(self._patches) if self._may_hold else evaluation

    def begin(self, x: Unknowns) -> None:
        """As `AssembledTerm.begin`.

        From here on contact may hold a free body, points of one that moves with inertia are active
        by their gaps, and what opens and closes only between equilibria is closed by its law.
        """
        self._may_hold = self._is_held
        if self._moves_with_inertia:
            gaps = [s.gaps(x.u, self._moved(s, x.globals)) for s in self._patches]
            select_by_gaps(self._patches, gaps)
        if self._is_fixed:
            for patch in self._patches:
                patch.fix(patch.slips(x.u, self._moved(patch, x.globals)))

    def begin_at_guess(self) -> None:
        """As `GlobalUnknowns.begin_at_guess`: at first what was pressed stays in contact.

        A guess is in balance with nothing yet: a mean gap far below a cell would open a patch by
        its stiff law, and a body without contact would turn, or the system be singular.
        """
        self._is_guessed = True

    def first_unknowns(self) -> Floats:
        """As `GlobalUnknowns.first_unknowns`: a free body without contact moves to the soil.

        Along the force on it, until it would overlap the nearest soil a little.
        """
        if self.body is not None and self.body.step is not None:
            return self.body.first_unknowns
        direction = None if self.body is None else self.body.falls_along(self._after)
        if self.body is not None and direction is not None:
            nearest = self._distance(direction, lambda x: float(x.max(initial=-np.inf)))
            if nearest is not None:
                return self.body.moved_by((nearest + FIRST_OVERLAP * self._cell) * direction)
        return np.zeros_like(self.scale)

    def _way_down(self) -> Floats:
        """Returns the way of a loaded free body to the soil [length], (dim,); 0 if it is there."""
        direction = None if self.body is None else self.body.falls_along(self._after)
        if direction is not None:
            nearest = self._distance(direction, lambda x: float(x.min(initial=np.inf)))
            if nearest is not None and nearest > FIRST_OVERLAP * self._cell:
                return nearest * direction
        return np.zeros(self._active.grid.dim)

    def come_down(self) -> bool:
        """As `GlobalUnknowns.come_down`."""
        if self.body is None:
            return False
        way = self._way_down()
        self.body.come_down(way)
        return bool(way.any())

    def start(self, unknowns: Floats, size: float) -> None:
        """As `GlobalUnknowns.start`."""
        if self.body is not None:
            self.body.start(unknowns, size)

    def _distance(self, direction: Floats, of_patch: Callable[[Floats], float]) -> float | None:
        zero = np.zeros_like(self.scale)
        moved = [self._moved(patch, zero) for patch in self._patches]
        still = np.zeros((self._active.nodes, self._active.grid.dim))
        return distance_to_soil(self._patches, moved, still, direction, of_patch)

    def evaluate(self, x: Unknowns) -> Unknowns:
        """As `AssembledTerm.evaluate`."""
        self._water = x.of.get(PORE_PRESSURE)
        return super().evaluate(x)

    def forces(self, displacement: Floats, unknowns: Floats) -> tuple[Floats, Floats]:
        """As `GlobalUnknowns.forces`."""
        self._at = self._evaluate(displacement, unknowns)
        nodal = self._nodal_force([each.response.traction for each in self._at.surfaces])
        if self.body is None:
            return nodal, np.zeros(0)
        own = self._weak * unknowns - self.body.applied(self._increments(unknowns), self._after)
        for patch, _, each in self._each():
            lever = self._levers(patch, unknowns)
            own -= np.einsum("k,jka,ka->j", patch.area, lever, each.response.traction)
        return nodal, own

    def _nodal_force(self, tractions: Sequence[Floats]) -> Floats:
        """Returns the internal force of mean tractions [stress], (m, dim) for each surface."""
        nodal = np.zeros((self._active.nodes, self._active.grid.dim))
        for patch, elements, each in zip(self._patches, self._elements, tractions, strict=True):
            _core.add_element_forces(elements, patch.entry_force(each), nodal)
        return nodal

    @property
    def _moves_with_inertia(self) -> bool:
        return self.body is not None and self.body.moves_with_inertia

    def _each(self) -> list[Part]:
        return list(zip(self._patches, self._elements, self._at.surfaces, strict=True))

    def _levers(self, patch: Patches, unknowns: Floats) -> Floats:
        """Returns G, the derivatives of the mean motion by the free components, (m, k, dim)."""
        assert self.body is not None
        position = patch.part.pose.position
        derivatives = self.body.displacement_derivatives(self._increments(unknowns), position)
        shape = (0, patch.count, position.shape[1])
        return (
            np.stack([patch.mean(each) for each in derivatives])
            if len(derivatives)
            else (np.zeros(shape))
        )

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        """As `AssembledTerm.add_stiffness`."""
        for patch, elements, each in self._each():
            for column, row in zip(patch.columns(each.response), patch.row, strict=True):
                _core.add_outer_blocks(elements, column, np.ascontiguousarray(row), blocks)

    def assemble(self, x: Unknowns, matrix: BlockMatrix) -> None:
        """As `AssembledTerm.assemble`."""
        super().assemble(x, matrix)
        for (patch, _, each), blocks in zip(self._each(), self._with_water, strict=True):
            if blocks is not None:
                blocks.add(matrix, patch.by_pore_pressure(each.response))

    def linearised(self) -> None:
        """As `AssembledTerm.linearised`: sliding may not turn round before the next one."""
        self._linearisations += 1
        self._is_guessed = False
        for patch, _, each in self._each():
            patch.slip = each.response.slip
            patch.given |= self._linearisations >= PATIENCE

    def border(self, displacement: Floats, unknowns: Floats) -> Border:
        """As `GlobalUnknowns.border`."""
        count = len(self.scale)
        columns, rows = (np.zeros((count, *displacement.shape)) for _ in range(2))
        corner, of_water = np.diag(self._weak), np.zeros((count, len(displacement), 1))
        if self.body is None or count == 0:
            return Border(columns, rows, corner, self.scale)
        increments = self._increments(unknowns)
        corner = corner + self.body.load_stiffness(increments, self._after)
        for patch, elements, each in self._each():
            lever = self._levers(patch, unknowns)
            derivative = each.response.derivative
            right = np.einsum("kab,jkb->jka", derivative, lever)
            left = np.einsum("jka,kab->jkb", lever, derivative)
            for j in range(count):
                _core.add_element_forces(elements, -patch.entry_force(right[j]), columns[j])
                _core.add_element_forces(elements, -patch.entry_force(left[j]), rows[j])
            if self._water is not None and patch.has_friction:
                by_water = np.einsum("jka,ka->jk", lever, each.response.by_pore_pressure)
                of_entry = patch.value * by_water[:, patch.entry_multiplier]
                for own, added in zip(of_water, of_entry, strict=True):
                    own[:, 0] -= np.bincount(patch.node, added, len(own))
            corner += np.einsum("k,ika,jka->ij", patch.area, lever, right)
            force = patch.weight[:, None] * patch.distribute(each.response.traction)
            corner += self.body.geometric_stiffness(increments, patch.part.pose.position, force)
        others = {} if self._water is None else {PORE_PRESSURE: of_water}
        return Border(columns, rows, corner, self.scale, others)

    def constant_force(self) -> Floats:
        """As `AssembledTerm.constant_force`: at zero displacement."""
        zero = np.zeros((self._active.nodes, self._active.grid.dim))
        still = self._evaluate(zero, np.zeros_like(self.scale))
        return self._nodal_force([each.response.traction for each in still.surfaces])

    def magnitude(self, x: Unknowns) -> dict[str, Floats]:
        """As `AssembledTerm.magnitude`."""
        total = np.zeros_like(x.u)
        size = np.abs(x.u)
        for patch, elements, each in self._each():
            rows = np.abs(patch.row)
            along = np.einsum("aei,ei->ea", rows, size[patch.node])
            slip = np.add.reduceat(along, patch.node_start[:-1], axis=0)
            slip = slip / np.where(patch.area > 0.0, patch.area, 1.0)[:, None]
            slip = slip + np.abs(patch.mean(each.moved))
            stiffness = np.abs(each.response.derivative).max(axis=(1, 2))
            force = np.abs(patch.before) + stiffness[:, None] * slip
            spread = np.einsum("aei,ea->ei", rows, force[patch.entry_multiplier])
            _core.add_element_forces(elements, spread, total)
        return {DISPLACEMENT: total}

    def joined_nodes(self) -> Flags:
        """As `AssembledTerm.joined_nodes`."""
        joined = np.zeros(self._active.nodes, dtype=bool)
        for patch in self._patches:
            joined[patch.node] = True
        return joined

    def adapt(self, x: Unknowns) -> bool:
        """As `AssembledTerm.adapt`: points that soil has come to are active."""
        changed = False
        for patch, _, each in self._each():
            held = (each.response.closed & (patch.area > 0.0))[patch.part.multiplier]
            gaps = patch.gaps(x.u, each.moved)
            touches = gaps < np.where(held, OVERLAP, -OVERLAP) * self._cell
            new = touches & ~patch.active
            holes = ~touches & ~patch.active & held & (gaps < LARGEST_HOLE * self._cell)
            if self._moves_with_inertia:  # its gaps are not less exact there
                holes[:] = False
            among = patch.part.at_hole(holes, held & (patch.active | touches))
            if new.any() or len(among):
                if self._is_cautious:  # a gap in the mean would open the patch
                    among = np.concatenate([among, np.flatnonzero(new & (gaps > 0.0))])
                patch.close(among, gaps[among])
                new[among] = True
                patch.share[new] = 1.0
                patch.activate(patch.active | new)
                changed = True
        return changed

    def restart(self, changes: Changes) -> None:
        """As `AssembledTerm.restart`."""
        self._revisions = self._linearisations = 0
        self._changes = changes
        self._may_hold = self._is_guessed = False
        for patch in self._patches:
            patch.restart(cautious=self._is_cautious, deferring=self._is_fixed)

    @property
    def _is_fixed(self) -> bool:
        """Whether contact opens and closes only between equilibria."""
        return self._changes is Changes.SINGLE

    def _change_fixed(self) -> bool:
        """Opens or closes what is most against the law at an equilibrium; whether anything is."""
        violations = [patch.violation(each.slip) for patch, _, each in self._each()]
        largest = max((float(each.max(initial=0.0)) for each in violations), default=0.0)
        if largest == 0.0:
            return False
        for patch, violation in zip(self._patches, violations, strict=True):
            assert patch.fixed is not None
            patch.fixed = patch.fixed ^ (violation == largest)
        return True

    @property
    def _is_cautious(self) -> bool:
        return self._changes is not Changes.USUAL

    def revise(self, x: Unknowns) -> bool:
        """As `AssembledTerm.revise`: points that soil has come to are active; gaps are closed.

        What has turned round and sticks beyond its strength slides.
        """
        changed = self.adapt(x) or self._is_guessed
        self._is_guessed = False
        if self._at.holds_one and not changed:
            assert self.body is not None
            if self.body.needs_contact and self._is_loaded:
                raise StepFailed(f"the rigid body {self.name!r} comes off the soil that holds it")
            self._may_hold = False
            changed = True
        for patch, _, each in self._each():
            wide = self._too_wide(patch, each)
            if wide.any():
                patch.augment(each.slip, wide)
                changed = True
            turned = each.response.turned & (patch.area > 0.0)
            if turned.any():
                patch.slip = np.where(turned[:, None], 0.0, patch.slip)
                changed = True
        if self._moves_with_inertia and self._revisions < MAXIMUM_RENEWALS:
            for patch, _, each in self._each():
                changed |= patch.renew_strength(each.slip, each.pore_pressure)
        if self._is_fixed and self._change_fixed():
            changed = True
        if changed:
            self._revisions += 1
            self._linearisations = 0
            most = MAXIMUM_REVISIONS_FIXED if self._is_fixed else MAXIMUM_REVISIONS
            if self._revisions > most:
                raise StepFailed(f"the contact with {self.name!r} does not settle")
        if self.body is not None:
            self.body.set_trial(self._at.unknowns)  # checks of the step ask where it is
        return changed

    def _too_wide(self, patch: Patches, each: Evaluated) -> Flags:
        """Returns which multipliers in contact have a mean gap beyond the tolerance, (k,)."""
        held = each.response.closed & ~self._is_small(patch)
        return np.asarray(held & (np.abs(each.slip[:, 0]) > LARGEST_MEAN_GAP * self._cell))

    def _is_small(self, patch: Patches) -> Flags:
        """Returns which multipliers have a patch whose mean gap does not count, (k,)."""
        part = patch.part
        extent = np.bincount(part.multiplier, np.where(patch.active, part.area, 0.0), patch.count)
        face = self._cell ** (self._active.grid.dim - 1)
        return np.asarray(extent <= LEAST_PATCH * face)

    def commit(self, x: Unknowns, checked: None) -> None:
        """As `AssembledTerm.commit`."""
        dim = x.u.shape[1]
        force, moment = np.zeros(dim), np.zeros(3)
        for patch, _, each in self._each():
            multiplier = patch.part.multiplier
            closed = each.response.closed[multiplier] & patch.active
            traction = patch.distribute(each.response.traction)
            # what is tolerated in a small patch must not act on its traction in the next step
            tolerated = np.where(self._is_small(patch), each.slip[:, 0], 0.0)
            gap = patch.gaps(x.u, each.moved) - np.where(closed, tolerated[multiplier], 0.0)
            pore_pressure = each.pore_pressure[multiplier]
            patch.part.store(traction, closed, gap + patch.left, pore_pressure)
        if self.body is not None:
            force, moment = self.body_force(x.u)
            self.body.commit(self._at.unknowns, force, moment[2:] if dim == 2 else moment)

    def body_force(self, displacement: Floats) -> tuple[Floats, Floats]:
        """Returns the soil's force (dim,) and moment (3,) about its centre on the rigid body."""
        assert self.body is not None
        dim = displacement.shape[1]
        force, moment = np.zeros(dim), np.zeros(3)
        translation = self._increments(self._at.unknowns)[:dim]
        for patch, _, each in self._each():
            part = patch.weight[:, None] * patch.distribute(each.response.traction)
            arm = patch.part.pose.position - self.body.centre + each.moved - translation
            padding = ((0, 0), (0, 3 - dim))
            force += part.sum(axis=0)
            moment += np.cross(np.pad(arm, padding), np.pad(part, padding)).sum(axis=0)
        return force, moment

    def carried_force(self) -> Floats:
        """As `AssembledTerm.carried_force`."""
        return self._nodal_force([patch.before for patch in self._patches])

    def outcome(self, x: Unknowns) -> Outcome:
        """As `AssembledTerm.outcome`."""
        return contact_outcome(
            self.name, self._each(), self._active, x.u, self._normal_before,
            self.role is Role.BETWEEN_BODIES,
        )  # fmt: skip
