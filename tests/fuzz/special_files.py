# SPDX-License-Identifier: BSD-3-Clause
"""What can stand where a file is expected, and damaged files that a body is read from."""

from __future__ import annotations

import os
from pathlib import Path
from random import Random

from input_kinds import FILES

from fuzz.mutations import NUMBERS, TEXTS, changed_bytes

MARK = b"\xef\xbb\xbf"
"""At the start of a text, by some editors."""

SHAPES = {
    ".geojson": '{ type = "outline", scale = 1.0, file = "NAME" }',
    ".dxf": '{ type = "outline", scale = 1.0, file = "NAME" }',
    ".stl": '{ type = "stl", scale = 1.0, file = "NAME" }',
    ".msh": '{ type = "mesh", file = "NAME" }',
    "section.csv": '{ type = "terrain", base = 0, lower = [0], upper = [2], '
    'surface = { file = "NAME" } }',
    "survey.csv": '{ type = "terrain", base = 0, lower = [0, 0], upper = [2, 2], '
    'surface = { file = "NAME", places = "scattered" } }',
    "": '{ type = "terrain", base = 0, lower = [0, 0], upper = [2, 2], '
    'surface = { file = "NAME" } }',
}
"""Of the body in a file, by the end of its name."""

IN_SPACE = ("surface.stl", "survey.csv", "grid.csv", "grid.asc")


def no_file(path: Path, random: Random) -> None:
    """Makes a folder, a pipe, a circle of links or a device at a path."""
    kind = random.randrange(4)
    if kind == 0:
        path.mkdir()
    elif kind == 1:
        os.mkfifo(path)
    else:
        path.symlink_to(path.name if kind == 2 else "/dev/zero")


def file_case(folder: Path, random: Random) -> bytes:
    """Writes a file with a body, damaged or none at all; returns a case file that names it."""
    name = random.choice(list(FILES))
    shape = next(text for end, text in SHAPES.items() if name.endswith(end))
    path = folder / name
    kind = random.random()
    if kind < 0.15:
        no_file(path, random)
    elif kind < 0.5:
        path.write_bytes(changed_bytes(FILES[name].encode(), random))
    else:
        path.write_bytes(_other_words(FILES[name], random).encode("utf-8", "surrogatepass"))
    axis, down = ("z", "0.0, 0.0, -9.81") if name in IN_SPACE else ("y", "0.0, -9.81")
    text = f"""format = 1
analysis = {{ kind = "{"3d" if name in IN_SPACE else "plane_strain"}" }}
grid = {{ cell_size = 0.5 }}
schedule = {{ steps = 2 }}
loads = [{{ type = "body_force", acceleration = [{down}] }}]
[materials.soil]
model = "hencky_elastic"
young_modulus = 1e6
poisson_ratio = 0.3
density = 1000.0
[[boundaries]]
name = "base"
type = "plane"
axis = "{axis}"
at = 0.0
condition = "fixed"
[[bodies]]
name = "block"
material = "soil"
basis = "gimp"
points_per_cell = 2
shape = {shape.replace("NAME", name)}
"""
    return (MARK if random.random() < 0.1 else b"") + text.encode()


def _other_words(text: str, random: Random) -> str:
    """Replaces one to three words of a text by hostile ones; lines stay lines."""
    lines = [line.split(" ") for line in text.split("\n")]
    for _ in range(random.choice((1, 1, 2, 3))):
        line = random.choice(lines)
        at = random.randrange(len(line))
        parts = line[at].split(",")
        parts[random.randrange(len(parts))] = str(random.choice(NUMBERS + TEXTS))
        line[at] = ",".join(parts)
    return "\n".join(" ".join(line) for line in lines)
