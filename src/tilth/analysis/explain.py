# SPDX-License-Identifier: BSD-3-Clause
"""Watches one load step of a run and tells where its residual comes from.

The forces of the terms are those that the balance sums up in any case, so that the step is solved
with the same bits as without.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tilth.algebra.field import DISPLACEMENT
from tilth.analysis.asked_step import AskedStep
from tilth.analysis.explained import (
    HELD,
    INTERRUPTED,
    ExplainedStep,
    Iteration,
    Largest,
    Solve,
    SurfaceCounts,
    TermForces,
    TriedStep,
)
from tilth.analysis.motions import force_unit
from tilth.analysis.observer import Observer, Search
from tilth.analysis.residual import Guess, Iterate, Newton, nearest_point
from tilth.arrays import Flags, Floats
from tilth.errors import BadInput, TilthError
from tilth.model import Model
from tilth.mpm.soil import Soil
from tilth.plot.residual_forces import OutOfBalance
from tilth.terms.balance import Balance
from tilth.terms.protocol import AssembledTerm, Changes, Role


@dataclass
class _Watched:
    """An attempt that is watched, and what there was after the last iteration to compare with."""

    soil: Soil
    balance: Balance
    position: Floats
    half_length: Floats
    forces: list[Floats] | None = None
    yielding: Flags | None = None
    contact: list[tuple[Flags, Flags]] | None = None


class Explanation(Observer):
    """Explains one step of a run.

    Args:
        asked: which step.
        before: numbers of steps before stages that have begun, by their names, of a run that is
            gone on with; none of a new one.

    Attributes:
        step: what is known of it; None before its first attempt.
        complete: whether the step is accepted.
        last: number of the last step that was tried; 0 before the first one.
    """

    def __init__(self, asked: AskedStep, before: dict[str, int] | None = None) -> None:
        self.asked = asked
        self.step: ExplainedStep | None = None
        self.complete = False
        self.last = 0
        self._before = {} if before is None else dict(before)
        self._attempt: TriedStep | None = None
        self._watched: _Watched | None = None

    def require_reached(
        self, folder: Path, step: int, stage: str, stage_done: bool, done: bool
    ) -> None:
        """Checks, at the end of a run, that it had the step.

        Args:
            folder: of the run.
            step: number of its last one.
            stage: name of its last stage; empty without stages.
            stage_done: whether this stage is complete.
            done: whether the run is complete, and did not stop before its end as it was asked to.

        Raises:
            BadInput: it had not; its results up to its last step are on disk.
        """
        if self.step is not None:
            return
        is_over = self.asked.stage in self._before and (stage_done or self.asked.stage != stage)
        if done or is_over:
            what = f"the run ended with step {step} and had no such step"
            if not done:
                what = f"the run is beyond this stage, after step {step}, and had no such step"
            raise BadInput(
                f"{what}; its results in {folder} are complete",
                "name a step that log.txt has, in a new run: tilth run CASE.toml "
                "--out ANOTHER_DIR --explain STEP",
                key="explain",
                value=f"{self.asked}",
            )
        raise BadInput(
            f"the run stopped after step {step}, before this step; its results up to there are "
            f"in {folder}",
            f"go on with it: tilth resume {folder} --explain {shlex.quote(f'{self.asked}')}",
            key="explain",
            value=f"{self.asked}",
        )

    def _is_asked(self, stage: str, number: int) -> bool:
        if not self.asked.stage:
            return number == self.asked.number
        return (stage, number - self._before[stage]) == (self.asked.stage, self.asked.number)

    @contextmanager
    def attempt(self, model: Model, number: int, before: float, after: float) -> Iterator[None]:
        """As `Observer.attempt`."""
        self.last = number
        self._before.setdefault(model.stage.name, number - 1)
        if not self._is_asked(model.stage.name, number):
            yield
            return
        if self.step is None:
            units = model.units.length, force_unit(model)
            self.step = ExplainedStep(number, model.stage.name, *units)
        start = model.stage.start
        self._attempt = TriedStep(start + before, start + after)
        self.step.attempts.append(self._attempt)
        try:
            yield
            self.complete = True
        except BaseException as error:
            self._attempt.failure = _reason(error)
            raise
        finally:
            self._attempt.drop_all_but_telling()
            self._attempt = self._watched = None

    def prepared(self, soil: Soil, balance: Balance) -> None:
        """As `Observer.prepared`."""
        if self._attempt is not None:
            balance.keep_forces()
            place, half = soil.points.position.copy(), soil.points.half_length.copy()
            self._watched = _Watched(soil, balance, place, half)

    @contextmanager
    def solving(self, newton: Newton, guess: Guess | None, search: Search) -> Iterator[None]:
        """As `Observer.solving`."""
        if self._attempt is None or self._watched is None:
            yield
            return
        watched = self._watched
        watched.forces = watched.yielding = watched.contact = None
        solve = Solve(_method(newton, guess is not None, search), search)
        self._attempt.solves.append(solve)
        try:
            yield
        except BaseException as error:
            solve.failure = _reason(error)
            raise

    def iteration(self, number: int, state: Iterate, moving: bool) -> None:
        """As `Observer.iteration`."""
        if self._attempt is None or self._watched is None:
            return
        watched, solve = self._watched, self._attempt.solves[-1]
        active = watched.balance.active
        held = watched.balance.fields[DISPLACEMENT].constrained
        free = np.where(held, 0.0, -state.residual.u)
        kept = watched.balance.kept
        assert kept is not None
        reaction = np.where(held, state.residual.u, 0.0)
        forces = [*(-each for each in kept), reaction]
        labels = [*(label_of(term) for term in watched.balance.terms), HELD]
        size = np.linalg.norm(free, axis=1)
        node = int(size.argmax())
        yielding = watched.soil.plastic_increment() > 0.0
        contact, counts = self._contact(watched, state)
        was = watched.yielding
        iteration = Iteration(
            number,
            state.relative,
            float(np.linalg.norm(free)),
            moving,
            [
                _of_term(label, force, free, node)
                for label, force in zip(labels, forces, strict=True)
            ],
            _of_bodies(watched.balance, state),
            _largest(watched, labels, forces, free, node),
            counts,
            int(yielding.sum()),
            None if was is None else int((yielding & ~was).sum()),
            None if was is None else int((was & ~yielding).sum()),
        )
        place, half = watched.position, watched.half_length
        solve.add(iteration, OutOfBalance(place, half, yielding, active.position, free))
        watched.forces, watched.yielding, watched.contact = forces, yielding, contact

    @staticmethod
    def _contact(
        watched: _Watched, state: Iterate
    ) -> tuple[list[tuple[Flags, Flags]], list[SurfaceCounts]]:
        """Returns which points are in contact and slide, surface by surface, and their numbers."""
        balance = watched.balance
        terms = [*balance.of_role(Role.CONTACT), *balance.of_role(Role.BETWEEN_BODIES)]
        outcomes = [each.outcome(state.x) for each in terms]
        surfaces = [each.contact for each in outcomes if each is not None and each.contact]
        now, counts = [], []
        for number, surface in enumerate(surfaces):
            touches, slides = surface.state.in_contact, surface.state.sliding
            now.append((touches, slides))
            stays = touches & ~slides
            numbers = int((~touches).sum()), int(stays.sum()), int((touches & slides).sum())
            if watched.contact is None:
                counts.append(SurfaceCounts(surface.name, *numbers))
                continue
            touched, slid = watched.contact[number]
            both = touched & touches
            changes = (
                touched & ~touches,
                touches & ~touched,
                both & slides & ~slid,
                both & slid & ~slides,
            )
            counts.append(SurfaceCounts(surface.name, *numbers, *(int(c.sum()) for c in changes)))
        return now, counts


def label_of(term: AssembledTerm) -> str:
    """Returns what a term is called in tables."""
    return term.label or type(term).__name__


def _reason(error: BaseException) -> str:
    if isinstance(error, KeyboardInterrupt):
        return INTERRUPTED
    return error.message if isinstance(error, TilthError) else str(error) or type(error).__name__


def _method(newton: Newton, guessed: bool, search: Search) -> str:
    """Returns what an iteration of Newton's method is, in words."""
    parts = {
        Search.STEP: ["Newton's method", "from a guess" if guessed else ""],
        Search.CREEPING: ["soil creeps against a drag"],
        Search.REST: ["Newton's method", "from where the soil has crept"],
    }[search]
    parts.append("with a line search" if newton.line_search else "")
    careful = {Changes.CAREFUL: "contact with care", Changes.SINGLE: "contact point by point"}
    parts.append(careful.get(newton.changes, ""))
    return ", ".join(part for part in parts if part)


def _of_term(label: str, force: Floats, free: Floats, node: int) -> TermForces:
    square = float((free * free).sum())
    along = float((force * free).sum())
    share = along / square if square > 0.0 else np.nan
    norm = float(np.linalg.norm(force))
    return TermForces(label, norm, force.sum(axis=0), share, force[node].copy())


def _of_bodies(balance: Balance, state: Iterate) -> dict[str, float]:
    """Returns the residuals of the equations of terms with global unknowns [force], by label."""
    residuals = balance.of_bodies(state.residual.globals)
    return {
        label_of(term): float(np.linalg.norm(own / term.scale))
        for term, own in residuals
        if len(own)
    }


def _largest(
    watched: _Watched, labels: list[str], forces: list[Floats], free: Floats, node: int
) -> Largest:
    """Returns what is at the node with the largest residual."""
    active, points = watched.balance.active, watched.soil.points
    place = active.position[node]
    point = nearest_point(active, node)
    along = [float(force[node] @ free[node]) for force in forces]
    changed = ""
    if watched.forces is not None:
        ways = [
            float(np.linalg.norm(now[node] - before[node]))
            for now, before in zip(forces, watched.forces, strict=True)
        ]
        changed = labels[int(np.argmax(ways))]
    body = next(each.name for each in points.ranges if each.start <= point < each.stop)
    return Largest(
        place.copy(),
        free[node].copy(),
        int(points.point_id[point]),
        points.position[point].copy(),
        body,
        labels[int(np.argmax(along))],
        changed,
    )
