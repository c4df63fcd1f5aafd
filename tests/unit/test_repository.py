# SPDX-License-Identifier: BSD-3-Clause
"""The files for those who cite, report and contribute are valid and agree with the package."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

import tilth

ROOT = Path(__file__).parents[2]


def read(file: str) -> Any:
    return yaml.safe_load((ROOT / file).read_text(encoding="utf-8"))


def test_citation_has_the_keys_that_its_format_requires() -> None:
    """Required by the Citation File Format 1.2.0: cff-version, message, title, authors."""
    citation = read("CITATION.cff")
    assert {"cff-version", "message", "title", "authors"} <= set(citation)
    assert citation["cff-version"] == "1.2.0"
    assert citation["type"] == "software"
    assert citation["authors"] == [{"name": "The tilth developers"}]
    assert citation["version"] == tilth.__version__
    assert citation["license"] == "BSD-3-Clause"
    assert all(isinstance(word, str) for word in citation["keywords"])


def test_the_hooks_are_checks_of_continuous_integration() -> None:
    (local,) = read(".pre-commit-config.yaml")["repos"]
    assert local["repo"] == "local"
    pinned = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    checks = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for hook in local["hooks"]:
        assert {"id", "name", "entry", "language"} <= set(hook)
        assert hook["language"] == "system"
        program = hook["entry"].split()[0]
        assert program in checks
        assert program == "python" or re.search(rf'"{program}==', pinned), f"{program}: not pinned"


@pytest.mark.parametrize("name", ["bug", "feature"])
def test_issue_forms_are_valid(name: str) -> None:
    form = read(f".github/ISSUE_TEMPLATE/{name}.yml")
    assert {"name", "description", "body"} <= set(form)
    identities = [field["id"] for field in form["body"]]
    assert len(set(identities)) == len(identities)
    for field in form["body"]:
        assert field["type"] in ("input", "textarea")
        assert field["attributes"]["label"]
    required = {f["id"] for f in form["body"] if f.get("validations", {}).get("required")}
    assert required >= ({"case", "version"} if name == "bug" else {"problem"})
