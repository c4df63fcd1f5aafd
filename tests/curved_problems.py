# SPDX-License-Identifier: BSD-3-Clause
"""Random problems with oblique, curved and moving boundaries.

Lengths are in cells of 0.15 to 0.3, in 3D of 0.3 to 0.5. What `problem_of` draws:

* Kind: every sixteenth problem in 3D; of the others 60 % plane strain, turned by any angle, and
  40 % axisymmetric, half of these on the axis and half a ring with its middle 8 to 11 from it. The
  grid's origin is anywhere.
* Body, 70 %: a block 7 to 11 wide (three quarters of that from the axis on) and 6 to 9 high with a
  free top and sides up to 10 degrees oblique. Its floor is an oblique plane, a polyline with kinks,
  a wavy spline, or a circle that the soil is inside or outside of. On a floor that is a roller it
  stands between two walls, rollers too (the axis may be one of them); on a fixed one in half of the
  problems.
* Body, 30 %: all that is inside a closed circle, polyline or spline of radius 3.5 to 4.5.
* Tool: a circle, polyline or spline of radius 0.8 to 1.8 with the soil outside, pressed into the
  block's top (25 %), half embedded in it (25 %) or buried (25 %); a plane that covers the top
  (15 %); or none (10 %). A body in a closed curve has such a core in half of the problems.
* Motion of the tool: none in 15 %. Pressed: by 0.2 to 2, a quarter of the height at most, up to 30
  degrees from the normal. Embedded or buried: in any direction by 10 to 30 % of the soil between it
  and the next edge. Plane: by 2 to 12 % of the height. In 40 % it turns by up to 10 degrees too
  (plane strain), and the radius of a circle changes by up to 10 %.
* What holds the body moves in up to 40 %: all of it by up to 0.4 and 3 degrees, without a tool up
  to 2 and 20 degrees; or one wall by up to 5 % of the width; or the radius of a closed circle
  changes by up to 5 %.
* Conditions: roller or fixed. A body force in half of the problems, and where nothing moves: the
  weight over the height is 1 to 10 % of Young's modulus, in soil that yields 10 to 50 % of the
  yield stress, in plane strain up to 45 degrees oblique.
* Soil: elastic or hardening von Mises, yield stress 0.5 to 5 %, hardening 1 to 10 % of Young's
  modulus; nu from 0 to 0.45, with F-bar to 0.49, and to 0.35 where the boundaries prescribe the
  volume, for the pressure then grows as 1 / (1 - 2 nu). All bases, F-bar in half of the problems, 2
  to 4 points per cell and direction, 5 to 10 steps (3D: 2 points, 4 to 6 steps).
* 3D: a box 3 to 4 wide, turned about a horizontal axis, on an oblique plane, with a plane, sphere
  or cylinder pressed into its top, or its weight alone; or a ball in a sphere that moves, turns and
  shrinks.

Left out because nothing would hold the soil, so that there is no one solution: a circle with only
rollers around the body in plane strain (the soil can turn in it). Left out because the conditions
contradict each other where they meet: a wall that moves along a fixed floor, and a fixed plane that
is pressed on soil between oblique walls.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from curved_shapes import Frame, Random, Round, floor_of, pieces
from implicit_blocks import flat, implicit
from small_problems import BASES

from tilth.arrays import Floats
from tilth.boundaries.surfaces.motion import rotation_matrix

YOUNG = 1000.0
WAYS = {"pressed": 0.25, "embedded": 0.25, "buried": 0.25, "plane": 0.15, "none": 0.1}
"""What a block's tool does, and how often."""


@dataclass(frozen=True)
class Problem:
    """A random problem: its model, and what it is, for the list of those that stop."""

    entries: dict[str, Any]
    text: str


@dataclass(frozen=True)
class Held:
    """A body and what holds it, in the problem's own axes.

    Attributes:
        outline: anticlockwise; a block's top right and top left corners are the last two.
        walls: what holds it.
        closed: the wall, where one closed curve holds the body.
    """

    outline: Floats
    walls: list[dict[str, Any]]
    height: float
    width: float
    text: str
    closed: Round | None = None


def problem_of(seed: int) -> Problem:
    """A random problem of the distribution at the head of this file."""
    random = np.random.default_rng([21, seed])
    entries, parts = solid_of(random) if seed % 16 == 7 else flat_of(random)
    soil, body = entries["materials"]["soil"], entries["bodies"][0]
    names = [*parts, entries["analysis"]["kind"], soil["model"], f"nu {soil['poisson_ratio']:.2f}",
             body["basis"] + (" with F-bar" if "anti_locking" in body else ""),
             f"{body['points_per_cell']} points", f"cell {entries['grid']['cell_size']:.2f}",
             f"{entries['schedule']['steps']} steps",
             "body force" if entries["loads"] else "no body force"]  # fmt: skip
    return Problem(entries, f"seed {seed}: " + ", ".join(names))


def assembled(
    random: Random,
    kind: str,
    frame: Frame,
    shapes: list[dict[str, Any]],
    walls: list[dict[str, Any]],
    height: float,
    confined: bool,
    still: bool,
) -> dict[str, Any]:
    """The model of a body of a height in cells; `confined`: its boundaries prescribe its volume."""
    dim = len(frame.origin)
    basis, f_bar = str(random.choice(BASES)), bool(random.random() < 0.5)
    points = 2 if dim == 3 else int(random.integers(2, 5))
    body: dict[str, Any] = {"material": "soil", "basis": basis, "points_per_cell": points}
    rule = str(random.choice(["right_stretch", "determinant"]))
    body |= {"domain_update": rule} if basis == "gimp" else {}
    body |= {"anti_locking": "f_bar"} if f_bar else {}
    steps = int(random.integers(4, 7) if dim == 3 else random.integers(5, 11))
    origin = random.uniform(0.0, frame.cell, dim).tolist()
    nu = random.uniform(0.0, 0.35 if confined else 0.49 if f_bar else 0.45)
    soil: dict[str, Any] = {"model": "hencky_elastic", "young_modulus": YOUNG,
                            "poisson_ratio": nu, "density": 1.0}  # fmt: skip
    strength, hardening = random.uniform([5.0, 10.0], [50.0, 100.0]).tolist()
    if random.random() < 0.5:
        soil |= {"model": "von_mises", "yield_stress": strength, "hardening_modulus": hardening}
    tilt = random.uniform(-np.pi / 4.0, np.pi / 4.0) if kind == "plane_strain" else 0.0
    elastic, part = random.uniform(0.01, 0.1) * YOUNG, random.uniform(0.1, 0.5)
    force = part * soil["yield_stress"] if "yield_stress" in soil else elastic
    pull = np.zeros(dim)
    pull[[0, -1]] = force / (frame.cell * height) * np.array([np.sin(tilt), -np.cos(tilt)])
    load = {"type": "body_force", "acceleration": frame.direction(pull)}
    return {
        "analysis": {"kind": kind, "solver": "superlu"},
        "grid": {"cell_size": frame.cell, "origin": origin},
        "materials": {"soil": soil},
        "bodies": [{"name": f"body {k}", "shape": s, **body} for k, s in enumerate(shapes)],
        "boundaries": [frame.set_in(wall) for wall in walls],
        "loads": [load] if random.random() < 0.5 or still else [],
        "schedule": {"steps": steps, "outputs": 1},
    }


def enclosed(random: Random, condition: str, loose: bool) -> Held:
    """A body in a closed curve; `loose`: if that were a circle and a roller, it could turn."""
    wall = Round.drawn(random, [0.0, 0.0], random.uniform(3.5, 4.5))
    condition = "fixed" if loose and wall.type == "circle" else condition
    walls = [implicit("wall", wall.geometry("inside"), condition)]
    outline, width = wall.arc(0.0, 2.0 * np.pi)[:-1], 2.0 * wall.radius
    text = f"in a {condition} closed {wall.type} of radius {wall.radius:.1f}"
    return Held(outline, walls, width, width, text, wall)


def block(random: Random, condition: str, on_axis: bool) -> Held:
    width, height = random.uniform([7.0, 6.0], [11.0, 9.0]).tolist()
    low, high = (-2.0, 0.75 * width) if on_axis else (-0.5 * width, 0.5 * width)
    name, floor, geometry = floor_of(random, low, high)
    ends, lean = floor[[0, -1]], random.uniform(-0.17, 0.17, 2)
    tops = np.column_stack([ends[:, 0] + lean * (height - ends[:, 1]), [height, height]])
    walls = [implicit("floor", geometry, condition)]
    walled = condition == "roller" or random.random() < 0.5
    for k, side in enumerate(["left", "right"]):
        if walled and not (on_axis and k == 0):
            up = tops[k] - ends[k]
            normal = np.array([up[1], -up[0]]) * (1.0 if k == 0 else -1.0)
            walls.append(implicit(side, flat(ends[k], normal)))
    text = f"block {width:.1f} by {height:.1f} on a {condition} {name}"
    text += (" between walls" if walled else "") + (" on the axis" if on_axis else "")
    return Held(np.vstack([floor, tops[::-1]]), walls, height, width, text)


def tool_of(
    random: Random, constrained: Held, way: str, on_axis: bool
) -> tuple[Round | None, float]:
    """The tool, and the length that scales its motion."""
    radius, offset = random.uniform(0.8, 1.8), random.uniform(-0.4, 0.4, 2)
    if on_axis:
        offset[0] = 0.0
    if constrained.closed is not None:
        room = constrained.closed.radius * (0.6 if constrained.closed.type == "spline" else 0.7)
        radius = min(radius, 0.5 * room)
        centre, gap = offset, room - radius - 0.4
    elif way == "buried":
        centre = np.array([offset[0], 0.5 * constrained.height])
        gap = 0.5 * min(constrained.height, constrained.width) - radius - 1.0
    else:
        centre, gap = np.array([offset[0], constrained.height]), 0.4 * constrained.height
    if way not in ("pressed", "embedded", "buried"):
        return None, gap
    tool = Round.drawn(random, centre, radius)
    if way == "pressed":
        lowest = tool.arc(0.0, 2.0 * np.pi)[:, 1].min() - constrained.height
        tool = replace(tool, centre=centre - [0.0, lowest])
    return tool, gap


def motion_of(
    random: Random, constrained: Held, way: str, tool: Round | None, gap: float, free: str
) -> dict[str, Any]:
    """How the tool moves: `free` in any way, along the axis ("axis") or without a turn ("ring")."""
    angle, size = random.uniform(-np.pi, np.pi), random.uniform(0.1, 0.3) * gap
    if way == "pressed":
        angle = random.uniform(-2.0, -1.0) * np.pi / 3.0
        size = random.uniform(0.2, min(2.0, 0.25 * constrained.height))
    if way == "plane":
        angle, size = -0.5 * np.pi, random.uniform(0.02, 0.12) * constrained.height
    if free == "axis":
        angle = np.copysign(0.5 * np.pi, angle)
    moving, turning, growing = (random.random(3) < [0.85, 0.4, 0.4]).tolist()
    turn, growth = random.uniform(-10.0, 10.0), random.uniform(-0.1, 0.1)
    motion: dict[str, Any] = {}
    if moving and way != "none":
        motion["displacement"] = [size * np.cos(angle), size * np.sin(angle)]
    if turning and free == "any" and tool is not None:
        motion["rotation"] = {"angle": turn, "centre": tool.centre}
    if growing and tool is not None and tool.type == "circle" and way != "pressed":
        motion["radius_change"] = growth * tool.radius
    return motion


def carry(random: Random, constrained: Held, alone: bool, free: str) -> str:
    """Moves what holds the body: all of it, a side, the radius of a closed circle, or nothing."""
    which, part = random.random(), random.uniform(-1.0, 1.0, 3)
    far, angle = (2.0, 20.0) if alone else (0.4, 3.0)
    first, last = constrained.walls[0], constrained.walls[-1]
    if which < 0.2:
        by = far * part[:2] * [0.0 if free == "axis" else 1.0, 1.0]
        for wall in constrained.walls:
            wall["displacement"] = by
            if free == "any":
                wall["rotation"] = {"angle": angle * part[2], "centre": [0.0, 0.0]}
        return "all that holds it moves"
    if which < 0.4 and first is not last and first["condition"] == "roller":
        last["displacement"] = [0.05 * constrained.width * part[0], 0.0]
        return "a side moves"
    if which < 0.4 and constrained.closed is not None and constrained.closed.type == "circle":
        first["radius_change"] = 0.05 * part[0] * constrained.closed.radius
        return "its radius changes"
    return "the rest still"


def flat_of(random: Random) -> tuple[dict[str, Any], list[str]]:
    """A problem in plane strain or axisymmetry, and what it is."""
    axisymmetric, on_axis = bool(random.random() < 0.4), bool(random.random() < 0.5)
    on_axis &= axisymmetric
    free = "axis" if on_axis else "ring" if axisymmetric else "any"
    cell, turn = float(random.uniform(0.15, 0.3)), float(random.uniform(0.0, 360.0))
    shift = random.uniform(-4.0, 4.0, 2)
    if axisymmetric:
        turn, shift[0] = 0.0, 0.0 if on_axis else random.uniform(8.0, 11.0)
    frame = Frame(rotation_matrix(turn, None, 2), cell * shift, cell)
    condition, other = (str(c) for c in random.choice(["roller", "fixed"], 2))
    if random.random() < 0.3:
        way = str(random.choice(["buried", "none"]))
        loose = not axisymmetric and (way == "none" or other == "roller")
        constrained = enclosed(random, condition, loose)
    else:
        way = str(random.choice(list(WAYS), p=list(WAYS.values())))
        constrained = block(random, condition, on_axis)
        if way == "plane" and len(constrained.walls) > 1:
            other = "roller"
    tool, gap = tool_of(random, constrained, way, on_axis)
    motion = motion_of(random, constrained, way, tool, gap, free)
    rest = carry(random, constrained, way == "none", free)
    still = rest == "the rest still" and not motion
    walls, outline, used = constrained.walls, constrained.outline, "no tool"
    if tool is not None:
        walls.append(implicit("tool", tool.geometry("outside"), other, **motion))
        if way == "embedded":
            outline = np.vstack([outline[:-1], tool.arc(0.0, -np.pi), outline[-1:]])
    elif way == "plane":
        walls.append(
            implicit("tool", flat([0.0, constrained.height], [0.0, -1.0]), other, **motion)
        )
    if way != "none":
        used = f"{other} {tool.type if tool else ''} {way} ({', '.join(motion) or 'still'})"
    changing = any("radius_change" in wall for wall in walls)
    confined = way == "plane" or (constrained.closed is not None and changing)
    parts = pieces(outline, tool if way == "buried" else None, on_axis)
    shapes = [frame.set_in({"type": "polygon", "vertices": part}) for part in parts]
    kind = "axisymmetric" if axisymmetric else "plane_strain"
    entries = assembled(random, kind, frame, shapes, walls, constrained.height, confined, still)
    return entries, [constrained.text, used, rest]


def solid_of(random: Random) -> tuple[dict[str, Any], list[str]]:
    """A box on an oblique plane or a ball in a sphere, and what it is."""
    cell = float(random.uniform(0.3, 0.5))
    origin = random.uniform(-1.0, 1.0, 3)
    axis, angle = str(random.choice(["x", "y"])), float(random.uniform(-60.0, 60.0))
    frame = Frame(rotation_matrix(angle, axis, 3), origin, cell)
    condition, other = (str(c) for c in random.choice(["roller", "fixed"], 2))
    unit = np.eye(3)
    if random.random() < 0.25:
        way, radius = "none", random.uniform(1.6, 2.0)
        height = 2.0 * radius
        sphere = {"type": "sphere", "centre": [0.0, 0.0, 0.0], "radius": radius}
        shape = frame.set_in(sphere)
        walls = [
            implicit("wall", {**sphere, "soil": "inside"}, "fixed",
                     displacement=0.5 * random.uniform(-1.0, 1.0, 3),
                     rotation={"angle": 10.0, "centre": [0.0, 0.0, 0.0], "axis": axis},
                     radius_change=-0.05 * radius * random.random())
        ]  # fmt: skip
        parts = ["ball in a sphere"]
    else:
        size = random.uniform(3.0, 4.0, 3)
        height = float(size[2])
        shape = {"type": "box", "lower": origin.tolist(), "upper": (origin + cell * size).tolist(),
                 "angle": angle, "axis": axis}  # fmt: skip
        walls = [implicit("floor", flat([0.0, 0.0, 0.0], unit[2]), condition)]
        if condition == "roller":
            for k in (0, 1):
                walls.append(implicit(f"low {k}", flat([0.0, 0.0, 0.0], unit[k])))
                walls.append(implicit(f"high {k}", flat(size, -unit[k])))
        way = str(random.choice(["plane", "sphere", "cylinder", "none"]))
        radius = random.uniform(1.0, 1.5)
        top = size * [0.5, 0.5, 1.0]
        round_ = {"type": way, "centre": top + radius * unit[2], "radius": radius,
                  "soil": "outside"}  # fmt: skip
        if way == "cylinder":
            round_["axis"] = unit[0]
        tool = flat(top, -unit[2]) if way == "plane" else round_
        down = [0.0, 0.0, -random.uniform(0.1, 0.3)]
        if way != "none":
            walls.append(implicit("tool", tool, other, displacement=down))
        parts = [f"box at {angle:.0f} degrees on a {condition} plane", f"{other} {way}"]
    still, confined = way == "none", way in ("none", "plane")
    return assembled(random, "3d", frame, [shape], walls, height, confined, still), parts
