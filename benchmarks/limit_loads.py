# SPDX-License-Identifier: BSD-3-Clause
"""Limit loads of footings, pipes and plates in weightless clay, by the bounds of limit_analysis.py.

Prints, for each problem, the load over the shear strength and the width or the diameter: lower
bound, upper bound, and the known number where there is one. `python benchmarks/limit_loads.py
--triangles 1200 --only pipe` (one to two minutes for each problem).
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable

import numpy as np
from limit_analysis import Body, Problem, bounds
from limit_mesh import mapped_mesh

from tilth.arrays import Floats
from tilth_verification.buried_pipe import bearing_factor

RADIUS = 0.5
"""Of the pipes, and half of the width of footing and plate."""


def flat(side: float) -> Callable[[Floats], Floats]:
    """Returns the normals of a level face."""
    return lambda points: np.tile([0.0, side], (len(points), 1))


def round_about(centre: tuple[float, float]) -> Callable[[Floats], Floats]:
    """Returns the normals of a circle, and the part of a mesh on it."""

    def normal(points: Floats) -> Floats:
        arm = points - np.array(centre)
        return np.asarray(arm / np.hypot(*arm.T)[:, None])

    return normal


def circle(centre: tuple[float, float], start: float, end: float, count: int) -> Floats:
    """Returns points on the pipe between two angles [rad], shape (count + 1, 2)."""
    angle = np.linspace(start, end, count + 1)
    return np.asarray(centre) + RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def onto(centre: tuple[float, float]) -> Callable[[str, Floats], Floats]:
    """Returns what moves new nodes of the contact onto the pipe."""
    normal = round_about(centre)
    return lambda part, point: (
        np.asarray(centre) + RADIUS * normal(point[None])[0] if part == "contact" else point
    )


def bowl(width: float, depth: float, count: int) -> Floats:
    """Returns a quarter of an ellipse from the surface down to the axis, shape (count + 1, 2)."""
    angle = np.linspace(0.0, -0.5 * math.pi, count + 1)
    return np.stack([width * np.cos(angle), depth * np.sin(angle)], axis=-1)


def box(width: float, top: float, bottom: float, counts: tuple[int, int, int, int]) -> Floats:
    """Returns the outline of half a box from the axis at the top to the axis at the bottom.

    counts: pieces of the top, of the side above and below y = 0, and of the bottom.
    """
    corners = [(0.0, top), (width, top), (width, 0.0), (width, bottom), (0.0, bottom)]
    lines = [
        np.linspace(a, b, n, endpoint=False)
        for a, b, n in zip(corners[:-1], corners[1:], counts, strict=True)
    ]
    return np.concatenate([*lines, [corners[-1]]])


def footing(rough: bool) -> Problem:
    """A strip footing on a level surface."""
    inner = np.stack([np.linspace(RADIUS, 0.0, 5), np.zeros(5)], axis=-1)
    names = (["contact"] * 4, ["far"] * 4)
    mesh = mapped_mesh(inner, bowl(3.0, 2.5, 4), 6, 1.5, ("surface", "symmetry"), names)
    body = Body((0.0, -1.0), float(rough), True, flat(-1.0))
    held, stress_free = {"symmetry": "x", "far": "xy"}, {"surface": "xy", "symmetry": "y"}
    return Problem(mesh, body, held, stress_free)


def seabed_pipe(embedment: float, rough: bool) -> Problem:
    """A pipe wished in place, embedded by a share of its diameter; the surface stays level."""
    centre = (0.0, RADIUS - embedment)
    start = -math.asin(centre[1] / RADIUS)
    inner = circle(centre, start, -0.5 * math.pi, 8)
    inner[-1, 0] = 0.0
    names = (["contact"] * 8, ["far"] * 8)
    mesh = mapped_mesh(inner, bowl(3.0, 2.5, 8), 6, 1.5, ("surface", "symmetry"), names)
    body = Body((0.0, -1.0), float(rough), True, round_about(centre))
    held, stress_free = {"symmetry": "x", "far": "xy"}, {"surface": "xy", "symmetry": "y"}
    return Problem(mesh, body, held, stress_free, onto(centre))


def deep_pipe(adhesion: float) -> Problem:
    """A pipe in deep clay that does not separate; a quarter, antisymmetric about its middle."""
    inner = circle((0.0, 0.0), 0.0, 0.5 * math.pi, 8)
    inner[-1, 0] = 0.0
    outer = bowl(2.0, -2.0, 8)
    names = (["contact"] * 8, ["far"] * 8)
    mesh = mapped_mesh(inner, outer, 6, 1.4, ("middle", "symmetry"), names)
    body = Body((0.0, 1.0), adhesion, False, round_about((0.0, 0.0)))
    held = {"symmetry": "x", "middle": "x", "far": "xy"}
    return Problem(
        mesh, body, held, {"symmetry": "y", "middle": "y"}, onto((0.0, 0.0)), multiple=4.0
    )


def deep_plate(rough: bool) -> Problem:
    """A thin plate in deep clay that does not separate; a quarter, as the pipe."""
    inner = np.stack([np.linspace(RADIUS, 0.0, 5), np.zeros(5)], axis=-1)
    names = (["contact"] * 4, ["far"] * 4)
    mesh = mapped_mesh(inner, bowl(3.0, 2.5, 4), 6, 1.5, ("middle", "symmetry"), names)
    body = Body((0.0, -1.0), float(rough), False, flat(-1.0))
    held = {"symmetry": "x", "middle": "x", "far": "xy"}
    return Problem(mesh, body, held, {"symmetry": "y", "middle": "y"}, multiple=4.0)


def lifted_pipe(depth: float, rough: bool, separates: bool = True) -> Problem:
    """A pipe at a depth of its centre below the surface, lifted."""
    counts = (4, 4, 4, 4)
    inner = circle((0.0, 0.0), 0.5 * math.pi, -0.5 * math.pi, sum(counts))
    inner[[0, -1], 0] = 0.0
    outer = box(depth + 2.0, depth, -2.0, counts)
    names = (["contact"] * 16, ["surface"] * 4 + ["far"] * 12)
    mesh = mapped_mesh(inner, outer, 5, 1.4, ("symmetry", "symmetry"), names)
    body = Body((0.0, 1.0), float(rough), separates, round_about((0.0, 0.0)))
    held, stress_free = {"symmetry": "x", "far": "xy"}, {"surface": "xy", "symmetry": "y"}
    return Problem(mesh, body, held, stress_free, onto((0.0, 0.0)))


def lifted_plate(depth: float, rough: bool) -> Problem:
    """A thin plate below a surface, lifted; a vented gap opens under it at once."""
    counts = (4, 4, 4, 4)
    across = RADIUS * np.abs(np.linspace(-1.0, 1.0, sum(counts) + 1))
    inner = np.stack([RADIUS - across, np.zeros(len(across))], axis=-1)
    outer = box(depth + 2.0, depth, -2.0, counts)
    names = (["contact"] * 8 + ["open"] * 8, ["surface"] * 4 + ["far"] * 12)
    mesh = mapped_mesh(inner, outer, 5, 1.4, ("symmetry", "symmetry"), names)
    body = Body((0.0, 1.0), float(rough), True, flat(1.0))
    held = {"symmetry": "x", "far": "xy"}
    return Problem(mesh, body, held, {"surface": "xy", "open": "xy", "symmetry": "y"})


def problems() -> dict[str, tuple[Callable[[], Problem], float]]:
    """Returns the problems by name, each with its known load, NaN where there is none."""
    found: dict[str, tuple[Callable[[], Problem], float]] = {}
    prandtl, unknown = 2.0 + math.pi, math.nan
    for rough, face in ((False, "smooth"), (True, "rough")):
        found[f"footing, {face}"] = (lambda r=rough: footing(r), prandtl)
    for w in (0.25, 0.5, 0.1):
        for rough, face in ((False, "smooth"), (True, "rough")):
            fitted = 7.1 * w**0.33 if rough else 5.3 * w**0.25
            found[f"seabed pipe, w {w:g} D, {face}"] = (
                lambda w=w, r=rough: seabed_pipe(w, r),
                fitted,
            )
    for a in (0.0, 0.25, 0.5, 0.75, 1.0):
        found[f"deep pipe, adhesion {a:g}"] = (lambda a=a: deep_pipe(a), bearing_factor(a))
    found["deep plate, rough"] = (lambda: deep_plate(True), 2.0 + 3.0 * math.pi)
    found["deep plate, smooth"] = (lambda: deep_plate(False), unknown)
    for depth in (1.0, 2.0, 3.0):
        for rough, face in ((False, "smooth"), (True, "rough")):
            of = f"centre {depth:g} D deep, {face}, separates"
            found[f"lifted pipe, {of}"] = (lambda d=depth, r=rough: lifted_pipe(d, r), unknown)
    for depth in (1.0, 2.0, 3.0):
        found[f"lifted plate, {depth:g} B deep, rough, vented"] = (
            lambda d=depth: lifted_plate(d, True),
            unknown,
        )
    return found


def main() -> None:
    """Prints the table of the chosen problems."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--triangles", type=int, default=1200)
    parser.add_argument("--only", default="", help="part of the problems' names")
    chosen = parser.parse_args()
    for name, (make, known) in problems().items():
        if chosen.only in name:
            start = time.perf_counter()
            lower, upper = bounds(make(), chosen.triangles)
            taken = time.perf_counter() - start
            print(
                f"{name}: {lower:.3f} to {upper:.3f}, known {known:.3f} ({taken:.0f} s)", flush=True
            )


if __name__ == "__main__":
    main()
