# SPDX-License-Identifier: BSD-3-Clause
"""A flat circular footing pushed through sand into clay: its peak resistance, and what follows."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tilth.model import Model
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms.limit_loads import CIRCULAR_FOOTING
from tilth_verification.comparison import Comparison, at_least, at_most, relative
from tilth_verification.contact_runs import run_contact
from tilth_verification.curves import Curve

PROBLEM = "spudcan_sand_over_clay"
DIAMETER, SAND = 6.0, 3.0
"""Of the footing, and height of the sand under it [m]."""
FRICTION, DILATION = math.radians(34.0), math.radians(4.0)
"""Angles of the sand [rad]."""
UNIT_WEIGHT, STRENGTH = 10.0, 20.0
"""Submerged unit weight of the sand [kN/m3]; s_u of the clay [kPa]."""
COARSE, FINE = 8, 16
"""Cells to the diameter."""
WAY, STEPS = 0.8, 12.5
"""Penetration of the case file, in diameters, and steps to a diameter and a cell of it."""
LEAST_DROP = 0.03
"""By how much of its peak the resistance falls after it, at least [-]."""
WIDER = 0.15
"""By how much the range of the two formulas is widened at each end [-]."""
GROUND, RADIUS = 12.0, 13.5
"""Depth and width of the quarter in 3D [m]; radius of the axisymmetric soil of nearly its area."""
SHARES, QUARTER_STEPS = (0.03, 0.05, 0.1, 0.15), 15
"""Penetrations over the diameter at which 3D is compared, and steps to the last of them."""
SPREAD = 5.0
"""Depth over which a load spreads by one to each side, of 3 to 5 in use: the least load [-]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """The peak and the drop after it on the coarse grid; long: also on the fine one, and in 3D."""
    coarse = push(COARSE)
    yield from punched(coarse, COARSE)
    if not long:
        return
    fine = push(FINE)  # about 10 minutes on one core
    yield from punched(fine, FINE)
    quantity = f"peak resistance, h D/{COARSE}"
    yield relative(quantity, peak(coarse)[1], peak(fine)[1], 0.15, f"h D/{FINE}", "kN")
    yield from in_space()


def punched(curve: Curve, cells: int) -> Iterator[Comparison]:
    """Rows: the peak, the drop after it, and how far the footing comes."""
    yield from peak_in_range(curve, cells)
    quantity = f"drop of the resistance after its peak, h D/{cells}"
    yield at_least(quantity, drop(curve), LEAST_DROP, 0.0, "punch-through")
    way = float(curve.displacement[-1]) / DIAMETER
    yield at_least(f"penetration over D at the end, h D/{cells}", way, WAY, 1e-9, "the case file")


def in_space() -> Iterator[Comparison]:
    """Rows: a quarter of the problem in 3D, in less soil, against axisymmetry."""
    around = run_contact(round_ground()).curve("footing", 1, -1.0)
    quarter = run_contact(quarter_of_ground()).curve("footing", 2, -4.0)  # 10 minutes on one core
    for share in SHARES:
        found, expected = (
            float(np.interp(share * DIAMETER, each.displacement, each.force))
            for each in (quarter, around)
        )
        quantity = f"resistance at {share:g} D, quarter in 3D, h D/{COARSE}"
        yield relative(quantity, found, expected, 0.08, "axisymmetry", "kN")


def round_ground() -> Model:
    """Returns the axisymmetric model with as little soil as the quarter."""
    return varied(
        example(PROBLEM),
        {
            "bodies.0.shape": {"type": "box", "lower": [0.0, -GROUND], "upper": [RADIUS, 0.0]},
            "boundaries.0.at": -GROUND,
            "boundaries.1.at": RADIUS,
            "rigid_bodies.0.displacement.y": -SHARES[-1] * DIAMETER,
            "schedule.steps": QUARTER_STEPS,
        },
    )


def quarter_of_ground() -> Model:
    """Returns the model of a quarter of the footing, z upwards."""
    entries = example(PROBLEM).to_dict()
    entries["analysis"]["kind"] = "3d"
    entries["bodies"][0] |= {
        "shape": {"type": "box", "lower": [0.0, 0.0, -GROUND], "upper": [GROUND, GROUND, 0.0]}
    }
    del entries["bodies"][0]["surface"]
    planes = {
        "symmetry x": ("x", 0.0), "symmetry y": ("y", 0.0), "base": ("z", -GROUND),
        "side x": ("x", GROUND), "side y": ("y", GROUND),
    }  # fmt: skip
    entries["boundaries"] = [
        {"name": name, "type": "plane", "axis": axis, "at": at, "condition": "roller"}
        for name, (axis, at) in planes.items()
    ]
    entries["loads"][0]["acceleration"] = [0.0, 0.0, -9.81]
    entries["rigid_bodies"][0] |= {
        "geometry": {
            "type": "cone", "tip": [0.0, 0.0, 0.0], "angle": 180.0, "radius": 0.5 * DIAMETER,
            "length": DIAMETER, "soil": "outside",
        },
        "centre": [0.0, 0.0, 0.0],
        "displacement": {"x": 0.0, "y": 0.0, "z": -SHARES[-1] * DIAMETER},
        "rotation": {"x": 0.0, "y": 0.0, "z": 0.0},
    }  # fmt: skip
    for track in entries["track"]:
        track["component"] = "z"
    entries["schedule"]["steps"] = QUARTER_STEPS
    return Model.from_dict(entries)


def push(cells: int) -> Curve:
    """Returns the resistance [kN] against the penetration [m].

    cells: of the grid, to the diameter.
    """
    steps = round(STEPS * WAY * cells)
    changes = {"grid.cell_size": DIAMETER / cells, "schedule.steps": steps}
    return run_contact(varied(example(PROBLEM), changes)).curve("footing", 1, -1.0)


def peak(curve: Curve) -> tuple[float, float]:
    """Returns penetration [m] and size [kN] of the greatest resistance."""
    number = int(curve.force.argmax())
    return float(curve.displacement[number]), float(curve.force[number])


def drop(curve: Curve) -> float:
    """Returns by how much of its peak the resistance falls after it [-]."""
    way, greatest = peak(curve)
    return 1.0 - float(curve.after(way).force.min()) / greatest


def peak_in_range(curve: Curve, cells: int) -> Iterator[Comparison]:
    """Rows: the peak lies between the two formulas, or not far beyond."""
    _, found = peak(curve)
    least, most = load_spread(SPREAD), punch_through()
    name = f"peak resistance, h D/{cells}"
    yield at_least(
        f"{name}, least", found, (1.0 - WIDER) * least, 0.0, f"load spread 1:{SPREAD:g} less 15 %",
        "kN",
    )  # fmt: skip
    source = "Lee et al. 2013 with Hu et al. 2014 and 15 %, from memory"
    yield at_most(f"{name}, most", found, (1.0 + WIDER) * most, 0.0, source, "kN")


def load_spread(spread: float) -> float:
    """Returns the capacity of the clay under the footing spread through the sand [kN].

    A footing of diameter D + 2 H / spread on the clay's surface with the bearing factor of a rough
    circle; that of SNAME T&R 5-5A, 2008, and ISO 19905-1, without its depth factor. The overburden
    beside the fictitious footing and the weight of the sand below the real one nearly cancel.

    spread: depth over which the load spreads by one to each side; 3 to 5 [-].
    """
    diameter = DIAMETER + 2.0 * SAND / spread
    return 0.25 * math.pi * diameter**2 * CIRCULAR_FOOTING["rough"] * STRENGTH


def punch_through() -> float:
    """Returns the peak resistance of sand over clay by Lee et al. [kN].

    K.K. Lee, M.F. Randolph, M.J. Cassidy, Géotechnique 63(15), 2013, 1285-1297: silo of sand whose
    wall is inclined by the angle of dilation, stress along it with the exponent E*; distribution
    factor D_F = 0.642 (H / D)^-0.576 of P. Hu, S.A. Stanier, M.J. Cassidy, D. Wang, Géotechnique
    64(10), 2014. Both from memory; the fit of the former for flat bases gives a quarter less.
    """
    ratio = SAND / DIAMETER
    tangent, sine = math.tan(DILATION), math.sin(FRICTION)
    reduced = sine * math.cos(DILATION) / (1.0 - sine * math.sin(DILATION))  # non-associated flow
    factor = 0.642 * math.pow(ratio, -0.576)
    exponent = 2.0 * (1.0 + factor * (reduced / tangent - 1.0))
    widening = 1.0 + 1.76 * ratio * tangent  # 0.88 H of sand below the footing at the peak
    clay = CIRCULAR_FOOTING["rough"] * STRENGTH + 0.12 * UNIT_WEIGHT * SAND
    weight = UNIT_WEIGHT * DIAMETER / (2.0 * tangent * (exponent + 1.0))
    own = 1.0 - (1.0 - 1.76 * ratio * exponent * tangent) * math.pow(widening, exponent)
    pressure = clay * math.pow(widening, exponent) + weight * own
    return 0.25 * math.pi * DIAMETER**2 * pressure
