# SPDX-License-Identifier: BSD-3-Clause
"""`tilth schema` prints or writes the schema that the library returns."""

import json
from collections.abc import Callable
from pathlib import Path

from tilth.model.json_schema import case_schema, element_schema

from .conftest import Outcome

Tilth = Callable[..., Outcome]


def test_prints_the_schema(tilth: Tilth) -> None:
    assert json.loads(tilth("schema").out) == case_schema()
    assert json.loads(tilth("schema", "--element").out) == element_schema()


def test_writes_and_replaces_a_file(tilth: Tilth, tmp_path: Path) -> None:
    file = tmp_path / "tilth.schema.json"
    for _ in range(2):
        assert tilth("schema", "--out", file) == Outcome(0, f"schema written to {file}\n", "")
        assert json.loads(file.read_text(encoding="utf-8")) == case_schema()


def test_a_file_that_cannot_be_written_is_wrong_input(tilth: Tilth, tmp_path: Path) -> None:
    outcome = tilth("schema", "--out", tmp_path / "none" / "x.json")
    assert outcome.code == 2
    assert "cannot be written" in outcome.err
