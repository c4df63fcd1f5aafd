# SPDX-License-Identifier: BSD-3-Clause
"""What the user names and labels: refused where it could harm, otherwise taken as it is."""

import copy
from typing import Any

import pytest
from small_problems import block_entries, rollers

from tilth import Box, Model, Schedule, Track
from tilth.errors import BadInput, visible
from tilth.model.texts import LONGEST_NAME, LONGEST_TITLE, LONGEST_UNIT, MOST_MARKS

HARMFUL = {
    "change of direction": "a\N{RIGHT-TO-LEFT OVERRIDE}b",
    "isolate": "a\N{FIRST STRONG ISOLATE}b",
    "mark of direction": "a\N{LEFT-TO-RIGHT MARK}b",
    "no width": "a\N{ZERO WIDTH SPACE}b",
    "escape": "\x1b[31mred",
    "line break": "a\nfinished: b",
    "line separator": "a\N{LINE SEPARATOR}b",
    "next line": "a\x85b",
    "tab": "a\tb",
    "null": "a\0b",
    "half of a surrogate pair": "a\ud800b",
    "no character": "a\uffffb",
    "pile of accents": "a" + (MOST_MARKS + 1) * "\N{COMBINING ACUTE ACCENT}",
    "very long": 10_000 * "a",
}
STRANGE = [
    "$x_1^$",
    "_hidden",
    "[red]",
    "[/]",
    ":bug:",
    "<b>&amp;",
    "\N{GRINNING FACE}",
    "%s\\",
    "é",
]
PLACES: list[tuple[str | int, ...]] = [
    ("title",),
    ("units", "length"),
    ("bodies", 0, "name"),
    ("bodies", 0, "material"),
    ("boundaries", 0, "name"),
    ("track", 0, "name"),
    ("track", 0, "unit"),
    ("materials",),
]


def entries_with(place: tuple[str | int, ...], text: str) -> dict[str, Any]:
    """A valid model with `text` at one place."""
    track = {"name": "top", "quantity": "top_height", "of": "points"}
    entries: dict[str, Any] = block_entries(
        "plane_strain", "gimp", boundaries=rollers("plane_strain")
    )
    entries |= {"track": [track], "units": {}, "title": ""}
    if place == ("materials",):
        entries["materials"] = {text: entries["materials"]["soil"]}
        entries["bodies"][0]["material"] = text
        return entries
    target: Any = entries
    for part in place[:-1]:
        target = target[part]
    target[place[-1]] = text
    if place[-1] == "material":
        entries["materials"] = {text: entries["materials"]["soil"]}
    return entries


@pytest.mark.parametrize("place", PLACES, ids=str)
@pytest.mark.parametrize("text", HARMFUL.values(), ids=HARMFUL)
def test_a_text_that_could_harm_is_refused_and_shown_harmlessly(
    place: tuple[str | int, ...], text: str
) -> None:
    with pytest.raises(BadInput) as caught:
        Model.from_dict(entries_with(place, text))
    said = str(caught.value)
    assert str(place[-1]) in said
    assert said.replace("\n", "").isprintable()
    assert "finished" not in said.splitlines()
    said.encode()


@pytest.mark.parametrize("place", PLACES, ids=str)
@pytest.mark.parametrize("text", STRANGE)
def test_a_strange_but_honest_text_is_kept(place: tuple[str | int, ...], text: str) -> None:
    model = Model.from_dict(entries_with(place, text))
    assert Model.from_dict(copy.deepcopy(model.to_dict())) == model
    assert text in str(model.to_dict()) or text in str(model)


@pytest.mark.parametrize(
    "start", ["=1+1", "+1", "-1", "@x", "\N{FULLWIDTH EQUALS SIGN}1", ' "=1', "a;=1"]
)
def test_a_table_cannot_have_a_cell_that_a_spreadsheet_computes(start: str) -> None:
    for place in (("bodies", 0, "name"), ("track", 0, "name")):
        with pytest.raises(BadInput, match="take it for a formula") as caught:
            Model.from_dict(entries_with(place, start))
        assert "letter or a digit" in str(caught.value)
    for place in (("track", 0, "unit"), ("units", "length")):
        with pytest.raises(BadInput, match="formula"):
            Model.from_dict(entries_with(place, "m;=1"))
        Model.from_dict(entries_with(place, "-"))
    with pytest.raises(BadInput, match="formula"):
        Model.from_dict(entries_with(("boundaries", 0, "name"), "+x side"))


def test_the_longest_texts() -> None:
    for place, longest in ((("title",), LONGEST_TITLE), (("units", "mass"), LONGEST_UNIT)):
        Model.from_dict(entries_with(place, longest * "a"))
        with pytest.raises(BadInput, match=f"at most {longest}"):
            Model.from_dict(entries_with(place, (longest + 1) * "a"))
    Model.from_dict(entries_with(("boundaries", 0, "name"), LONGEST_NAME * "a"))


def test_the_message_names_the_character() -> None:
    with pytest.raises(BadInput) as caught:
        Track(name="top\N{ZERO WIDTH SPACE}", quantity="top_height", of="points")
    assert "character 4 (U+200B, zero width space)" in str(caught.value)
    assert 'Track.name = "top\\u200b"' in str(caught.value)


def test_unknown_keys_are_shown_harmlessly() -> None:
    with pytest.raises(BadInput, match="unknown key") as caught:
        Model.from_dict(entries_with(("title",), "") | {"a\n\x1b[2Jb\ud800": 1})
    assert "a\\n\\x1b[2Jb\\ud800" in str(caught.value)


def test_what_is_shown_is_printable() -> None:
    assert visible("a b\n é \N{GRINNING FACE}") == "a b\n é \N{GRINNING FACE}"
    assert visible("\x1b[31m\N{RIGHT-TO-LEFT OVERRIDE}\ud800\t'") == "\\x1b[31m\\u202e\\ud800\\t'"


def test_a_frozen_declaration_says_how_to_make_a_changed_copy() -> None:
    schedule = Schedule(steps=3)
    with pytest.raises(BadInput, match=r"Schedule\.steps = 4: .*frozen") as caught:
        schedule.steps = 4  # type: ignore[misc]
    assert "schedule.model_copy(update={'steps': ...})" in str(caught.value)
    assert schedule.steps == 3


def test_a_changed_copy_is_validated() -> None:
    schedule = Schedule(steps=3, output_times=[0.5])
    assert schedule.model_copy() == schedule
    changed = schedule.model_copy(update={"steps": 4})
    assert (changed.steps, changed.output_times) == (4, (0.5,))
    for wrong in ({"steps": 0}, {"stepz": 1}, {"step_size": 0.1}, {"end": 0.4}):
        with pytest.raises(BadInput):
            schedule.model_copy(update=wrong)
    model = Model.from_dict(entries_with(("title",), ""))
    assert model.model_copy(update={"schedule": changed}).schedule.steps == 4
    box = Box(lower=[0, 0], upper=[1, 1])
    body = model.bodies[0].model_copy(update={"shape": box, "material": "rock"})
    with pytest.raises(BadInput, match="no material of this name"):
        model.model_copy(update={"bodies": [body]})
