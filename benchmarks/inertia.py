# SPDX-License-Identifier: BSD-3-Clause
"""What inertia adds to the processor time of a step, one thread.

Takes the same steps of the same problem with inertia and without it in turn. Prints the time of all
quasi-static steps, the time that inertia itself takes in the others relative to all their other
work, and the ratio of both times, with the numbers of Newton iterations that explain the
difference. A rough plate presses on a quarter of the upper face of a block of clay, from the first
step on into plastic flow, so slowly that both problems have the same answer.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from measure import machine

from tilth import Model, _core
from tilth.analysis.advance import begin_motion
from tilth.analysis.simulation import Simulation
from tilth.terms.inertia import AssembledInertia, Inertia
from tilth_verification.cases import varied

PROBLEMS = {
    "2D linear": ("plane_strain", "linear", 100, "none"),
    "2D GIMP, F-bar": ("plane_strain", "gimp", 100, "f_bar"),
    "3D linear": ("3d", "linear", 20, "none"),
    "3D GIMP, F-bar": ("3d", "gimp", 12, "f_bar"),
}
"""Problem -> kind, basis, cells a side, cure of locking."""

INERTIA = {"scheme": "generalised_alpha", "spectral_radius": 0.0}
"""Damps the vibrations of the start, which steps as long as these cannot follow."""

STEPS = 8
PENETRATION = 2e-3
"""Of the plate at the end, in heights of the block."""

DURATION = 200.0
"""Of the schedule [s]; the slowest vibration of the blocks takes about 6 s."""

WORK = [
    (Inertia, ("assembled",)),
    (
        AssembledInertia,
        ("add_stiffness", "commit", "force", "guess", "inertia_before", "magnitude"),
    ),
]
"""All that inertia does in a step."""


def block(kind: str, basis: str, cells: int, anti_locking: str) -> Model:
    """A block of clay on cells of 1 m, two points in each direction."""
    dim = 3 if kind == "3d" else 2
    axis = "xyz"[dim - 1]
    clay = {
        "model": "von_mises",
        "young_modulus": 1e7,
        "poisson_ratio": 0.48,
        "yield_stress": 1e4,
        "hardening_modulus": 0.0,
        "density": 1600.0,
    }
    body = {
        "name": "block",
        "material": "clay",
        "shape": {"type": "box", "lower": [0.0] * dim, "upper": [float(cells)] * dim},
        "basis": basis,
        "points_per_cell": 2,
        "anti_locking": anti_locking,
    }
    base = {"type": "plane", "name": "base", "axis": axis, "at": 0.0, "condition": "fixed"}
    still = dict.fromkeys("xyz"[: dim - 1], 0.0)
    plate = {
        "type": "plane",
        "name": "plate",
        "axis": axis,
        "at": float(cells),
        "condition": "prescribed",
        "range": {name: [0.0, cells // 4] for name in still},
        "displacement": still | {axis: -PENETRATION * cells},
        "factor": [[0.0, 0.0], [DURATION, 1.0]],
    }
    return Model.from_dict(
        {
            "units": {"length": "m", "force": "N", "time": "s"},
            "analysis": {"kind": kind, "tolerance": 1e-6},
            "grid": {"cell_size": 1.0},
            "materials": {"clay": clay},
            "bodies": [body],
            "boundaries": [base, plate],
            "schedule": {"steps": STEPS, "end": DURATION},
        }
    )


class Steps:
    """A simulation that is taken on step by step."""

    def __init__(self, model: Model) -> None:
        self.simulation, self._time = Simulation(model), 0.0
        simulation = self.simulation
        begin_motion(simulation.setup, simulation.state, simulation.services, 0.0, DURATION / STEPS)

    def take(self) -> tuple[float, int]:
        """Takes a step; returns its processor time [s] and Newton iterations."""
        after = self._time + DURATION / STEPS
        start = time.process_time()
        result = self.simulation.advance(self._time, after)
        whole = time.process_time() - start
        self._time = after
        return whole, result.equilibrium.iterations


class OwnTime:
    """Adds up the processor time of all calls of inertia's methods [s]."""

    def __init__(self) -> None:
        self.total = 0.0
        for owner, names in WORK:
            for name in names:
                setattr(owner, name, self._timed(getattr(owner, name)))

    def _timed(self, method: Callable[..., Any]) -> Callable[..., Any]:
        def timed(*arguments: Any) -> Any:
            start = time.process_time()
            value = method(*arguments)
            self.total += time.process_time() - start
            return value

        return timed


def main() -> None:
    """Prints one row per problem."""
    _core.set_threads(1)
    own = OwnTime()
    print(machine())
    heads = ("points", "iterations", "static [s]", "own share", "ratio", "iterations")
    print(f"{'problem':<20}" + "".join(f"{head:>12}" for head in heads))
    for name, problem in PROBLEMS.items():
        model = block(*problem)
        still = Steps(model)
        moving = Steps(varied(model, {"analysis.inertia": INERTIA}))
        own.total = 0.0
        pairs = [(still.take(), moving.take()) for _ in range(STEPS)]
        static, dynamic = (sum(pair[k][0] for pair in pairs) for k in range(2))
        counts = [sum(pair[k][1] for pair in pairs) for k in range(2)]
        share = own.total / (dynamic - own.total)
        print(
            f"{name:<20}{len(still.simulation.state.points):>12,}{counts[0]:>12}{static:>12.2f}"
            f"{share:>12.1%}{dynamic / static:>12.2f}{counts[1]:>12}"
        )


if __name__ == "__main__":
    main()
