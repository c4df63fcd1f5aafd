# SPDX-License-Identifier: BSD-3-Clause
"""Case files of the examples, and variations of their models."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tilth import _core
from tilth.case import load_case
from tilth.model import Model

BASES = tuple(_core.basis_names())
"""Names of all bases."""


def folder_of_cases() -> Path:
    """Returns the folder with one folder of case files for each example.

    In an installed tilth it is in the package, where CMakeLists.txt installs the case files; in a
    source tree it is `examples`.
    """
    installed = Path(__file__).with_name("case_files")
    return installed if installed.is_dir() else Path(__file__).parents[2] / "examples"


def example(problem: str, file: str = "case.toml") -> Model:
    """Returns the model of a case file of an example."""
    return load_case(folder_of_cases() / problem / file)


def varied(model: Model, changes: Mapping[str, Any]) -> Model:
    """Returns the model with other values at dotted keys, such as `bodies.0.points_per_cell`.

    The value None removes the key.
    """
    entries = model.to_dict()
    for key, value in changes.items():
        *path, last = key.split(".")
        table: Any = entries
        for name in path:
            table = table[int(name) if isinstance(table, list) else name]
        if value is None:
            table.pop(last, None)
        else:
            table[int(last) if isinstance(table, list) else last] = value
    return Model.from_dict(entries)


def with_basis(model: Model, basis: str) -> Model:
    """Returns the model with another basis of its first body, with the default domain rule."""
    return varied(model, {"bodies.0.basis": basis, "bodies.0.domain_update": None})
