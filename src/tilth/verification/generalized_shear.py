# SPDX-License-Identifier: BSD-3-Clause
"""Large shear and large turns with free inner nodes: which domains keep a uniform stress balanced.

The outer nodes follow x = F(t) X. If the domains fill the soil without gaps and overlaps, a uniform
stress is in equilibrium at the inner nodes, and all of the soil follows.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth.boundaries.affine import Affine
from tilth.errors import AnalysisFailed
from tilth.model import HenckyElastic, Model, VonMises
from tilth.points import MaterialPoints
from tilth.simulation import Simulation, StepResult
from tilth.verification.cases import example, varied
from tilth.verification.closed_forms import (
    components,
    full_deformation_gradient,
    hencky_cauchy_stress,
)
from tilth.verification.comparison import Comparison, at_least, vanishing, within_factor
from tilth.verification.homogeneous import (
    final_deformation_gradient,
    stress_error,
    with_each_basis,
)
from tilth.verification.march import march
from tilth.verification.rate_form import linear_path, von_mises_response

Floats = npt.NDArray[np.float64]

PROBLEM = "generalized_shear"
CORNERS = ("cpdi1", "cpdi2")
EXACT = 1e-8
MOTIONS = {
    "case.toml": "500 % along the grid",
    "across.toml": "200 % across the grid",
    "turn.toml": "turn by 360 degrees, stretch 2",
}
STOP = {"across.toml": 1.4, "turn.toml": 100.0}
"""Shear [-] and turn [degrees] at which the other bases stop, within a factor of 1.6."""


@dataclass(frozen=True)
class Outcome:
    """How far a motion went, and how well.

    Attributes:
        reached: share of the motion at the last converged step [-]; 1 if it was finished.
        reason: what stopped it; "" if nothing did.
        time: of each converged step [-], shape (steps,).
        stress: root mean square over the points of the stress error's six components, over the
            largest exact component in the whole motion [-], shape (steps,).
        volume: sum of the domains' volumes over that of the points', less 1 [-], shape (steps,).
    """

    reached: float
    reason: str
    time: Floats
    stress: Floats
    volume: Floats


def comparisons(long: bool) -> Iterator[Comparison]:
    """CPDI does every motion exactly; of the others it says which stop, and where."""
    for file, motion in MOTIONS.items():
        model = example(PROBLEM, file)
        for basis in CORNERS:
            outcome = driven(varied(model, {"bodies.0.basis": basis}))
            for name, error in (("stress", outcome.stress), ("domain volumes", outcome.volume)):
                yield vanishing(
                    f"{name} error, {basis}, {motion}", abs(error).max(), EXACT, "closed form"
                )
            quantity = f"share done, {basis}, {motion}"
            yield at_least(quantity, outcome.reached, 1.0, 0.0, "whole motion")
    rules = ("left_stretch", "corners")  # of GIMP's the two that follow a turn
    yield from others_stop("turn.toml", 360.0, "degrees", None if long else rules)
    yield from small_turn(("left_stretch",))
    if long:
        yield from others_stop("across.toml", 2.0, "", None)
        yield from plastic()


def others_stop(
    file: str, end: float, unit: str, rules: tuple[str, ...] | None
) -> Iterator[Comparison]:
    """Says where bases whose domains do not tile end a motion; of all GIMP rules or the named."""
    for basis, variants in with_each_basis(example(PROBLEM, file)):
        for model in variants:
            rule = model.bodies[0].domain_update
            if basis in CORNERS or (rules is not None and rule not in rules):
                continue
            reached = end * driven(model).reached
            quantity = f"stops: {basis}{f', {rule}' if rule else ''}, {MOTIONS[file]}"
            yield within_factor(quantity, reached, STOP[file], 1.6, "measured before", unit)


def small_turn(rules: tuple[str, ...]) -> Iterator[Comparison]:
    """The turn at a stretch of 1.3: what stays of GIMP's errors after 360 degrees."""
    for rule in rules:
        error = driven(gentle(example(PROBLEM, "turn.toml"), rule)).stress.max()
        quantity = f"stress error, gimp, {rule}, turn by 360 degrees, stretch 1.3"
        yield vanishing(quantity, error, 0.06, "closed form")


def gentle(model: Model, rule: str) -> Model:
    """Returns the turn with a stretch of 1.3 and a GIMP rule."""
    return varied(
        model,
        {
            "bodies.0.basis": "gimp",
            "bodies.0.domain_update": rule,
            "boundaries.0.deformation_gradient": [[0.0, -1.3], [1.0 / 1.3, 0.0]],
        },
    )


def plastic() -> Iterator[Comparison]:
    """Shear to 500 % in plastic flow, across the grid: first order in steps, and no more error."""
    model = example(PROBLEM, "von_mises.toml")
    material = model.materials["soil"]
    assert isinstance(material, VonMises)
    path = linear_path(final_deformation_gradient(model))
    exact = von_mises_response(path, [1.0], material).cauchy_stress[0]
    for basis in CORNERS:
        points = march(varied(model, {"bodies.0.basis": basis})).points
        whole = {"bodies.0.basis": basis, "boundaries.0.nodes": "all"}
        moved = march(varied(model, whole)).points
        spread = abs(points.stress - moved.stress[0]).max() / abs(moved.stress[0]).max()
        quantity = f"stress against motion of all nodes, {basis}, 500 % across the grid, von Mises"
        yield vanishing(quantity, spread, 1e-6, "same steps")
        quantity = f"stress error, {basis}, 500 % across the grid, von Mises, 100 steps"
        yield vanishing(quantity, stress_error(points, exact), 0.05, "rate equations")


def driven(model: Model) -> Outcome:
    """Drives an elastic model until its motion is done or fails, and measures every step."""
    material, kind, end = model.materials["soil"], model.analysis.kind, model.schedule.end
    assert isinstance(material, HenckyElastic)
    motion = Affine(model.boundaries[0], model)  # type: ignore[arg-type]

    def exact(time: float) -> Floats:
        gradient = full_deformation_gradient(motion.deformation_gradient(time), kind)
        return components(hencky_cauchy_stress(gradient, material))

    size = max(abs(exact(time)).max() for time in np.linspace(0.0, end, 101))
    rows: list[tuple[float, float, float]] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        points = simulation.points
        error = np.sqrt(((points.stress - exact(time)) ** 2).sum(axis=1).mean()) / size
        volume = domain_volume(points).sum() / points.volume.sum() - 1.0
        rows.append((time, float(error), float(volume)))

    reason = ""
    try:
        march(model, after_step)
    except AnalysisFailed as failure:
        reason = failure.message
    time, stress, volume = np.array(rows).T
    return Outcome(float(time[-1] / end), reason, time, stress, volume)


def domain_volume(points: MaterialPoints) -> Floats:
    """Volume of the domains of one body's points in plane strain [length^2], shape (n,).

    That of a quadrilateral is half the cross product of its diagonals.
    """
    if not points.bodies[0].has_corners:
        return np.asarray(np.prod(2.0 * points.half_length, axis=1))
    rising = points.corner[:, 3] - points.corner[:, 0]
    falling = points.corner[:, 2] - points.corner[:, 1]
    return 0.5 * (rising[:, 0] * falling[:, 1] - rising[:, 1] * falling[:, 0])
