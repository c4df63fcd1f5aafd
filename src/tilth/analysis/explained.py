# SPDX-License-Identifier: BSD-3-Clause
"""What is known of the attempts at one load step: the residual of each iteration, term by term.

All forces act on the nodes of the soil, external minus internal: the opposite of what terms give.
What is out of balance pushes the soil in its own direction.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from tilth.analysis.observer import Search
from tilth.arrays import Floats
from tilth.plot.residual_forces import OutOfBalance

HELD = "held nodes"
"""Label of the reaction of what holds nodes on grid lines; with it all forces sum to what is out of
balance on the free degrees of freedom."""

INTERRUPTED = "interrupted"
"""Why an attempt that the user stops has no end."""

SMALL = 1e-6
"""What is out of balance, over the largest of the forces, up to which it is in equilibrium: shares
and places of it are then those of forces that cancel."""


@dataclass(frozen=True)
class TermForces:
    """The nodal forces of a term after an iteration.

    Attributes:
        label: of the term, or `HELD`.
        norm: Euclidean norm of all nodal forces [force].
        resultant: their sum [force], shape (dim,).
        share: of what is out of balance: the component of the term's forces along the residual
            over the residual [-]. The shares sum to 1; large forces that nearly cancel
            have large shares of both signs. NaN without a residual.
        at_largest: force on the node with the largest residual [force], shape (dim,).
    """

    label: str
    norm: float
    resultant: Floats
    share: float
    at_largest: Floats


@dataclass(frozen=True)
class Largest:
    """The node with the largest residual force, and what is there.

    Attributes:
        node: its position at the start of the step [length], shape (dim,).
        force: what is out of balance there [force], shape (dim,).
        point: permanent number of the nearest material point of the node's overlay.
        at: position of this point at the start of the step [length], shape (dim,).
        body: name of its body.
        term: label of the term whose force there is the largest along the residual.
        changed: label of the term whose force there changed most in the last iteration; empty in
            the first one.
    """

    node: Floats
    force: Floats
    point: int
    at: Floats
    body: str
    term: str
    changed: str


@dataclass(frozen=True)
class SurfaceCounts:
    """Points of a contact surface after an iteration, and what changed in it.

    Attributes:
        surface: name of the boundary, rigid body or contact pair.
        open, sticking, sliding: numbers of its points: the integration points of the surface.
        opened, closed, slid, stuck: how many opened, closed, began to slide and began to stick, of
            those in contact before and after; None in the first iteration.
    """

    surface: str
    open: int
    sticking: int
    sliding: int
    opened: int | None = None
    closed: int | None = None
    slid: int | None = None
    stuck: int | None = None


@dataclass(frozen=True)
class Iteration:
    """The state after a number of linear solves.

    Attributes:
        number: of linear solves. One that stands twice: at the equilibrium something was determined
            anew that is fixed meanwhile, such as which soil is in contact.
        relative: residual over the size of the forces [-], which Newton's tolerance bounds.
        norm: of the nodal residual on what is free [force].
        moving: whether prescribed degrees of freedom have yet to move.
        terms: forces of all terms, in the order of the balance, last those of `HELD`.
        bodies: residuals of the equations of free rigid bodies over their scale [force], by label.
        largest: where the residual is largest.
        contact: points of each contact surface.
        yielding: number of points that yield in the step.
        began, ceased: how many began to and do not any more; None in the first iteration.
    """

    number: int
    relative: float
    norm: float
    moving: bool
    terms: Sequence[TermForces]
    bodies: dict[str, float]
    largest: Largest
    contact: Sequence[SurfaceCounts]
    yielding: int
    began: int | None
    ceased: int | None

    @property
    def is_balanced(self) -> bool:
        """Whether no more is out of balance than `SMALL`: no term and no place stands out then."""
        return self.norm <= SMALL * max((each.norm for each in self.terms), default=0.0)


@dataclass
class Solve:
    """One iteration of Newton's method for the step.

    Attributes:
        method: what it is, in words.
        search: what it looks for.
        iterations: of it.
        failure: why there is no equilibrium; None if it was found.
    """

    method: str
    search: Search = Search.STEP
    iterations: list[Iteration] = field(default_factory=list)
    failure: str | None = None
    _last: OutOfBalance | None = None
    _closest: tuple[int, OutOfBalance] | None = None
    _begun: int = 0

    @property
    def creeps(self) -> bool:
        """Whether it belongs to the creep of the soil to its equilibrium."""
        return self.search is not Search.STEP

    def add(self, iteration: Iteration, residuals: OutOfBalance) -> None:
        """Takes note of an iteration and of where its residual is."""
        if self.iterations and iteration.number == self.iterations[-1].number:
            self._begun = len(self.iterations)  # at an equilibrium with what was fixed before
        index, best = len(self.iterations), math.nan
        if self._closest is not None and index - self._begun >= 2:
            best = self.iterations[self._closest[0]].relative
        self.iterations.append(iteration)
        self._last = residuals
        if math.isnan(best) or iteration.relative < best:
            self._closest = index, residuals

    @property
    def telling(self) -> tuple[Iteration, OutOfBalance] | None:
        """The iteration to look at, and where its residual is; None before the first.

        The last one if the equilibrium was found. Else the one that came closest to it after the
        first guess, and after something was determined anew at an equilibrium: from there the
        method went astray.
        """
        if self._last is None or self._closest is None:
            return None
        if self.failure is None:
            return self.iterations[-1], self._last
        index, residuals = self._closest
        return self.iterations[index], residuals

    def drop_residuals(self) -> None:
        """Forgets where the residual is, so that nothing is `telling`."""
        self._last = self._closest = None


@dataclass
class TriedStep:
    """An attempt at the step.

    Attributes:
        before, after: total times at its start and end.
        solves: Newton's iterations, one after the other.
        failure: why it is undone; None if it is the accepted one.
    """

    before: float
    after: float
    solves: list[Solve] = field(default_factory=list)
    failure: str | None = None

    @property
    def end(self) -> str:
        """How it ended, in a word."""
        if self.failure is None:
            return "accepted"
        return INTERRUPTED if self.failure == INTERRUPTED else "failed"

    @property
    def telling(self) -> Solve | None:
        """The iteration of Newton's method to look at; None before the first.

        The last one of an accepted attempt, and where its equilibrium was refused; else the last
        one that failed, if possible not of those of soil that creeps.
        """
        begun = [each for each in self.solves if each.iterations]
        failed = [each for each in begun if each.failure is not None]
        of_newton = [each for each in failed if not each.creeps]
        last = begun[-1] if begun else None
        if last is None or self.failure is None or not failed:
            return last
        if last.failure is None and not last.creeps:
            return last
        return (of_newton or failed)[-1]

    def drop_all_but_telling(self) -> None:
        """Forgets where the residual of all other iterations of Newton's method is."""
        telling = self.telling
        for each in self.solves:
            if each is not telling:
                each.drop_residuals()


@dataclass
class ExplainedStep:
    """All attempts at a load step.

    Attributes:
        number: of the step, through all stages.
        stage: name of its stage; empty without stages.
        attempts: at it, the accepted one last.
        length_unit, force_unit: labels, forces in plane strain per length.
    """

    number: int
    stage: str
    length_unit: str
    force_unit: str
    attempts: list[TriedStep] = field(default_factory=list)

    @property
    def name(self) -> str:
        """Its number, with that of its stage for messages."""
        return f"{self.number}, in the stage {self.stage!r}" if self.stage else f"{self.number}"

    @property
    def shown(self) -> tuple[int, Solve] | None:
        """Number of the attempt to draw, from 1, and its `telling` iteration of Newton's method.

        The last attempt that failed, or the accepted one if none did; None before the first.
        """
        told = [(number, each.telling, each) for number, each in enumerate(self.attempts, 1)]
        known = [(number, solve, each) for number, solve, each in told if solve is not None]
        failed = [every for every in known if every[2].failure is not None]
        if not known:
            return None
        number, solve, _ = (failed or known)[-1]
        return number, solve

    def to_dict(self) -> dict[str, Any]:
        """Returns all numbers as mappings and lists.

        Those that are not finite are None, and so are, of an iteration that `is_balanced`, the
        shares, the node with the largest residual and the forces there.
        """
        return {
            "step": self.number,
            "stage": self.stage,
            "units": {"length": self.length_unit, "force": self.force_unit},
            "attempts": [
                {
                    "attempt": number,
                    "start": attempt.before,
                    "end": attempt.after,
                    "accepted": attempt.failure is None,
                    "failure": attempt.failure,
                    "solves": [_solve(each) for each in attempt.solves],
                }
                for number, attempt in enumerate(self.attempts, 1)
            ],
        }


def _solve(solve: Solve) -> dict[str, Any]:
    iterations = [_iteration(each) for each in solve.iterations]
    return {"method": solve.method, "failure": solve.failure, "iterations": iterations}


def _iteration(own: Iteration) -> dict[str, Any]:
    largest, unclear = own.largest, own.is_balanced
    return {
        "iteration": own.number,
        "relative_residual": _finite(own.relative),
        "residual": _finite(own.norm),
        "prescribed_motion_to_come": own.moving,
        "terms": [
            {
                "term": each.label,
                "norm": _finite(each.norm),
                "resultant": _all_finite(each.resultant),
                "share": None if unclear else _finite(each.share),
                "at_largest": None if unclear else _all_finite(each.at_largest),
            }
            for each in own.terms
        ],
        "rigid_bodies": {label: _finite(norm) for label, norm in own.bodies.items()},
        "largest": None
        if unclear
        else {
            "node": _all_finite(largest.node),
            "force": _all_finite(largest.force),
            "point": largest.point,
            "point_position": _all_finite(largest.at),
            "body": largest.body,
            "most_from": largest.term,
            "changed_most": largest.changed,
        },
        "contact": [
            {
                "surface": each.surface,
                "open": each.open,
                "sticking": each.sticking,
                "sliding": each.sliding,
                "opened": each.opened,
                "closed": each.closed,
                "began_to_slide": each.slid,
                "began_to_stick": each.stuck,
            }
            for each in own.contact
        ],
        "yielding": own.yielding,
        "began_to_yield": own.began,
        "ceased_to_yield": own.ceased,
    }


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _all_finite(values: Floats) -> list[float | None]:
    return [_finite(value) for value in values.tolist()]
