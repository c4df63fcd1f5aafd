# SPDX-License-Identifier: BSD-3-Clause
"""Declared contact between soil bodies, its overlays, and what a wrong one is told."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

from tilth import BadInput, ContactPair, Model
from tilth.analysis.contact_output import contact_names
from tilth.analysis.contact_warnings import contact_warnings
from tilth.analysis.motions import motion_columns
from tilth.analysis.simulation import Simulation
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.report.contact_texts import pair_text
from tilth.solvers import linear_solver

LAW = {"normal": "unilateral", "tangential": "friction", "friction": 0.3}
ELASTIC = {"model": "hencky_elastic", "young_modulus": 1e3, "poisson_ratio": 0.3}
CLAY = {
    "model": "tresca", "young_modulus": 1e3, "poisson_ratio": 0.3, "undrained_shear_strength": 5.0
}  # fmt: skip


def body(name: str, x: float, y: float, **more: Any) -> dict[str, Any]:
    """A block 2 wide and high."""
    box = {"type": "box", "lower": [x, y], "upper": [x + 2.0, y + 2.0]}
    return {
        "name": name, "material": "m", "basis": "gimp", "points_per_cell": 2, "shape": box,
        "surface": {}, **more,
    }  # fmt: skip


def pair(one: str = "block", other: str = "ground", **more: Any) -> dict[str, Any]:
    return {"name": f"{one} on {other}", "bodies": [one, other], "contact": LAW, **more}


def entries(*pairs: dict[str, Any], **changed: Any) -> dict[str, Any]:
    return {
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": 1.0},
        "materials": {"m": ELASTIC},
        "bodies": [body("block", 0.0, 2.0), body("ground", 0.0, 0.0)],
        "boundaries": [
            {"name": "base", "type": "plane", "axis": "y", "at": 0.0, "condition": "fixed"}
        ],
        "contact_pairs": list(pairs) or [pair()],
        "schedule": {"steps": 1},
        **changed,
    }


def refusal(given: dict[str, Any]) -> str:
    with pytest.raises(BadInput) as error:
        Model.from_dict(copy.deepcopy(given))
    return str(error.value)


def test_a_pair_is_taken_and_stored_without_loss() -> None:
    model = Model.from_dict(entries(pair(wished_in_place=True)))
    assert Model.from_dict(model.to_dict()) == model
    (found,) = model.contact_pairs
    assert found == ContactPair(
        name="block on ground", bodies=("block", "ground"), contact=found.contact,
        wished_in_place=True,
    )  # fmt: skip
    assert model.acting_pairs == [("contact_pairs[0]", found)]
    without = entries(contact_pairs=[])
    assert Model.from_dict(without).contact_pairs == ()


@pytest.mark.parametrize(
    ("changed", "key", "problem", "remedy"),
    [
        ({"bodies": ["block", "block"]}, "bodies", "the same body twice", "with itself"),
        ({"bodies": ["block"]}, "bodies", "names one body", 'bodies = ["block", "ground"]'),
        ({"bodies": []}, "bodies", "names no body", "name two soil bodies"),
        ({"bodies": ["a", "b", "c"]}, "bodies", "names 3 bodies", "name two soil bodies"),
        ({"bodies": "block"}, "bodies", "must be a list of two names", "name two soil bodies"),
        ({"bodies": ["block", "grond"]}, "bodies", "no body of this name", "`ground`?"),
        ({"name": "base"}, "name", "already the name of boundaries[0]", "different name"),
        ({"contact": {**LAW, "friction": -0.1}}, "contact.friction", "negative", "tangent"),
        ({"contact": {"normal": "unilateral", "tangential": "rough"}}, "contact.tangential",
         "no shear strength", "shear_limit"),
        ({"contact": None}, "contact", "must be a table", ""),
        ({"wished": True}, "wished", "unknown key", "wished_in_place"),
    ],
)  # fmt: skip
def test_a_wrong_pair(changed: dict[str, Any], key: str, problem: str, remedy: str) -> None:
    """One message with key, problem and remedy."""
    text = refusal(entries(pair() | changed))
    assert text.startswith(f"contact_pairs[0].{key}")
    assert problem in text
    assert remedy in text
    assert "entries are wrong" not in text


def test_the_first_body_needs_a_surface_on_its_edge() -> None:
    without = entries(pair("ground", "block"))
    del without["bodies"][1]["surface"]
    text = refusal(without)
    assert "contact_pairs[0].bodies" in text
    assert "'ground', has no tracked surface" in text
    assert "add `surface = {}` to bodies[1]" in text
    inside = entries()
    inside["bodies"][0]["surface"] = {"points": "outer_layer"}
    text = refusal(inside)
    assert "half their spacing inside" in text
    assert '`points = "extra"` in bodies[0].surface' in text
    del inside["bodies"][0]["surface"]
    inside["contact_pairs"] = [pair("ground", "block")]
    Model.from_dict(inside)


def test_two_bodies_have_one_contact() -> None:
    text = refusal(entries(pair(), pair("ground", "block")))
    assert "contact_pairs[1].bodies" in text
    assert "already the two bodies of contact_pairs[0]" in text


def test_strength_is_asked_of_both_bodies() -> None:
    rough = {"normal": "unilateral", "tangential": "rough"}
    given = entries(pair(contact=rough), materials={"m": CLAY, "e": ELASTIC})
    Model.from_dict(given)
    given["bodies"][1]["material"] = "e"
    assert "'e' (hencky_elastic) has no shear strength" in refusal(given)


# --- overlays -----------------------------------------------------------------------------------


def chain(*pairs: tuple[str, str], bodies: str = "abcd") -> dict[str, Any]:
    """Bodies one above the other, the first at the bottom, at a distance of two cells."""
    return entries(
        *(pair(*each) for each in pairs),
        bodies=[body(name, 0.0, 4.0 * i) for i, name in enumerate(bodies)],
    )


def test_paired_bodies_have_different_overlays() -> None:
    """Each the smallest number that is left, in the order of the case file."""
    assert Model.from_dict(chain(("a", "b"))).overlays() == {"a": 0, "b": 1, "c": 0, "d": 0}
    assert Model.from_dict(chain(("b", "a"), ("b", "c"))).overlays() == {
        "a": 0, "b": 1, "c": 0, "d": 0
    }  # fmt: skip
    every = [("a", "b"), ("a", "c"), ("a", "d"), ("b", "c"), ("b", "d"), ("c", "d")]
    assert Model.from_dict(chain(*every)).overlays() == {"a": 0, "b": 1, "c": 2, "d": 3}
    assert set(Model.from_dict(entries(contact_pairs=[])).overlays().values()) == {0}


def test_at_most_seven_overlays() -> None:
    def every(names: str) -> dict[str, Any]:
        return chain(*((a, b) for i, b in enumerate(names) for a in names[:i]), bodies=names)

    assert max(Model.from_dict(every("abcdefg")).overlays().values()) == 6
    text = refusal(every("abcdefgh"))
    assert "'h' and the bodies paired with it need 8 overlays" in text


def test_bodies_that_would_pass_through_each_other() -> None:
    """Those of different fields that begin near each other need a pair."""

    def refused(given: dict[str, Any]) -> str:
        with pytest.raises(BadInput) as error:
            initial_points(Model.from_dict(given))
        return str(error.value)

    given = entries(bodies=[body("block", 0.0, 2.0), body("ground", 0.0, 0.0), body("c", 2.5, 0.0)])
    text = refused(given)
    assert "'ground' and 'c' begin nearer to each other than a cell" in text
    assert "they are 0.5 of a cell apart" in text
    assert 'bodies = ["ground", "c"]' in text
    initial_points(Model.from_dict({**given, "contact_pairs": [pair(), pair("ground", "c")]}))
    given["bodies"][2] = body("c", 3.0, 0.0)
    initial_points(Model.from_dict(given))
    # bodies that stick together come first
    ground, block, c = (
        body(n, x, y) for n, x, y in (("ground", 0, 0), ("block", 0, 2), ("c", 2, 0))
    )
    both = pair(), pair("block", "c")
    again = Model.from_dict(entries(*both, bodies=[ground, c, block]))
    assert again.overlays() == {"ground": 0, "c": 0, "block": 1}
    initial_points(again)


@pytest.mark.parametrize(("start", "near"), [(3.0, False), (2.0, False), (1.8, True)])
def test_bodies_in_the_bounds_of_another_are_apart(start: float, near: bool) -> None:
    """A bar two cells from the limbs of a U around it, as a strut from the ground behind a wall."""
    limbs = [[0, 0], [9, 0], [9, 5], [8, 5], [8, 1], [1, 1], [1, 5], [0, 5]]
    u = {**body("u", 0.0, 0.0), "shape": {"type": "polygon", "vertices": limbs}}
    bar = body("bar", 0.0, 0.0)
    bar["shape"] = {"type": "box", "lower": [start, 3.0], "upper": [6.0, 4.0]}
    given = entries(pair("lid", "u"), bodies=[body("lid", 3.0, 8.0), u, bar])
    found = Model.from_dict(given)
    assert found.overlays()["u"] != found.overlays()["bar"]
    if near:
        with pytest.raises(BadInput, match="'u' and 'bar' begin nearer to each other than a cell"):
            initial_points(found)
    else:
        initial_points(found)


def test_bodies_that_pass_through_each_other_are_warned_of(monkeypatch: pytest.MonkeyPatch) -> None:
    """A body that falls onto one without a pair."""
    given = entries(
        bodies=[body("block", 0.0, 6.0), body("ground", 0.0, 0.0), body("c", 0.0, 3.0)],
        boundaries=[
            {"name": "base", "type": "plane", "axis": "y", "at": 0.0, "condition": "fixed"},
        ],
    )
    simulation = Simulation(Model.from_dict(given))

    def lowered(by: float) -> MaterialPoints:
        points = simulation.state.points
        points.position[points.of_body("c"), 1] -= by
        return points

    for by, count in ((0.0, 0), (0.9, 0), (1.0, 1), (0.0, 1)):
        simulation.services.warnings.unpaired(
            simulation.setup.model, lowered(by), simulation.state.grid
        )
        assert len(simulation.services.warnings.texts) == count
    assert "'ground' and 'c' have come into the same cells" in simulation.services.warnings.texts[0]
    assert 'bodies = ["ground", "c"]' in simulation.services.warnings.texts[0]


# --- stages --------------------------------------------------------------------------------------


def staged(*stages: dict[str, Any]) -> dict[str, Any]:
    given = entries()
    del given["schedule"]
    given["stages"] = [
        {"name": f"stage {i}", "schedule": {"steps": 1}, **stage} for i, stage in enumerate(stages)
    ]
    return given


def test_a_pair_acts_while_both_bodies_are_there() -> None:
    model = Model.from_dict(staged({}, {"activate": ["block"]}, {"deactivate": ["block"]}))
    assert [len(each.acting_pairs) for each in model.of_stages] == [0, 1, 0]
    assert [each.overlays() for each in model.of_stages] == [{"block": 0, "ground": 1}] * 3


def test_a_pair_is_not_activated() -> None:
    text = refusal(staged({}, {"activate": ["block on ground"]}))
    assert "is a contact pair, which acts while both its bodies are there" in text


def test_bodies_that_are_never_there_together_need_no_pair() -> None:
    for going, fits in (("block", False), ("ground", True)):
        given = staged({}, {"deactivate": [going], "activate": ["c"]})
        given["bodies"].append(body("c", 2.5, 0.0))
        model = Model.from_dict(given)
        assert model.overlays() == {"block": 0, "ground": 1, "c": 0}
        if fits:
            initial_points(model.of_stages[0])
        else:
            with pytest.raises(BadInput, match="begin nearer"):
                initial_points(model.of_stages[0])


# --- results --------------------------------------------------------------------------------------


def test_tracked_quantities_of_pairs() -> None:
    def tracked(**keys: Any) -> dict[str, Any]:
        return entries(track=[{"name": "t", "boundary": "block on ground", **keys}])

    for keys in (
        {"quantity": "reaction", "component": "y"},
        {"quantity": "contact_area"},
        {"quantity": "moment", "component": "z", "about": [0, 0]},
    ):
        Model.from_dict(tracked(**keys))
    text = refusal(tracked(quantity="moment", component="z"))
    assert text.startswith("track[0].about: missing")
    for keys in (
        {"quantity": "penetration"},
        {"quantity": "embedment", "from": "original"},
        {"quantity": "rigid_displacement", "component": "x"},
    ):
        text = refusal(tracked(**keys))
        assert f'quantity = "{keys["quantity"]}" is not for contact pairs' in text
        assert '"reaction", "moment", "contact_area"' in text


def test_pairs_in_the_outputs() -> None:
    law = {"normal": "unilateral", "tangential": "friction", "friction": 30.0}
    model = Model.from_dict(entries(pair(contact=law, wished_in_place=True)))
    assert contact_names(model) == ["block on ground"]
    assert [name for name, _ in motion_columns(model)] == [
        f"block on ground {each}" for each in ("force_x", "force_y", "contact_area")
    ]
    ((_, text),) = contact_warnings(model)
    assert text.startswith("contact_pairs[0].contact.friction = 30")
    text = pair_text(model.contact_pairs[0], "Pa")
    assert text == (
        "block on ground: between block and ground; opens under tension, friction 30; wished in "
        "place"
    )


# --- multigrid -----------------------------------------------------------------------------------


def test_multigrid_solves_contact_in_space() -> None:
    """The nodes on both sides of the contact are solved directly: few iterations, no fall-back."""
    boxes = {"block": ([0.5, 0.5, 1.1], [1.5, 1.5, 2.1]), "ground": ([0, 0, 0], [2, 2, 1.1])}
    given = entries(
        analysis={"kind": "3d", "solver": "superlu"},
        grid={"cell_size": 0.25},
        materials={"m": {**ELASTIC, "density": 1.0}},
        bodies=[
            body(name, 0.0, 0.0) | {"shape": {"type": "box", "lower": low, "upper": high}}
            for name, (low, high) in boxes.items()
        ],
        boundaries=[
            {"name": "base", "type": "plane", "axis": "z", "at": 0.0, "condition": "fixed"}
        ],
        loads=[{"type": "body_force", "acceleration": [0.0, 0.0, -10.0]}],
    )
    model, found, reasons = Model.from_dict(given), [], []
    for solver in ("superlu", "multigrid"):
        simulation = Simulation(model)
        simulation.services.solver = linear_solver(
            solver, 3, len(simulation.state.points), reasons.append
        )
        result = simulation.advance(0.0, 1.0)
        found.append(simulation.state.points.displacement)
        assert result.resultant("block on ground")[2] == pytest.approx(-10.0, rel=1e-6)
    assert reasons == []
    assert 0 < max(simulation.services.solver.iterations, default=0) <= 15
    assert np.abs(found[1] - found[0]).max() < 1e-7 * np.abs(found[0]).max()


@pytest.mark.parametrize("basis", ["linear", "gimp", "cpdi2"])
@pytest.mark.parametrize(("bottom", "top"), [(0.0, 1.0), (0.2, 0.9), (0.3, 2.6)])
def test_bodies_touch_however_thin_they_are(basis: str, bottom: float, top: float) -> None:
    """The block lies on a bed as thin as a cell, or thinner, with the whole of its underside."""
    bed = body("ground", 0.0, 0.0, basis=basis)
    bed["shape"] = {"type": "box", "lower": [-1.0, bottom], "upper": [3.0, top]}
    block = body("block", 0.0, top, basis=basis)
    model = Model.from_dict(entries(pair(wished_in_place=True), bodies=[block, bed]))
    (contact,) = Simulation(model).prepare(0.0, 1.0).constraints.contacts
    assert np.isclose(contact.pose.weight.sum(), 2.0)
    assert np.allclose(contact.pose.normal, [0.0, -1.0])
