# SPDX-License-Identifier: BSD-3-Clause
"""Pages of the manual cite only names, files and values that the code has."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from cited_names import PAGES, ROOT, unknown, wrong_values

each_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))


@each_page
def test_names_and_files_that_a_page_cites_are_there(page: Path) -> None:
    history = page.parent == ROOT / "docs" / "decisions"
    assert unknown(page.read_text(encoding="utf-8"), history) == []


@each_page
def test_constants_have_the_values_that_a_page_gives(page: Path) -> None:
    assert wrong_values(page.read_text(encoding="utf-8")) == []


UNUSUAL = re.compile(r"\b(?:(?:takes?|taking|took) part\b(?! of)|owing to\b|rooms? above\b)")
"""Phrases for which the glossary or plain English has a word: "active", "counts", "because of"."""


def test_pages_and_program_keep_to_the_words_of_the_glossary() -> None:
    files = [*PAGES, *(ROOT / "src").glob("**/*.py")]
    found = {file: UNUSUAL.findall(" ".join(file.read_text("utf-8").split())) for file in files}
    assert {file: words for file, words in found.items() if words} == {}


def test_an_unusual_phrase_is_found() -> None:
    for text in ("points that take part, f", "soil takes part in it", "owing to this"):
        assert UNUSUAL.search(text)
    assert not UNUSUAL.search("the fluid carries part of it; laws take part of the pressure")


MADE_UP = {
    "a function": "`update_nothing`",
    "a method": "`Simulation._holders`",
    "a method of another class": "`Model.owners`",
    "a class": "`StepPlanner`",
    "a call": "`open_sesame()`",
    "an argument of a call": "`Grid(cell_height=1.0)`",
    "a constant": "`LARGEST_NOTHING`",
    "a key": "`cell_height = 0.5`",
    "a key of another table": "`output.cell_size`",
    "a section": "`[[rigid_bodys]]`",
    "a public name": "`tilth.open_all`",
    "a path": "`src/tilth/step_planner.py`",
    "a file": "`step_planner.hpp`",
    "a file in a command": "`python benchmarks/nothing.py`",
    "a test": "`test_nothing_at_all`",
}


@pytest.mark.parametrize("text", MADE_UP.values(), ids=MADE_UP)
def test_made_up_names_are_found(text: str) -> None:
    assert unknown(f"# A page\n\nSoil moves by {text}.\n")


def test_of_history_only_files_are_looked_at() -> None:
    page = "`update_nothing` of `src/tilth/step_planner.py`"
    assert unknown(page, history=True) == [
        "`src/tilth/step_planner.py`: no file src/tilth/step_planner.py"
    ]


REAL = """
# A page

## 1. A file to write: `cpp/tilth/material/own_law.hpp`

`Simulation.advance`, `Model`, `tilth.open("run")`, `grid.cell_size`, `cell_size = 0.5`,
`[[rigid_bodies]]`, `cauchy_stress_xx`, `surface_NAME`, `history.csv`, `src/tilth/cli.py`,
`cli.py`, `python benchmarks/kernels.py --long`, `cpp/tilth/material/own_law.hpp`, `own_name`,
`test_of_history_only_files_are_looked_at`, `x + 2 y_unknown`

```python
own_name = 1.0
```
"""


def test_real_names_and_those_of_the_page_are_known() -> None:
    assert unknown(REAL) == []


def test_another_value_of_a_constant_is_found() -> None:
    assert wrong_values("restarted every `RESTART` = 100 iterations.") == []
    assert wrong_values("restarted every `RESTART` = 40 iterations.") == [
        "`RESTART` = 40: in the code [100.0]"
    ]
    assert wrong_values("up to `LARGEST_NOTHING` = 1.") == [
        "`LARGEST_NOTHING` = 1: in the code None"
    ]
