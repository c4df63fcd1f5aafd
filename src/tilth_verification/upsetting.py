# SPDX-License-Identifier: BSD-3-Clause
"""A nearly incompressible block pressed to 60 % of its height: load curve and reactions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.model import ImplicitBoundary, Model
from tilth.terms.weak_springs import RELATIVE_STIFFNESS
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, at_least, relative, vanishing
from tilth_verification.curves import Curve
from tilth_verification.turned import (
    ALIGNED,
    aligned,
    copies,
    implicit,
    reaction_difference,
    reactions,
)

PROBLEM = "upsetting"
YIELDING_FROM = 0.05
"""Fraction of the displacement from which on the block yields: compression by 2 %, twice the yield
strain."""
LARGEST_ROUGHNESS = 0.01
"""Largest roughness of a smooth curve [-]."""
LEAST_ROUGHNESS_RATIO = 5.0
"""Least ratio of the standard method's roughness to that with F-bar [-]."""


@dataclass(frozen=True)
class Outcome:
    """Results of a pressed block.

    Attributes:
        roughness: of the force on equal increments from `YIELDING_FROM` on, see `Curve` [-].
        force: on the platen at the end [force/length].
        balance: sum of the forces of both platens over the force of one, at the end [-].
        borne: force of weak springs over that of one platen [-]: beside the upper platen a cell
            into which soil comes has three nodes at most that no full cell holds, and each may
            move as far as the platen does in a step.
        compression: decrease of the volume over the volume [-].
        elastic: mean pressure over the bulk modulus, at the end [-].
    """

    roughness: float
    force: float
    balance: float
    borne: float
    compression: float
    elastic: float


def comparisons(long: bool) -> Iterator[Comparison]:
    """Smooth with F-bar and GIMP, five times rougher without; the volume is the elastic one."""
    smooth, standard = press("case.toml"), press("standard.toml")
    quantity = "RMS of the second difference of the force over its mean"
    source = "a smooth curve"
    yield vanishing(quantity, smooth.roughness, LARGEST_ROUGHNESS, source)
    ratio = standard.roughness / smooth.roughness
    yield at_least(
        f"{quantity}, standard over F-bar", ratio, LEAST_ROUGHNESS_RATIO, 0.0, "it locks"
    )
    quantity = "force of the standard method over that with F-bar"
    yield at_least(quantity, standard.force / smooth.force, 1.3, 0.0, "it locks")
    quantity = "decrease of volume"
    yield relative(quantity, smooth.compression, smooth.elastic, 0.05, "pressure / bulk modulus")
    source = "equilibrium, less what weak springs bear"
    yield vanishing("sum of the platens' forces over one", smooth.balance, smooth.borne, source)
    if long:
        yield from finer(smooth)
    yield from turned_copies(long)
    yield from where_conditions_meet(long)


def turned_copies(long: bool) -> Iterator[Comparison]:
    """Turned against the grid, and on a grid that is shifted: the final reaction of each boundary.

    On the shifted grid the platens' edges lie inside cells.
    """
    for size, tolerance in ((0.1, 0.15), (0.05, 0.08)) if long else ((0.1, 0.15),):
        model = aligned(PROBLEM, size)
        reference = reactions(model)
        quantity = f"greatest change of a reaction's component over the platen's, h {size:g} m"
        for at, angle, copy in copies(model):
            change = reaction_difference(reactions(copy, angle), reference)
            yield vanishing(f"{quantity}, {at}", change, tolerance, ALIGNED)


def finer(coarse: Outcome) -> Iterator[Comparison]:
    """Cells half as large; twice as many steps of half the size, on the same increments."""
    fine = press("case.toml", {"grid.cell_size": 0.05, "grid.origin": [0.0, -0.015]})
    quantity = "RMS of the second difference of the force over its mean, h 0.05 m"
    yield vanishing(quantity, fine.roughness, LARGEST_ROUGHNESS, "a smooth curve")
    yield relative("force at the end, h 0.1 and 0.05 m", coarse.force, fine.force, 0.02, "h 0.05 m")
    short = press("case.toml", {"schedule.steps": 160})
    quantity = "force at the end, 80 and 160 steps"
    yield relative(quantity, coarse.force, short.force, 0.01, "160 steps")


def where_conditions_meet(long: bool) -> Iterator[Comparison]:
    """Reactions of boundaries where fixed platens meet a roller, against those of nodes.

    The nodes of grid lines have the same conditions; a corner's reaction belongs to the symmetry
    line, since the platen's shear vanishes in it. The clay is stiffer, so that it yields before the
    platen has left its line.
    """
    sizes = ((0.1, 0.02, 0.05), (0.05, 0.01, 0.03)) if long else ((0.1, 0.02, 0.05),)
    for size, on_lines, elsewhere in sizes:
        nodes, model = meeting(size)
        reference = reactions(nodes)
        quantity = f"greatest difference of a reaction from elimination's, h {size:g} m"
        difference = reaction_difference(reactions(model), reference)
        yield vanishing(
            f"{quantity}, on the same lines", difference, on_lines, "constrained on grid lines"
        )
        for at, angle, copy in copies(model):
            difference = reaction_difference(reactions(copy, angle), reference)
            yield vanishing(f"{quantity}, {at}", difference, elsewhere, "constrained on grid lines")


def meeting(size: float) -> tuple[Model, Model]:
    """Returns stiffer clay, hardly pressed, between grid lines and between implicit boundaries."""
    model = varied(
        example(PROBLEM),
        {
            "grid.cell_size": size,
            "grid.origin": [0.0, 0.0],
            "materials.clay.young_modulus": 1e9,
            "boundaries.2.displacement": {"y": -0.002},
            "schedule.steps": 20,
            "schedule.outputs": 1,
            "track": [],
        },
    )
    line = {"type": "plane", "axis": "y", "range": {"x": [0.0, 0.5]}}
    moved = {"condition": "prescribed", "displacement": {"x": 0.0, "y": -0.002}}
    changes = {
        "boundaries.1": {**line, "name": "lower platen", "at": 0.0, "condition": "fixed"},
        "boundaries.2": {**line, "name": "upper platen", "at": 1.5, **moved},
    }
    return varied(model, changes), implicit(model)


def press(file: str, changes: Mapping[str, Any] = MappingProxyType({})) -> Outcome:
    """Returns the results of the block of a case file, with other values at dotted keys."""
    increments = example(PROBLEM, file).schedule.steps
    assert increments is not None
    model = varied(example(PROBLEM, file), changes)
    upper = next(b for b in model.boundaries if b.name == "upper platen")
    assert isinstance(upper, ImplicitBoundary)
    rows: list[tuple[float, float, float]] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        above, below = (result.resultant(f"{side} platen")[1] for side in ("upper", "lower"))
        rows.append((model.load_curve(upper).factor(time), -above, above + below))

    points = march(model, after_step).state.points
    part, force, residual = np.array(rows).T
    material, volume = model.materials["clay"], points.volume
    young_modulus, poisson_ratio = map(material.parameter, ("young_modulus", "poisson_ratio"))
    bulk = young_modulus / (3.0 * (1.0 - 2.0 * poisson_ratio))
    assert upper.displacement is not None
    way = abs(upper.displacement["y"]) / increments
    pressure = -points.stress[:, :3].mean(axis=1) @ volume / volume.sum()
    return Outcome(
        roughness=Curve(part, force).roughness(increments, YIELDING_FROM),
        force=float(force[-1]),
        balance=float(residual[-1] / force[-1]),
        borne=float(3.0 * RELATIVE_STIFFNESS * young_modulus * way / force[-1]),
        compression=float(1.0 - volume.sum() / points.initial_volume.sum()),
        elastic=float(pressure / bulk),
    )
