# SPDX-License-Identifier: BSD-3-Clause
"""A prestressed block that turns rigidly in an implicit box, or in a bonded rigid body."""

from __future__ import annotations

from typing import Any

import numpy as np

from tilth import Model

STRESS = np.array([[-100.0, 20.0, 0.0], [20.0, -50.0, 0.0], [0.0, 0.0, -70.0]])
LOWER, UPPER = [0.13, 0.21], [2.07, 1.33]
CENTRE = [3.1, -1.7]


def turned_block(basis: str, holder: str, angle: float, steps: int) -> Model:
    """The block in a "held" box or a "bonded" body that turns by an angle [degrees]."""
    box = {"type": "box", "lower": LOWER, "upper": UPPER, "soil": "inside"}
    ramp = [[0, 0], [1, 1]]
    stress = [*np.diag(STRESS).tolist(), float(STRESS[0, 1])]
    entries: dict[str, Any] = {
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": 0.25},
        "materials": {
            "soil": {"model": "hencky_elastic", "young_modulus": 2e3, "poisson_ratio": 0.3}
        },
        "bodies": [
            {
                "name": "block",
                "material": "soil",
                "shape": {"type": "box", "lower": LOWER, "upper": UPPER},
                "basis": basis,
                "points_per_cell": 2,
            }
        ],
        "initial": {"stress": [{"type": "given", "body": "block", "stress": stress}]},
        "schedule": {"steps": steps},
        "output": {"report": False},
    }
    if holder == "held":
        entries["boundaries"] = [
            {
                "name": "box",
                "type": "implicit",
                "condition": "fixed",
                "geometry": box,
                "rotation": {"angle": angle, "centre": CENTRE},
                "factor": ramp,
            }
        ]
    else:
        entries["rigid_bodies"] = [
            {
                "name": "box",
                "geometry": box,
                "centre": CENTRE,
                "rotation": angle,
                "displacement": {"x": 0.0, "y": 0.0},
                "factor": ramp,
                "contact": {"normal": "bilateral", "tangential": "bonded"},
                "wished_in_place": True,
            }
        ]
    return Model.from_dict(entries)


def turned_block_in_space(basis: str, holder: str, angle: float, steps: int) -> Model:
    """A smaller block, tilted about x; the box or body turns about y by an angle [degrees].

    The axis is oblique to the block.
    """
    entries = turned_block(basis, holder, angle, steps).to_dict()
    entries["analysis"]["kind"] = "3d"
    box = {"lower": [0.13, 0.21, 0.17], "upper": [1.07, 0.93, 0.79], "angle": 35.0, "axis": "x"}
    entries["bodies"][0]["shape"] |= box
    centre = [1.1, -0.7, 0.4]
    if holder == "held":
        boundary = entries["boundaries"][0]
        boundary["geometry"] |= box
        boundary["rotation"] = {"angle": angle, "centre": centre, "axis": "y"}
    else:
        body = entries["rigid_bodies"][0]
        body["geometry"] |= box
        body["centre"] = centre
        body["displacement"] = {"x": 0.0, "y": 0.0, "z": 0.0}
        body["rotation"] = {"x": 0.0, "y": angle, "z": 0.0}
    stress = [*np.diag(STRESS).tolist(), float(STRESS[0, 1]), 0.0, 0.0]
    entries["initial"]["stress"][0]["stress"] = stress
    return Model.from_dict(entries)
