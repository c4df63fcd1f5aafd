# SPDX-License-Identifier: BSD-3-Clause
"""Gmsh files: their elements, and the physical groups that these belong to."""

from __future__ import annotations

import importlib
import io
import struct
from codecs import BOM_UTF8
from collections.abc import Callable
from contextlib import redirect_stderr
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.errors import BadInput
from tilth.input_files import asks_too_much, why_failed, why_no_file
from tilth.memory_errors import is_memory_error

# Nodes in a plane: the largest difference of their z, relative to the extent.
FLATNESS_TOLERANCE = 1e-9
NODES = {"vertex": 1, "line": 2, "triangle": 3, "quad": 4, "tetra": 4, "hexahedron": 8}
"""Of an element, by its type in meshio."""


def read_gmsh(file: Path, refused: Callable[[str, str], BadInput]) -> Any:
    """Returns the mesh in a Gmsh file, as meshio has it.

    refused: makes the error to raise of a problem and its remedy; it names the file.
    Raises BadInput for a file that is missing or cannot be read, and if meshio is missing.
    """
    try:
        meshio = importlib.import_module("meshio")
    except ModuleNotFoundError as error:
        raise refused(
            "a mesh needs the package meshio, which is not installed",
            "install it with `pip install meshio`",
        ) from error
    if reason := why_no_file(file):
        raise refused(reason, "check the name and the folder")
    try:
        _require_possible(file)
        with file.open("rb") as opened:
            if opened.read(len(BOM_UTF8)) != BOM_UTF8:  # an editor's; meshio does not know it
                opened.seek(0)
            with redirect_stderr(io.StringIO()):  # its warnings: what is wrong is refused here
                mesh = meshio.gmsh.main.read_buffer(opened)
        if not np.isfinite(mesh.points).all():
            raise ValueError("a node has a coordinate that is no finite number")
        if not mesh.cells or not all(map(_is_whole, mesh.cells)):
            raise ValueError("elements are missing, or nodes of them")
    except Exception as error:  # meshio raises all kinds for what is no mesh
        reason = why_failed(error)
        if is_memory_error(error):
            if not asks_too_much(error, file):
                raise
            reason = "it says that it has more nodes or elements than it can have"
        problem, remedy = (
            f"cannot be read as a Gmsh mesh: {reason}",
            "save it from Gmsh as a .msh file",
        )
        if "gmsh:physical" in reason:  # format 4.1, saved with all elements
            problem = "cannot be read: some of its elements are in a physical group, others in none"
            remedy = "save it without Mesh.SaveAll, or in format 2.2 (Mesh.MshFileVersion)"
        raise refused(problem, remedy) from error
    unknown = _without_node(file) or any((np.asarray(c.data) < 0).any() for c in mesh.cells)
    if unknown:
        which = unknown if isinstance(unknown, str) else "an element"
        problem = f"{which} has a node that the file does not have"
        raise refused(problem, "number nodes from 1 and list each in the file, or save it again")
    return mesh


def _without_node(file: Path) -> str:
    """Returns which element of a text file has a node with the number 0, "" for none.

    Such a number is none of a node, but meshio takes the last node for it.
    """
    with file.open("rb") as stream:
        start = stream.read(64).removeprefix(BOM_UTF8).split()
    if start[:1] != [b"$MeshFormat"] or len(start) < 3 or start[2] != b"0":
        return ""  # binary
    text = file.read_text(encoding="utf-8", errors="replace")
    lines = iter(text.partition("$Elements")[2].partition("$EndElements")[0].split("\n")[1:])
    old = float(start[1]) < 4.0
    next(lines, "")  # how many there are
    left = 0
    for line in lines:
        entry = line.split()
        if not old and left == 0:
            left = int(entry[3]) if len(entry) == 4 else 0
            continue
        left -= 1
        nodes = entry[3 + int(entry[2]) :] if old and len(entry) > 3 else entry[1:]
        if "0" in nodes:
            return f"element {entry[0]}"
    return ""


def _require_possible(file: Path) -> None:
    """Raises ValueError if a file says that it has more nodes or elements than bytes.

    meshio makes room for them before it reads them, which takes all memory and a minute.
    """
    content = file.read_bytes()
    words = content[:64].split()
    is_binary_4 = len(words) > 2 and words[1].startswith(b"4") and words[2] == b"1"
    for marker in (b"$Nodes", b"$Elements"):
        start = content.find(marker)
        if start < 0:
            continue
        start = content.find(b"\n", start) + 1
        if is_binary_4:
            counts = list(struct.unpack("=2Q", content[start : start + 16]))
        else:
            line = content[start : start + 200].partition(b"\n")[0]
            counts = [int(word) for word in line.split()[:2]]
        if max(counts, default=0) > len(content):
            what = marker.decode().strip("$").lower()
            raise ValueError(f"it says that it has {max(counts)} {what}, more than it can have")


def _is_whole(block: Any) -> bool:
    """Returns whether elements of one type are there, with all their nodes."""
    nodes = NODES.get(block.type, block.data.shape[-1])
    return bool(block.data.size) and block.data.shape[1:] == (nodes,)


def group_names(mesh: Any, dimension: int) -> dict[int, str]:
    """Returns the names of the physical groups of this dimension by tag; no name is the tag."""
    named = {
        int(tag): str(name) for name, (tag, dim) in mesh.field_data.items() if dim == dimension
    }
    tags = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *group_tags(mesh)]))
    return {int(tag): str(tag) for tag in tags if tag != 0} | named


def group_tags(mesh: Any) -> list[npt.NDArray[np.int64]]:
    """Returns the tags of the elements' physical groups, 0 for none, for each block of the file."""
    found = mesh.cell_data.get("gmsh:physical")
    if found is None:
        return [np.zeros(len(c.data), dtype=np.int64) for c in mesh.cells]
    return [np.asarray(tags, dtype=np.int64) for tags in found]
