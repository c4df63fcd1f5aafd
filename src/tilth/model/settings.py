# SPDX-License-Identifier: BSD-3-Clause
"""Units, analysis, background grid and output settings."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.fields import (
    Components,
    Count,
    CountOrZero,
    Flag,
    Label,
    Name,
    NotNegative,
    Text,
    Tolerance,
    Vector,
    extent_problems,
)
from tilth.model.grading import CellSize
from tilth.model.inertia import Inertia
from tilth.model.laws import state_units
from tilth.model.problems import rejection

Kind = Literal["plane_strain", "axisymmetric", "3d"]


class Units(Declared):
    """Labels of the user's consistent units, shown in every output; nothing is converted.

    Known labels, such as m, kN, kPa and t, are checked against each other and against the numbers.
    """

    length: Label = "m"
    """Label of lengths and displacements."""
    force: Label = "N"
    """Label of forces (per unit length in plane strain, per full circle in axisymmetry)."""
    stress: Label = "Pa"
    """Label of stresses and moduli."""
    mass: Label = "kg"
    """Label of masses."""
    time: Label = ""
    """Label of the schedule's time; empty if the time has no physical meaning."""


class Analysis(Declared):
    """Kind of analysis, tolerance of the equilibrium and solver."""

    kind: Kind
    """Kind of analysis: "plane_strain", "axisymmetric" (x is r, y the axis; soil on the axis is
    constrained radially without a declaration) or "3d".
    """
    tolerance: Tolerance = 1e-9
    """Relative tolerance of the residual in the Newton iteration, divided by the forces [-]; at
    most 0.01.
    """
    maximum_iterations: Count = 15
    """Maximum number of Newton iterations of a load step."""
    line_search: Flag | None = None
    """Whether the Newton correction is shortened if the full one does not reduce the residual.

    If not given, a load step that fails without line search is repeated with it, and with twice the
    iterations, before it is halved.
    """
    predictor: Flag = True
    """Whether the displacement of the last step, scaled, is the initial estimate of a load step."""
    ghost_stabilisation: NotNegative = 0.005
    """Dimensionless stiffness that couples partly filled cells at a body's edge to the material
    beside them [-]; with 0 only weak springs hold their nodes.
    """
    inertia: Inertia | None = None
    """Inertia: the analysis is then dynamic, and the schedule's time a physical one. Without it the
    soil is in equilibrium after every step."""
    beyond_limit: Literal["stop", "relax"] = "stop"
    """What happens where a step of the least size has no equilibrium: "stop" ends the analysis,
    "relax" goes on to the next regular time of the schedule, lets the soil move with damped inertia
    until it is at rest there, and then goes on in equilibrium. All soil needs a density."""
    relaxation_steps: Count | None = None
    """Steps after which soil that "relax" has not brought to rest ends the analysis, 1000 if not
    given; with `beyond_limit = "relax"` only."""
    solver: Literal[
        "auto", "superlu", "pardiso", "banded", "multigrid", "mumps", "gamg", "hypre"
    ] = "auto"
    """Linear solver; "auto" selects "multigrid" for many unknowns, "banded" for slender bodies, and
    otherwise the fastest installed direct solver. Several processes share "multigrid" and those of
    PETSc, "mumps" (direct), "gamg" and "hypre" (algebraic multigrid), of which "auto" selects
    "multigrid" or "mumps"."""

    @model_validator(mode="after")
    def _relaxation_fits(self) -> Any:
        problems = []
        if self.beyond_limit == "relax" and self.inertia is not None:
            what = "has no meaning with `inertia`, which has no limit load"
            problems.append(Problem("beyond_limit", what, "leave one of them out", "relax"))
        if self.beyond_limit == "stop" and self.relaxation_steps is not None:
            what, remedy = 'has no meaning with beyond_limit = "stop"', "leave it out"
            problems.append(Problem("relaxation_steps", what, remedy, self.relaxation_steps))
        if problems:
            raise rejection(problems)
        return self

    @property
    def has_mass(self) -> bool:
        """Whether the mass of the soil matters, without a weight too."""
        return self.inertia is not None or self.beyond_limit == "relax"


class Limits(Declared):
    """Box that the material must not leave; coordinates [length], shape (dimension,)."""

    lower: Vector
    """Least coordinates [length], shape (dimension,)."""
    upper: Vector
    """Greatest coordinates [length], shape (dimension,)."""

    @model_validator(mode="after")
    def _upper_above_lower(self) -> Any:
        if problems := extent_problems(self.lower, self.upper):
            raise rejection(problems)
        return self


class Follow(Declared):
    """A point of an implicit boundary through which a grid line passes in every step.

    A stiff condition on part of a cell constrains the whole cell, so the edge of a footing should
    be on a grid line. The grid is discarded after each step, so the next one can be shifted.
    """

    boundary: Name
    """Name of the implicit boundary."""
    place: Vector
    """Position of the point at time 0 [length], shape (dimension,), such as a footing's edge."""
    axes: Components
    """Axes along which the grid is shifted: with "x" a line x = const. passes through the point.
    All its lines are shifted together, those of a graded grid too."""


class Grid(Declared):
    """Background grid, uniform or graded along each axis; unbounded unless `limits` are given."""

    origin: Vector | None = None
    """Coordinates of a grid node [length], shape (dimension,); zeros if not given. Along an axis
    with rows (place, size) it is the first place."""
    follow: Follow | None = None
    """A point through which a grid line passes in every step, instead of through `origin`."""
    cell_size: CellSize
    """Edge length of a cell [length], > 0: one number, or one per direction, or a table with a
    number or rows (place, size) for each axis. A grid line passes through each place; from one to
    the next the sizes form a geometric progression, scaled to a whole number of cells; beyond the
    first and the last place the cells next to it go on. Sizes of neighbours have a ratio of at most
    1.5. Along an axis of `follow` places are relative to the point that is followed, which is one
    of them.
    """
    limits: Limits | None = None
    """Box that the material points must not leave."""


def _of_tensor(name: str) -> tuple[str, ...]:
    parts = ("xx", "yy", "zz", "xy", "yz", "xz", "mean", "von_mises")
    return (name, *(f"{name}_{part}" for part in parts))


COLOURS = (
    "displacement",
    *(f"displacement_{axis}" for axis in "xyz"),
    *_of_tensor("cauchy_stress"),
    *state_units(),
    "volume",
)
"""Fields of the results, and their components, whatever the materials."""

COLOURS_OF_INERTIA = tuple(
    f"{name}{axis}" for name in ("velocity", "acceleration") for axis in ("", "_x", "_y", "_z")
)
"""Further fields of the results with inertia."""

COLOURS_OF_WATER = ("pore_pressure", *_of_tensor("effective_stress"))
"""Further fields of the results with `[water]` or `[flow]`."""

DARCY_VELOCITY = "darcy_velocity"
"""Field of the results: velocity of the flow relative to the soil, per area [length / time]."""

COLOURS_OF_FLOW = (DARCY_VELOCITY, *(f"{DARCY_VELOCITY}_{axis}" for axis in "xyz"))
"""Further fields of the results with `[flow]`, which has `excess_pore_pressure` of all soil."""


class Output(Declared):
    """Additional output at the output times."""

    checkpoint_every: CountOrZero = 1
    """Steps from one checkpoint to the next; with 0 there is none, and no run can be resumed."""
    deformation_gradient: Flag = False
    """Whether the deformation gradient of the points is written to the results."""
    colour_by: Text = "displacement"
    """Field that colours the report's pictures; of a vector without component the magnitude. A
    state variable of your own law by its name."""
    report: Flag = True
    """Whether report.html is written at the end of the run."""
