# SPDX-License-Identifier: BSD-3-Clause
"""A correct file of each kind, damaged in every place: it is read, or refused with a message."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from input_kinds import FILES

from tilth.bodies.discretise import discretise
from tilth.bodies.size import body_size
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.model import Body, Outline, Stl, Terrain
from tilth.model.file_shapes import Mesh

MARK = b"\xef\xbb\xbf"
"""What Windows editors put at the start of a text in UTF-8."""

HOSTILE = ["", "-1", "0", "2.5", "nan", "inf", "1e400", "9" * 25, "x", '"', "=", "\t", "é", "\0"]
"""What a token is replaced by."""


def body_of(shape: Any) -> None:
    dim = 3 if isinstance(shape, Stl) or len(getattr(shape, "lower", ())) == 2 else 2
    kind = "3d" if dim == 3 else "plane_strain"
    grid = Grid(np.zeros(dim), np.full(dim, 0.5))
    body = Body(name="a", material="a", basis="gimp", points_per_cell=2, shape=shape)
    if body_size(body, kind, grid).points < 1e4:  # else a run is refused for its memory
        discretise(body, kind, grid)


def terrain(file: str, dim: int = 2, **more: Any) -> Terrain:
    lower, upper = [0.0] * (dim - 1), [2.0] * (dim - 1)
    return Terrain(lower=lower, upper=upper, base=0.0, surface={"file": file, **more})  # type: ignore[arg-type]


READERS: dict[str, Callable[[str], Any]] = {
    "outline.geojson": lambda f: body_of(Outline(file=f, scale=1.0)),
    "drawing.dxf": lambda f: body_of(Outline(file=f, scale=1.0)),
    "surface.stl": lambda f: body_of(Stl(file=f, scale=1.0)),
    "two.msh": lambda f: body_of(Mesh(file=f)),
    "four.msh": lambda f: body_of(Mesh(file=f)),
    "section.csv": lambda f: body_of(terrain(f)),
    "grid.csv": lambda f: body_of(terrain(f, 3)),
    "survey.csv": lambda f: body_of(terrain(f, 3, places="scattered")),
    "grid.asc": lambda f: body_of(terrain(f, 3)),
}


def written(folder: Path, name: str, content: bytes) -> str:
    (folder / name).write_bytes(content)
    return str(folder / name)


@pytest.fixture(params=FILES)
def kind(request: pytest.FixtureRequest) -> tuple[str, str, Callable[[str], Any]]:
    """Name of a file, its correct content, and what reads it."""
    return request.param, FILES[request.param], READERS[request.param]


Kind = tuple[str, str, Callable[[str], Any]]


def test_the_correct_file_is_read_with_a_mark_at_its_start_too(kind: Kind, tmp_path: Path) -> None:
    name, text, read = kind
    read(written(tmp_path, name, text.encode()))
    read(written(tmp_path, name, MARK + text.replace("\n", "\r\n").encode()))


def damaged(text: str) -> Iterator[str]:
    """Cut off, without a line, with a line twice, and with another token in each place."""
    lines = text.splitlines(keepends=True)
    for number in range(len(lines)):
        yield "".join(lines[:number])
        yield "".join(lines[:number] + lines[number + 1 :])
        yield "".join(lines[: number + 1] + lines[number:])
    places = [i for i, c in enumerate(text) if not c.isspace() and c not in ',":[]{}']
    starts = [i for i in places if i - 1 not in places]
    for turn, start in enumerate(starts):
        end = start
        while end + 1 in places[-1:] or text[end + 1 : end + 2].strip(' \n\r\t,":[]{}'):
            end += 1
        for other in (HOSTILE[turn % len(HOSTILE)], HOSTILE[(turn * 5 + 3) % len(HOSTILE)]):
            yield text[:start] + other + text[end + 1 :]


@pytest.mark.filterwarnings("error")
def test_a_damaged_file_is_read_or_refused(kind: Kind, tmp_path: Path) -> None:
    name, text, read = kind
    messages, faults = [], []
    for number, content in enumerate(damaged(text)):
        file = written(tmp_path, name, content.encode())
        try:
            read(file)
        except BadInput as error:
            messages.append(str(error))
        except Exception as error:
            faults.append(f"{error!r}, damage {number}:\n{content[:1000]}")
    assert not faults, "\n\n".join(faults[:3])
    assert len(messages) > 5
    assert all("\n" in each and "Errno" not in each for each in messages)  # a remedy, no jargon


@pytest.mark.parametrize("name", ["two.msh", "four.msh"])
def test_a_mesh_that_says_it_is_huge(name: str, tmp_path: Path) -> None:
    """More memory would not help, so that is not asked for."""
    text, read = FILES[name], READERS[name]
    sizes = {"two.msh": ("Nodes\n4\n", "Nodes\n{}\n"), "four.msh": ("\n1 4 1 4\n", "\n1 {} 1 4\n")}
    for count in (10**9, 10**14):
        old, new = sizes[name]
        file = written(tmp_path, name, text.replace(old, new.format(count)).encode())
        with pytest.raises(BadInput, match="cannot be read as a Gmsh mesh"):
            read(file)


def test_polygons_without_places(tmp_path: Path) -> None:
    """By RFC 7946 as good as none."""
    for empty in (
        {"type": "Polygon", "coordinates": []},
        {"type": "MultiPolygon", "coordinates": [[]]},
    ):
        file = written(tmp_path, "a.geojson", json.dumps(empty).encode())
        with pytest.raises(BadInput, match=r"file.*a\.geojson.*contains no polygons"):
            body_of(Outline(file=file, scale=1.0))


def test_a_terrain_below_its_base_in_a_section(tmp_path: Path) -> None:
    file = written(tmp_path, "h.csv", b"x,z\n0,2\n1,-1\n2,3\n")
    with pytest.raises(BadInput, match=r"shape\.base: the base is not below the surface at \(1\)"):
        body_of(terrain(file))
