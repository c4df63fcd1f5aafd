# SPDX-License-Identifier: BSD-3-Clause
"""A block in free fall: its parabola is in the space of the method, so it is exact."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tilth.analysis.march import march
from tilth.model import Model
from tilth_verification.cases import BASES, example, varied, with_basis
from tilth_verification.comparison import Comparison, vanishing

PROBLEM = "free_fall"
GRAVITY = 9.81
"""[m/s^2]"""
VELOCITY = 0.3, 0.7
"""At the start [m/s]."""
DURATION = 1.0
"""[s]"""
ROUND_OFF = 5e-9
"""What the projection and the solution of a step leave [-]."""
SCHEMES: dict[str, dict[str, object]] = {
    "Newmark": {"scheme": "newmark"},
    "generalised-alpha": {"scheme": "generalised_alpha", "spectral_radius": 0.6},
}
SOURCE = "x = v t, y = v t - g t^2 / 2"


def comparisons(long: bool) -> Iterator[Comparison]:
    """The greatest errors of all bases, for each kind of analysis and scheme."""
    del long
    for kind in ("plane_strain", "axisymmetric", "3d"):
        for name, scheme in SCHEMES.items():
            errors = np.array([errors_of(of_kind(kind, scheme, basis)) for basis in BASES])
            label = f"{kind}, {name}, worst of {len(BASES)} bases"
            for what, error in zip(("displacement", "velocity"), errors.max(axis=0), strict=True):
                yield vanishing(f"error of the {what}, {label}", float(error), ROUND_OFF, SOURCE)


def of_kind(kind: str, inertia: dict[str, object], basis: str) -> Model:
    """Returns the falling block in an analysis of a kind; in axisymmetry a cylinder falls."""
    model = with_basis(example(PROBLEM), basis)
    changes: dict[str, object] = {"analysis.kind": kind, "analysis.inertia": inertia}
    if kind == "axisymmetric":
        changes["bodies.0.shape.lower"] = [0.0, 0.21]
        changes["initial.velocity.0.x"] = None
    if kind == "3d":
        changes["bodies.0.shape"] = {
            "type": "box", "lower": [0.13, 0.21, 0.17], "upper": [0.93, 1.02, 0.71]
        }  # fmt: skip
        velocity = {"body": "block", "x": VELOCITY[0], "z": VELOCITY[1]}
        changes["initial.velocity"] = [velocity]
        changes["loads.0.acceleration"] = [0.0, 0.0, -GRAVITY]
        changes["track"] = None
    return varied(model, changes)


def errors_of(model: Model) -> tuple[float, float]:
    """Returns the greatest errors of any point's displacement and velocity over that it has."""
    points = march(model, lambda *_: None).state.points
    dim = model.dimension
    start, gravity = np.zeros(dim), np.zeros(dim)
    start[0] = 0.0 if model.analysis.kind == "axisymmetric" else VELOCITY[0]
    start[-1], gravity[-1] = VELOCITY[1], -GRAVITY
    moved = start * DURATION + 0.5 * gravity * DURATION**2
    velocity = start + gravity * DURATION
    return (
        float(np.abs(points.displacement - moved).max() / np.linalg.norm(moved)),
        float(np.abs(points.motion[:, 0] - velocity).max() / np.linalg.norm(velocity)),
    )
