# SPDX-License-Identifier: BSD-3-Clause
"""Essential conditions on splines against the same on circles and polylines."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.model import Model
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, at_least, vanishing

PROBLEM = "footing_on_spline"
RADIUS, CENTRE = 0.5, (0.0, 1.5)
"""Of the round footing [m]."""
CIRCLE = "the same on a circle"
POLYLINE = "the same on a polyline"
DIVISIONS: Mapping[float, tuple[int, ...]] = MappingProxyType(
    {0.1: (24, 48, 96), 0.05: (38, 95, 190)}
)
"""Cell size [m] -> numbers of points for which the spline has the facets of the circle."""
OTHER_FACETS = (20, 64, 128)
"""Numbers of points for which the facets differ from those of the circle."""


@dataclass(frozen=True)
class Outcome:
    """Results of a pressed footing: forces after each step, and displacements of the points.

    Attributes:
        force: on the footing [force per length], shape (steps, 2).
        displacement: displacements of the material points [length], shape (n, 2), by their numbers.
        depth: largest penetration of a material point into the footing [length].
    """

    force: Floats
    displacement: Floats
    depth: float


def comparisons(long: bool) -> Iterator[Comparison]:
    """A smooth and a rough round footing, then a keel with corners."""
    yield from geometry_error("roller", 0.1)
    yield from geometry_error("fixed", 0.1)
    if long:
        yield from geometry_error("roller", 0.05)
    yield from other_facets(long)
    yield from keel()


def geometry_error(condition: str, h: float) -> Iterator[Comparison]:
    """Error of the spline's geometry alone, and its rate.

    The normals are third order in the distance of the points, the positions fourth.
    """
    reference = press(round_footing(circle(), condition, h))
    errors = []
    for points in DIVISIONS[h]:
        outcome = press(round_footing(spline(points), condition, h))
        at = f"{condition}, {points} points on the circle, h {h:g} m"
        yield force_row(f"force, change, {at}", outcome, reference, 2e-4)
        errors.append(displacement_difference(outcome, reference))
        yield vanishing(f"displacements, change, {at}", errors[-1], 5e-4, CIRCLE)
        penetration = outcome.depth / h
        yield vanishing(
            f"deepest point behind it, in cells, {at}", penetration, 0.03, "none passes"
        )
    rate = math.log(errors[0] / errors[-1]) / math.log(DIVISIONS[h][-1] / DIVISIONS[h][0])
    quantity = f"rate of the displacements, {condition}, h {h:g} m"
    yield at_least(quantity, rate, 3.0, 0.0, "the spline's normals")


def other_facets(long: bool) -> Iterator[Comparison]:
    """Other quadrature points: the error of the boundary's own quadrature, as on circles."""
    for h in (0.1, 0.05) if long else (0.1,):
        reference = press(round_footing(circle(), "roller", h))
        outcomes = [press(round_footing(spline(n), "roller", h)) for n in OTHER_FACETS]
        for points, outcome in zip(OTHER_FACETS, outcomes, strict=True):
            quantity = f"force, change, {points} points on the circle, other facets, h {h:g} m"
            yield force_row(quantity, outcome, reference, 0.05 * h)


def keel() -> Iterator[Comparison]:
    """A moving edge with corners, in contact with soil: straight between them, to round-off."""
    model = example(PROBLEM, "keel.toml")
    geometry = dict(model.to_dict()["boundaries"][0]["geometry"])
    corners = {key: geometry[key] for key in ("vertices", "soil")}
    reference = press(varied(model, {"boundaries.0.geometry": {"type": "polyline", **corners}}))
    outcome = press(model)
    yield force_row("force on the keel, change", outcome, reference, 1e-10, POLYLINE)
    change = displacement_difference(outcome, reference)
    yield vanishing("displacements around the keel, change", change, 1e-10, POLYLINE)
    smooth = press(varied(model, {"boundaries.0.geometry.corners": []}))
    change = force_difference(smooth, reference)
    yield at_least("force on the keel without corners, change", change, 1e-3, 0.0, "a round keel")


def force_row(
    quantity: str, outcome: Outcome, reference: Outcome, tolerance: float, source: str = CIRCLE
) -> Comparison:
    """Returns a row: the largest relative difference of the forces against 0."""
    return vanishing(quantity, force_difference(outcome, reference), tolerance, source)


def force_difference(outcome: Outcome, reference: Outcome) -> float:
    """Returns the largest relative difference of the forces in a step [-]."""
    size = np.linalg.norm(reference.force, axis=1)
    return float((np.linalg.norm(outcome.force - reference.force, axis=1) / size).max())


def displacement_difference(outcome: Outcome, reference: Outcome) -> float:
    """Returns the points' largest difference of displacement over the largest displacement [-]."""
    size = np.linalg.norm(reference.displacement, axis=1).max()
    return float(np.linalg.norm(outcome.displacement - reference.displacement, axis=1).max() / size)


def circle() -> dict[str, Any]:
    """Returns the geometry of the circle."""
    return {"type": "circle", "centre": CENTRE, "radius": RADIUS, "soil": "outside"}


def spline(points: int) -> dict[str, Any]:
    """Returns a closed spline through this number of points of the circle."""
    angle = 2.0 * np.pi * np.arange(points) / points
    vertices = np.array(CENTRE) + RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return {"type": "spline", "vertices": vertices.tolist(), "closed": True, "soil": "right"}


def round_footing(geometry: Mapping[str, Any], condition: str, h: float) -> Model:
    """Returns the round footing with another geometry, condition and cell size [m]."""
    changes = {
        "boundaries.0.geometry": dict(geometry),
        "boundaries.0.condition": condition,
        "grid.cell_size": h,
        "grid.origin": [-0.3 * h, -0.4 * h],
        "schedule.outputs": 1,
    }
    return varied(example(PROBLEM), changes)


def press(model: Model) -> Outcome:
    """Runs a model; returns the forces on its first boundary and the points' displacements."""
    name, forces = model.boundaries[0].name, []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        forces.append(result.resultant(name))

    simulation = march(model, after_step)
    points = simulation.state.points
    footing = simulation.state.implicit[0]
    return Outcome(
        force=np.array(forces),
        displacement=points.displacement[np.argsort(points.point_id)],
        depth=footing.penetration(points.position, model.schedule.end),
    )
