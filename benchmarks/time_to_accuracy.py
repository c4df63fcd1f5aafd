# SPDX-License-Identifier: BSD-3-Clause
"""Error against processor time, on uniform and on graded grids, one thread.

Four limit loads in clay whose answers are known: a smooth strip footing (2 + pi), a smooth square
footing (5.25, graded finite elements), a smooth pipe lifted in deep clay (bounds 9.19 and 9.25)
and a smooth sphere pressed in by 0.3 of its diameter (its axisymmetric value). Prints cell, points,
value, error and processor time of the run; --picture draws error against time.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from measure import machine

from tilth import Model, _core
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth_verification import buried_pipe, rigid_sphere, square_footing, strip_footing
from tilth_verification.cases import example, varied

LIFT = 0.05
"""Of the pipe [m]: the clay flows from 0.03 m on."""


@dataclass(frozen=True)
class Problem:
    """A limit load on grids of several sizes.

    Attributes:
        exact: its value.
        uniform, graded: smallest cell sizes of the grids [m].
        grid: cell sizes of a graded grid by its smallest.
        model: the problem with these cell sizes.
        boundary, component: of the reaction that is the load.
        scale: value over reaction.
    """

    exact: float
    uniform: tuple[float, ...]
    graded: tuple[float, ...]
    grid: Callable[[float], dict[str, list[list[float]]]]
    model: Callable[[Any], Model]
    boundary: str
    component: int
    scale: float


def strip(cells: Any) -> Model:
    """The strip footing in ten steps."""
    changes = {"grid.cell_size": cells, **strip_footing.FEW_STEPS}
    return varied(example("strip_footing"), changes)


def strip_grid(h: float) -> dict[str, list[list[float]]]:
    """Fine at the footing's edge, up to four times as large half a footing's width away."""
    near = max(h, min(4.0 * h, 0.08))
    return {
        "x": [[0.0, near], [0.5, h], [1.0, near], [5.0, 0.6]],
        "y": [[0.0, 0.6], [4.0, near], [5.0, h]],
    }


def square(cells: Any) -> Model:
    """The square footing in eight steps; a line of a uniform grid follows its edges."""
    if isinstance(cells, dict):
        inside = -cells["x"][0][0]
        changes = {"grid.cell_size": cells, "grid.follow.place": [inside, inside, 5.0]}
        return varied(example("square_footing", square_footing.GRADED), changes)
    changes = {
        "grid.cell_size": cells,
        "bodies.0.points": None,
        "bodies.0.points_per_cell": 2,
        **square_footing.FEW_STEPS,
    }
    return varied(example("square_footing"), changes)


def square_grid(h: float) -> dict[str, list[list[float]]]:
    """Fine at the footing's edges, which are 0.45 of a cell beyond a line, and under it.

    Places along x and y are relative to this line.
    """
    inside, near = 0.5 - 0.45 * h, 1.5 * h
    across = [[-inside, near], [0.0, h], [h, h], [1.0 - inside, near], [5.0 - inside, 1.6]]
    return {"x": across, "y": across, "z": [[0.0, 1.6], [4.5, near], [5.0, 0.3 * h]]}


def pipe(cells: Any) -> Model:
    """The deep pipe, lifted half as far in ten steps."""
    changes: Mapping[str, Any] = {
        "grid.cell_size": cells,
        "boundaries.4.displacement": {"y": LIFT},
        "schedule.steps": 10,
        "schedule.outputs": 1,
    }
    return varied(example("buried_pipe"), changes)


def sphere(cells: Any) -> Model:
    """A quarter of the smooth sphere."""
    changes = {"grid.cell_size": cells, "schedule.outputs": 1}
    return varied(example("rigid_sphere", "three_dimensional.toml"), changes)


SHEAR_STRENGTH = 848.7e3 / np.sqrt(3.0)
"""Of the clay under the footings [Pa]."""

PROBLEMS = {
    "strip footing": Problem(
        2.0 + np.pi, (0.25, 0.1, 0.05), (0.1, 0.05, 0.025, 0.0125), strip_grid, strip,
        "footing", 1, -1.0 / (0.5 * SHEAR_STRENGTH),
    ),
    "square footing": Problem(
        5.25, (0.5, 0.25), (0.15, 0.1, 0.07), square_grid, square,
        "footing", 2, -1.0 / (0.25 * SHEAR_STRENGTH),
    ),
    "deep pipe": Problem(
        9.22, (0.25, 0.125, 0.0625), (0.125, 0.0625, 1.0 / 24.0), buried_pipe.graded_sizes, pipe,
        "pipe", 1, 2.0 / 1e4,
    ),
    "sphere in 3D": Problem(
        32.0e3, (0.25, 0.125), (0.25, 0.125, 0.1), rigid_sphere.graded_sizes, sphere,
        "sphere", 2, -4.0,
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Point:
    """One run.

    Attributes:
        label: uniform or graded.
        smallest: cell [m].
        points: number of material points.
        value, error: load, and its relative error [-].
        seconds: processor time.
    """

    label: str
    smallest: float
    points: int
    value: float
    error: float
    seconds: float


def runs(problem: Problem) -> Iterator[Point]:
    """Yields the runs of a problem, uniform ones first."""
    for label, sizes in (("uniform", problem.uniform), ("graded", problem.graded)):
        for h in sizes:
            cells = h if label == "uniform" else problem.grid(h)
            value, points, seconds = load(problem, problem.model(cells))
            error = abs(value / problem.exact - 1.0)
            yield Point(label, h, points, value, error, seconds)


def load(problem: Problem, model: Model) -> tuple[float, int, float]:
    """Returns the load at the end, the number of points and the processor time [s] of a run."""
    values: list[float] = []

    def after_step(simulation: Simulation, result: StepResult, at: float) -> None:
        reaction = result.resultant(problem.boundary)[problem.component]
        values.append(problem.scale * float(reaction))

    begin = time.process_time()
    simulation = march(model, after_step)
    return values[-1], len(simulation.state.points), time.process_time() - begin


def draw(path: Path, found: Mapping[str, list[Point]]) -> None:
    """Draws error against processor time, a panel for each problem."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    figure = Figure(figsize=(3.0 * len(found), 3.0), layout="constrained")
    for axes, (name, points) in zip(
        figure.subplots(1, len(found), squeeze=False)[0], found.items(), strict=True
    ):
        for label, style in (("uniform", "o-"), ("graded", "s-")):
            own = [point for point in points if point.label == label]
            axes.loglog(
                [p.seconds for p in own], [100.0 * p.error for p in own], style, label=label
            )
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_minor_formatter(NullFormatter())
        axes.set_title(name)
        axes.set_xlabel("processor time [s]")
        axes.set_ylabel("error [%]")
        axes.grid(which="both", linewidth=0.3)
        axes.legend()
    FigureCanvasAgg(figure).print_png(str(path))


def main() -> None:
    """Runs the problems and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", choices=PROBLEMS, default=list(PROBLEMS))
    parser.add_argument("--picture", type=Path, help="where to save the figure")
    arguments = parser.parse_args()
    _core.set_threads(1)
    print(machine())
    print(f"{'':16}{'':9}{'smallest':>9}{'points':>9}{'value':>10}{'error':>8}{'time':>9}")
    found: dict[str, list[Point]] = {}
    for name in arguments.only:
        found[name] = []
        for point in runs(PROBLEMS[name]):
            found[name].append(point)
            print(
                f"{name:16}{point.label:9}{point.smallest:7.4f} m{point.points:9,}"
                f"{point.value:10.4g}{100.0 * point.error:6.2f} %{point.seconds:7.1f} s",
                flush=True,
            )
    if arguments.picture:
        draw(arguments.picture, found)


if __name__ == "__main__":
    main()
