# SPDX-License-Identifier: BSD-3-Clause
"""The public names of the package load when they are first used."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import tilth
import tilth.model
from tilth.model.base import Declared
from tilth.model.geometry import GEOMETRIES
from tilth.model.shapes import SHAPES


def names_for_type_checkers() -> set[str]:
    """What a type checker finds in the package, which does not run it."""
    tree = ast.parse(Path(tilth.__file__).read_text(encoding="utf-8"))
    block = next(
        node
        for node in tree.body
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
    )
    found: set[str] = set()
    for node in block.body:
        assert isinstance(node, ast.ImportFrom)
        if node.names[0].name == "*":
            assert node.module == "tilth.model"
            imported = ast.parse(Path(tilth.model.__file__).read_text(encoding="utf-8")).body[1:]
            for line in imported:
                assert isinstance(line, ast.ImportFrom)
                assert all(name.asname == name.name for name in line.names)
                found |= {name.name for name in line.names}
        else:
            assert all(name.asname == name.name for name in node.names)
            found |= {name.name for name in node.names}
    return found


def test_every_public_name_is_there() -> None:
    pytest.importorskip("tilth._core")
    for name in tilth.__all__:
        assert getattr(tilth, name).__name__ == name
    assert set(tilth.__all__) <= set(dir(tilth))
    imported: dict[str, object] = {}
    exec("from tilth import *", imported)
    assert set(tilth.__all__) <= set(imported)


def test_type_checkers_see_the_same_names() -> None:
    assert set(tilth.__all__) == names_for_type_checkers()


def test_all_that_can_be_declared_is_public() -> None:
    for cls in (*SHAPES, *GEOMETRIES):
        assert getattr(tilth, cls.__name__) is cls
    declarations = set(tilth.__all__) - set(tilth._HOME)
    assert all(issubclass(getattr(tilth, name), Declared) for name in declarations)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Modle'"):
        _ = tilth.Modle


def test_the_package_loads_nothing_before_it_is_used() -> None:
    program = "import sys, tilth; hasattr(tilth, '__x__'); print('tilth.model' in sys.modules)"
    process = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert process.stdout == "False\n"
