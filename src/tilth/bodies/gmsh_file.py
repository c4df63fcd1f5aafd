# SPDX-License-Identifier: BSD-3-Clause
"""Gmsh files: their elements, and the physical groups that these belong to."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.errors import BadInput

# Nodes in a plane: the largest difference of their z, relative to the extent.
FLATNESS_TOLERANCE = 1e-9


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
    if not file.is_file():
        raise refused("there is no such file", "check the name and the folder")
    try:
        return meshio.gmsh.read(file)
    except (
        meshio.ReadError,
        OSError,
        ValueError,
        KeyError,
        IndexError,
        EOFError,
        AssertionError,
    ) as error:
        reason = str(error) or "it is not in that format, or not complete"
        problem, remedy = (
            f"cannot be read as a Gmsh mesh: {reason}",
            "save it from Gmsh as a .msh file",
        )
        if "gmsh:physical" in reason:  # format 4.1, saved with all elements
            problem = "cannot be read: some of its elements are in a physical group, others in none"
            remedy = "save it without Mesh.SaveAll, or in format 2.2 (Mesh.MshFileVersion)"
        raise refused(problem, remedy) from error


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
