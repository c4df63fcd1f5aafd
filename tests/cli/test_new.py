# SPDX-License-Identifier: BSD-3-Clause
"""`tilth new` writes case files that are correct, explained, and run."""

import re
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator
from readings import long

import tilth as library
from tilth.model.json_schema import case_schema, element_schema
from tilth.templates import template, template_names

from .conftest import Outcome

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

Tilth = Callable[..., Outcome]

ANALYSES = [name for name in template_names() if "[[tests]]" not in template(name)]
every_template = pytest.mark.parametrize("name", template_names())


def test_list_names_and_describes_them(tilth: Tilth) -> None:
    outcome = tilth("new", "--list")
    lines = outcome.out.splitlines()
    assert [line.split()[0] for line in lines] == list(template_names())
    assert len(lines) >= 7
    assert all(len(line.split()) > 4 for line in lines)


def test_writes_a_file_and_never_replaces_one(
    tilth: Tilth, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    outcome = tilth("new", "footing")
    assert outcome == Outcome(0, "footing.toml written; next: tilth check footing.toml\n", "")
    assert (tmp_path / "footing.toml").read_text(encoding="utf-8") == template("footing")
    (tmp_path / "footing.toml").write_text("mine", encoding="utf-8")
    outcome = tilth("new", "footing")
    assert outcome.code == 2
    assert "exists already" in outcome.err
    assert (tmp_path / "footing.toml").read_text(encoding="utf-8") == "mine"
    assert tilth("new", "slope", "other.toml").code == 0
    assert (tmp_path / "other.toml").read_text(encoding="utf-8") == template("slope")


@pytest.mark.parametrize("arguments", [(), ("castle",), ("../footing",), ("slope", "none/x.toml")])
def test_a_mistake_is_explained(
    tilth: Tilth, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    outcome = tilth("new", *arguments)
    assert outcome.code == 2
    assert "Traceback" not in outcome.err
    assert len(outcome.err.splitlines()) == 2
    assert list(tmp_path.iterdir()) == []


@every_template
def test_a_template_is_valid_and_explained(name: str, tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(template(name), encoding="utf-8")
    if name in ANALYSES:
        assert library.load_case(file).title
    else:
        assert library.load_element_case(file).title
    schema = case_schema() if name in ANALYSES else element_schema()
    assert Draft202012Validator(schema).is_valid(tomllib.loads(template(name)))
    first = set()
    for line in template(name).splitlines():  # a key is explained where it first appears
        if (key := re.match(r"(\w+) = ", line)) and key[1] not in ("name", "title", "model"):
            explained = "#" in line or key[1] in first or key[1] in EVIDENT
            assert explained, line
            first.add(key[1])


EVIDENT = {
    "format", "length", "force", "stress", "kind", "type", "material", "body", "boundary", "shape",
    "quantity", "component", "schedule", "steps", "condition", "drainage", "panels",
}  # fmt: skip


@pytest.mark.parametrize("name", ["column", "slope"])
def test_a_template_passes_the_check(tilth: Tilth, tmp_path: Path, name: str) -> None:
    file = tmp_path / f"{name}.toml"
    assert tilth("new", name, file).code == 0
    outcome = tilth("check", file)
    assert outcome.code == 0
    assert "warning" not in outcome.err


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in ANALYSES if name not in ("column", "slope")])
def test_a_larger_template_passes_the_check(tilth: Tilth, tmp_path: Path, name: str) -> None:
    test_a_template_passes_the_check(tilth, tmp_path, name)


@pytest.mark.slow
@pytest.mark.parametrize("name", [long(name) if name == "plough" else name for name in ANALYSES])
def test_the_first_steps_run(tilth: Tilth, tmp_path: Path, name: str) -> None:
    file = tmp_path / f"{name}.toml"
    file.write_text(template(name), encoding="utf-8")
    outcome = tilth("run", file, "--until", "0.05", "--out", tmp_path / "out", "--quiet")
    assert outcome == Outcome(0, "", "")
    history = (tmp_path / "out" / "history.csv").read_text(encoding="utf-8")
    assert len(history.splitlines()) >= 3


def test_element_tests_run(tilth: Tilth, tmp_path: Path) -> None:
    file = tmp_path / "triaxial.toml"
    assert "tilth element" in tilth("new", "triaxial", file).out
    assert tilth("element", file, "--quiet") == Outcome(0, "", "")
    assert (tmp_path / "triaxial" / "drained.sand.csv").is_file()
