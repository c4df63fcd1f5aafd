# SPDX-License-Identifier: BSD-3-Clause
"""Boundaries of dynamic analyses: bases that move, and sides that absorb waves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from tilth.analysis.owners import Stateful
from tilth.analysis.step_result import PreparedStep
from tilth.arrays import Flags, Floats
from tilth.boundaries import Boundary, ImplicitConstraints
from tilth.boundaries.absorbing import Absorbing, make_absorbing
from tilth.boundaries.base_motion import BaseMotion
from tilth.boundaries.implicit.constraint import ImplicitConstraint
from tilth.boundaries.surfaces.boundary import Implicit
from tilth.boundaries.surfaces.near_soil import NearSoil, find_near_soil
from tilth.comm import together
from tilth.model import Model
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.mpm.soil import Soil
from tilth.terms.balance import Balance
from tilth.terms.inertia import Inertia
from tilth.terms.protocol import Role, Term, union

LONGEST_STEP = 1.001
"""Size of a step over the interval of a record, above which is warned."""


class WaveBoundaries:
    """The moving bases and the absorbing boundaries of a simulation.

    Args:
        model: of the stage.
        boundaries: those that act by elimination.
        position: of the soil's points [length], shape (n, dim).

    Attributes:
        bases: rigid bases with a given acceleration.
        absorbing: absorbing boundaries.
    """

    def __init__(self, model: Model, boundaries: Sequence[Boundary], position: Floats) -> None:
        self.bases = [each for each in boundaries if isinstance(each, BaseMotion)]
        self.absorbing: list[Absorbing] = make_absorbing(model, position)
        self._kind = model.analysis.kind

    def __bool__(self) -> bool:
        return bool(self.bases or self.absorbing)

    def surfaces(self) -> list[Implicit]:
        """Returns the surfaces of the absorbing boundaries, which hold the soil without inertia."""
        return [each.surface for each in self.absorbing]

    def owners(self) -> dict[str, Stateful]:
        """Returns the objects with variables that persist from step to step."""
        owners: dict[str, Stateful] = {f"base {i}": each for i, each in enumerate(self.bases)}
        for i, each in enumerate(self.absorbing):
            owners |= {f"absorbing {i}": each, f"absorbing surface {i}": each.surface}
        return owners

    def go_on_from(self, last: WaveBoundaries) -> None:
        """Takes over the state of the same boundaries in the last stage, which had inertia."""
        for now, before in ((self.bases, last.bases), (self.absorbing, last.absorbing)):
            known = {each.name: each for each in before}
            for each in now:
                if each.name in known:
                    each.restore(known[each.name].state())

    def near(self, points: MaterialPoints, active: ActiveGrid, time: float) -> list[NearSoil]:
        """Returns the points of each absorbing boundary near soil at `time`."""
        return find_near_soil(self.surfaces(), points, active, time)

    def _parts(
        self, soil: Soil, before: float, after: float, near: Sequence[NearSoil] | None = None
    ) -> list[tuple[Absorbing, ImplicitConstraint]]:
        """Returns the absorbing boundaries that touch soil with their points there.

        near: what `near` returns at the time `before`; found if not given.
        """
        parts = ImplicitConstraints.near_soil(
            self.surfaces(), soil.points, soil.active, self._kind, before, after, near
        )
        by_name = {each.name: each for each in self.absorbing}
        return [(by_name[part.boundary.name], part) for part in parts]

    def terms(self, step: PreparedStep, soil: Soil, mass: Floats, inertia: Inertia) -> list[Term]:
        """Returns the dashpots in a step and the forces that hold the soil at rest.

        mass: of the material points [mass], shape (n,).
        """
        found: list[Term] = []
        for each, part in self._parts(soil, step.before, step.after, step.absorbing):
            found += each.terms(part, soil, mass, inertia, step.before, step.after)
        return found

    def nodes(self, soil: Soil, time: float) -> Flags:
        """Returns the nodes on which absorbing boundaries act, shape (nodes,)."""
        found = np.zeros(soil.active.nodes, dtype=bool)
        for each, part in self._parts(soil, time, time):
            found |= each.nodes(part, soil.active)
        return found

    def take_over(self, step: PreparedStep, soil: Soil, balance: Balance) -> tuple[bool, float]:
        """Lets new absorbing boundaries keep the forces that hold the soil at rest.

        balance: in which they do not act yet, at the start of inertia.

        Returns:
            Whether there are new ones, and the residual elsewhere relative to the forces [-].
        """
        new = [each for each in self.absorbing if not each.begun]
        if not new:
            return False, 0.0
        active = balance.active
        still = balance.at(np.zeros(step.active.position.shape))
        balance.begin(still)
        with together(balance.comm):
            found = balance.evaluate(still)
        static = found.u - found.sum_of(Role.INERTIA)
        static = np.where(step.conditions.constrained, 0.0, static)
        static = active.updated(static)
        parts = self._parts(soil, step.before, step.before, step.absorbing)
        nodes = {each.name: each.nodes(part, soil.active) for each, part in parts}
        taken = union(len(static), (nodes[each.name] for each, _ in parts if each.begun))
        untaken = np.where(taken[:, None], 0.0, static)
        divided = _divided([of for of in parts if not of[0].begun], untaken, soil.active)
        for each in new:
            each.keep(active, divided.get(each.name, np.zeros_like(static)))
        free = ~union(len(static), nodes.values())
        left = active.norm(np.where(free[:, None], static, 0.0))
        size = max(active.norm(found.sum_of(Role.SOIL)), active.norm(found.load))
        return True, left / size if size > 0.0 else 0.0

    def hold(self, step: PreparedStep, soil: Soil, balance: Balance, residual: Floats) -> None:
        """Lets absorbing boundaries that act already keep what is out of balance on their nodes.

        residual: internal minus external force at the start of a stage [force], (nodes, dim).
        """
        parts = self._parts(soil, step.before, step.before, step.absorbing)
        begun = [of for of in parts if of[0].begun]
        divided = _divided(begun, balance.active.updated(residual), soil.active)
        for each, _ in begun:
            each.keep(balance.active, each.kept(balance.active) + divided[each.name])

    def warnings(self, model: Model, soil: Soil) -> Iterator[tuple[str, str]]:
        """Yields warnings of records and of places without soil: what each is about, its text."""
        keys, size = model.boundary_keys(), model.schedule.first_step
        touching = [each.name for each, _ in self._parts(soil, 0.0, 0.0)]
        for name in (each.name for each in self.absorbing if each.name not in touching):
            yield (
                f"no soil at {name}",
                f"{keys[name]}: the absorbing boundary {name!r} touches no soil; put it at the "
                "outer face of the soil",
            )
        if (stage := model.stage.declared) is not None and not stage.inertia:
            return
        records = [(each.name, each.record) for each in self.bases]
        records += [(each.name, each.record) for each in self.absorbing if each.record is not None]
        for name, record in records:
            key = f"{keys[name]}.acceleration"
            if text := record.drift():
                yield f"drift of {name}", f"{key}: {text}"
            interval = float(np.median(np.diff(record.time)))
            if size > LONGEST_STEP * interval:
                yield (
                    f"steps over {name}",
                    f"{key}: the steps of {size:g} are longer than the record's of {interval:g}: "
                    "they miss its peaks; shorten them, or filter and resample the record",
                )

    def peak_times(self, end: float) -> list[float]:
        """Returns when each base has its greatest acceleration, within the stage that ends then."""
        peaks = (
            float(each.record.time[np.abs(each.record.acceleration).max(axis=1).argmax()])
            for each in self.bases
        )
        return [time for time in peaks if 0.0 < time <= end]

    def commit(self, before: float, after: float) -> None:
        """Ends a converged step."""
        for each in self.bases:
            each.commit(before, after)


def _divided(
    parts: Sequence[tuple[Absorbing, ImplicitConstraint]], force: Floats, active: ActiveGrid
) -> dict[str, Floats]:
    """Returns what each boundary keeps of forces (nodes, dim) on the nodes on which it acts."""
    shares = {
        each.name: np.where(each.nodes(part, active)[:, None], each.shares(part, active), 0.0)
        for each, part in parts
    }
    total = sum(shares.values(), np.zeros_like(force))
    total = np.where(total > 0.0, total, 1.0)
    return {name: force * share / total for name, share in shares.items()}
