# SPDX-License-Identifier: BSD-3-Clause
"""Units, analysis, background grid and output settings."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, model_validator

from tilth.model.base import Declared
from tilth.model.fields import (
    Components,
    Count,
    CountOrZero,
    Flag,
    Fraction,
    Name,
    NotNegative,
    PositivePerDirection,
    Text,
    Vector,
    extent_problems,
)
from tilth.model.laws import state_units
from tilth.model.problems import reject, rejection, suggestion

Kind = Literal["plane_strain", "axisymmetric", "3d"]


class Units(Declared):
    """Labels of the user's consistent units, shown in every output; they convert nothing."""

    length: Text = "m"
    """Label of lengths and displacements."""
    force: Text = "N"
    """Label of forces (per unit length in plane strain, per full circle in axisymmetry)."""
    stress: Text = "Pa"
    """Label of stresses and moduli."""
    mass: Text = "kg"
    """Label of masses."""
    time: Text = ""
    """Label of the schedule's time; empty where it only orders the loading."""


class Analysis(Declared):
    """What is analysed and how accurately its equilibrium is solved."""

    kind: Kind
    """Kind of analysis: "plane_strain", "axisymmetric" (x is r, y the axis, which holds the soil
    that reaches it by itself) or "3d".
    """
    tolerance: Fraction = 1e-9
    """Newton's iteration ends where the residual, relative to the forces, is below this [-]."""
    maximum_iterations: Count = 15
    """Newton iterations after which a step counts as not converged."""
    line_search: Flag | None = None
    """Whether Newton's step is shortened where the full one does not reduce the residual.

    If not given, a load step that fails without is repeated with it, and with twice the
    iterations, before it is halved.
    """
    predictor: Flag = True
    """Whether a load step begins with the displacement of the last one, scaled by its size."""
    ghost_stabilisation: NotNegative = 0.005
    """Dimensionless stiffness that ties hardly filled cells to the material beside them [-]; 0
    leaves their nodes on weak springs.
    """
    solver: Literal["auto", "superlu", "pardiso", "banded", "multigrid"] = "auto"
    """Linear solver; "auto" takes multigrid for many unknowns, "banded" for slender bodies, else
    the fastest direct solver installed.
    """


class Limits(Declared):
    """Box that the material may not leave; coordinates [length], shape (dimension,)."""

    lower: Vector
    """Least coordinates [length], one per direction."""
    upper: Vector
    """Greatest coordinates [length], one per direction."""

    @model_validator(mode="after")
    def _upper_above_lower(self) -> Any:
        if problems := extent_problems(self.lower, self.upper):
            raise rejection(problems)
        return self


class Follow(Declared):
    """A place on an implicit boundary that a grid line goes through in every step.

    A stiff condition on part of a cell holds the whole cell, so the edge of a footing is best on a
    line. The grid is thrown away after each step; where it stands in the next one is free.
    """

    boundary: Name
    """The implicit boundary."""
    place: Vector
    """Place that moves with it, at time 0 [length], shape (dimension,): a footing's edge."""
    axes: Components
    """Axes along which the grid is moved: "x" puts a line x = const. through the place."""


class Grid(Declared):
    """Regular background grid; unbounded unless `limits` are given."""

    origin: Vector | None = None
    """A grid node [length], shape (dimension,); zeros where not given."""
    follow: Follow | None = None
    """A place that a grid line goes through in every step, in place of that part of `origin`."""
    cell_size: PositivePerDirection
    """Edge length of a cell [length], > 0: one number, or one per direction."""
    limits: Limits | None = None
    """Box that no material point may leave."""


COLOURS = (
    "displacement",
    *(f"displacement_{axis}" for axis in "xyz"),
    "cauchy_stress",
    *(
        f"cauchy_stress_{part}"
        for part in ("xx", "yy", "zz", "xy", "yz", "xz", "mean", "von_mises")
    ),
    *state_units(),
    "volume",
)


def _colour(value: str) -> str:
    if value in COLOURS:
        return value
    likely = suggestion(value, COLOURS)
    remedy = f'did you mean "{likely}"? ' if likely else ""
    raise reject("no field of this name", f"{remedy}choose from {', '.join(COLOURS)}")


class Output(Declared):
    """What is written beside the results at the output times."""

    checkpoint_every: CountOrZero = 1
    """Steps from one checkpoint to the next; 0 writes none, so that no run can be resumed."""
    deformation_gradient: Flag = False
    """Whether the deformation gradient of the points is written to the results."""
    colour_by: Annotated[Text, AfterValidator(_colour)] = "displacement"
    """Field that colours the report's pictures; a vector without component by its magnitude."""
    report: Flag = True
    """Whether report.html is written at the end of the run."""
