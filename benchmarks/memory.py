# SPDX-License-Identifier: BSD-3-Clause
"""Prints the estimated and the measured peak memory of runs: `memory.py [--long]`.

Each case is a block under its own weight in a process of its own, on one thread.
"""

from __future__ import annotations

import argparse
from typing import Any

from measure import machine, run_case

import tilth
from tilth.analysis.memory import memory_of

CASES: list[dict[str, Any]] = [
    {"kind": "plane_strain", "cells": 2},
    {"kind": "plane_strain", "cells": 50},
    {"kind": "plane_strain", "cells": 100},
    {"kind": "plane_strain", "cells": 100, "basis": "linear"},
    {"kind": "plane_strain", "cells": 100, "basis": "cpdi2"},
    {"kind": "plane_strain", "cells": 100, "anti_locking": "f_bar"},
    {"kind": "plane_strain", "cells": 100, "implicit": True},
    {"kind": "plane_strain", "cells": 100, "solver": "multigrid"},
    {"kind": "plane_strain", "cells": 60, "points_per_cell": 6},
    {"kind": "plane_strain", "cells": 40, "length": 10},
    {"kind": "plane_strain", "cells": 10, "length": 50, "solver": "banded"},
    {"kind": "3d", "cells": 8},
    {"kind": "3d", "cells": 8, "basis": "linear"},
    {"kind": "3d", "cells": 12, "basis": "linear"},
    {"kind": "3d", "cells": 16, "basis": "linear"},
    {"kind": "3d", "cells": 12},
    {"kind": "3d", "cells": 4, "length": 40, "basis": "linear", "solver": "banded"},
    {"kind": "3d", "cells": 20, "basis": "linear", "solver": "multigrid"},
    {"kind": "3d", "cells": 16, "solver": "multigrid"},
    {"kind": "3d", "cells": 12, "basis": "cpdi2", "solver": "multigrid"},
    {"kind": "3d", "cells": 12, "anti_locking": "f_bar", "solver": "multigrid"},
    {"kind": "3d", "cells": 12, "implicit": True, "solver": "multigrid"},
]
LONG: list[dict[str, Any]] = [
    {"kind": "plane_strain", "cells": 200},
    {"kind": "plane_strain", "cells": 250, "solver": "multigrid"},
    {"kind": "3d", "cells": 16},
    {"kind": "3d", "cells": 20, "basis": "linear"},
    {"kind": "3d", "cells": 32, "basis": "linear", "solver": "multigrid"},
    {"kind": "3d", "cells": 24, "solver": "multigrid"},
]


def block(
    kind: str,
    cells: int,
    *,
    basis: str = "gimp",
    solver: str = "superlu",
    anti_locking: str = "none",
    implicit: bool = False,
    points_per_cell: int = 2,
    length: float = 1.0,
) -> tilth.Model:
    """A block of unit height and width with so many cells on them, `length` long."""
    axes = "xyz" if kind == "3d" else "xy"
    dim, cell = len(axes), 1.0 / cells
    rollers: list[dict[str, Any]] = [
        {"type": "plane", "name": axis, "axis": axis, "at": 0.0, "condition": "roller"}
        for axis in axes[:-1]
    ]
    if implicit:
        plane = {"type": "plane", "point": [0.0] * dim, "normal": [1.0] + [0.0] * (dim - 1)}
        rollers[0] = {"type": "implicit", "name": "x", "condition": "roller", "geometry": plane}
    origin = [0.37 * cell if implicit else 0.0] + [0.0] * (dim - 1)
    return tilth.Model.from_dict(
        {
            "analysis": {"kind": kind, "solver": solver, "tolerance": 1e-6},
            "grid": {"cell_size": cell, "origin": origin},
            "materials": {
                "soil": {
                    "model": "von_mises", "young_modulus": 1e7, "poisson_ratio": 0.3,
                    "density": 2000.0, "yield_stress": 2e4, "hardening_modulus": 1e4,
                }
            },
            "bodies": [
                {
                    "name": "soil", "material": "soil", "basis": basis,
                    "points_per_cell": points_per_cell, "anti_locking": anti_locking,
                    "shape": {
                        "type": "box", "lower": [0.0] * dim, "upper": [length] + [1.0] * (dim - 1)
                    },
                }
            ],
            "boundaries": [
                *rollers,
                {
                    "type": "plane", "name": "base", "axis": axes[-1], "at": 0.0,
                    "condition": "fixed",
                },
            ],
            "loads": [{"type": "body_force", "acceleration": [0.0] * (dim - 1) + [-9.81]}],
            "schedule": {"steps": 2, "outputs": 1},
            "output": {"report": False},
        }
    )  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--long", action="store_true", help="larger grids, too (some minutes)")
    print(machine())
    print(f"{'case':66} {'points':>9} {'unknowns':>9} {'peak':>8} {'estimate':>8} {'ratio':>6}")
    ratios = []
    for case in [*CASES, *(LONG if parser.parse_args().long else [])]:
        model = block(**case)
        done, estimate = run_case(model, 1).done, memory_of(model)
        ratios.append(estimate.total / done["peak"])
        unknowns = done["nodes"] * model.dimension
        text = ", ".join(str(v) if k == "kind" else f"{k} {v}" for k, v in case.items())
        print(
            f"{text:66} {done['points']:9,} {unknowns:9,} {done['peak'] / 1e6:5.0f} MB "
            f"{estimate.total / 1e6:5.0f} MB {ratios[-1]:6.2f}",
            flush=True,
        )
    print(f"ratio of estimate to measurement: {min(ratios):.2f} to {max(ratios):.2f}")


if __name__ == "__main__":
    main()
