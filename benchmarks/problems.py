# SPDX-License-Identifier: BSD-3-Clause
"""The problems that are timed; output of the last step only."""

from __future__ import annotations

import tilth
from tilth_verification.cases import example, varied

SIZE = 5.0
"""Edge of the block [m]."""


def cantilever(basis: str) -> tilth.Model:
    """AMPLE's end-loaded cantilever: 40 x 4 cells, 5,760 points, 50 steps."""
    return tilth.Model(
        title="AMPLE's end-loaded cantilever, 5,760 points",
        analysis=tilth.Analysis(kind="plane_strain"),
        grid=tilth.Grid(cell_size=0.25),
        materials={"beam": tilth.HenckyElastic(young_modulus=12e6, poisson_ratio=0.2)},
        bodies=[
            tilth.Body(
                name="beam", material="beam", basis=basis, points_per_cell=6,
                shape=tilth.Box(lower=[0, 0], upper=[10, 1]),
            )
        ],
        boundaries=[
            tilth.PlaneBoundary(name="root", axis="x", at=0, condition="roller"),
            tilth.NodeBoundary(name="pin", at=[0, 0.5], condition="fixed"),
        ],
        loads=[tilth.PointForce(body="beam", at=[10, 0.5], force=[0, -1e5])],
        schedule=tilth.Schedule(steps=50, outputs=1),
        track=[
            tilth.Track(name="tip", quantity="displacement", at=[10, 0.5], component="y"),
        ],
        output=tilth.Output(checkpoint_every=0, report=False),
    )  # fmt: skip


def block(cells: int = 25, basis: str = "linear", yield_stress: float | None = None) -> tilth.Model:
    """A smooth square plate pressed into an eighth of a block, eight points in each cell.

    Elastic, or von Mises with `yield_stress` [Pa]; the plate is as wide as the cells allow next to
    0.6 m.
    """
    cell = SIZE / cells
    width = max(1, round(0.6 / cell)) * cell
    soil = {"young_modulus": 1e7, "poisson_ratio": 0.48}
    clay = (
        tilth.HenckyElastic(**soil)
        if yield_stress is None
        else tilth.VonMises(yield_stress=yield_stress, hardening_modulus=0, **soil)
    )
    return tilth.Model(
        title=f"3D block, {(2 * cells) ** 3:,} points",
        analysis=tilth.Analysis(kind="3d", tolerance=1e-6, solver="auto"),
        grid=tilth.Grid(cell_size=cell),
        materials={"clay": clay},
        bodies=[
            tilth.Body(
                name="clay", material="clay", basis=basis, points_per_cell=2,
                shape=tilth.Box(lower=[0, 0, 0], upper=[SIZE] * 3),
            )
        ],
        boundaries=[
            *(
                tilth.PlaneBoundary(name=axis, axis=axis, at=0, condition="roller")
                for axis in "xyz"
            ),
            tilth.PlaneBoundary(
                name="plate", axis="z", at=SIZE, condition="prescribed",
                range={"x": [0, width], "y": [0, width]}, displacement={"z": -2e-4},
            ),
        ],
        schedule=tilth.Schedule(steps=2, outputs=1),
        track=[
            tilth.Track(
                name="plate", quantity="reaction", boundary="plate", component="z", scale=-1.0
            ),
        ],
        output=tilth.Output(checkpoint_every=0, report=False),
    )  # fmt: skip


def column(cells: int = 8192) -> tilth.Model:
    """AMPLE's self-weight column, E 10 kPa, `cells` over the height, 40 steps, GIMP."""
    cell = 50.0 / cells
    return varied(
        example("self_weight_column"),
        {
            "grid.cell_size": cell,
            "bodies.0.shape.upper": [cell, 50.0],
            "boundaries.2.at": cell,
            "schedule.outputs": 1,
            "output.report": False,
            "output.checkpoint_every": 0,
        },
    )
