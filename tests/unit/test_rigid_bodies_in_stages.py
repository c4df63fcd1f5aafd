# SPDX-License-Identifier: BSD-3-Clause
"""Rigid bodies in stages: when they are there, and how their motions and forces go on."""

from __future__ import annotations

from typing import Any

import pytest
from implicit_entries import CIRCLE, boundary, entries, refused

from tilth import Model

SMOOTH = {"normal": "unilateral", "tangential": "smooth"}
PIPE = {
    "name": "pipe", "geometry": CIRCLE, "contact": SMOOTH, "centre": [0, 1], "rotation": 0,
    "displacement": {"x": [[0, 0], [1, 3], [2, 5]], "y": -0.25},
}  # fmt: skip
ANCHOR = {
    "name": "anchor", "geometry": {**CIRCLE, "centre": [3, 1]}, "contact": SMOOTH,
    "centre": [3, 1], "force": {"y": 10}, "rotation": 0, "displacement": {"x": 0},
}  # fmt: skip


def stage(name: str, end: float = 1.0, **changed: Any) -> dict[str, Any]:
    return {"name": name, "schedule": {"steps": 2, "end": end}, **changed}


def staged(*stages: dict[str, Any], bodies: tuple[dict[str, Any], ...] = (PIPE, ANCHOR)) -> Any:
    given = entries(boundary(), rigid_bodies=[*bodies], stages=[*stages])
    del given["schedule"]
    return given


def test_a_rigid_body_comes_and_goes() -> None:
    model = Model.from_dict(
        staged(
            stage("gravity"), stage("press", activate=["pipe"]), stage("rest"),
            stage("pull", activate=["anchor"], deactivate=["pipe"]),
        )
    )  # fmt: skip
    there = [[body.name for body in each.rigid_bodies] for each in model.of_stages]
    assert there == [[], ["pipe"], ["pipe"], ["anchor"]]
    last = model.of_stages[3]
    assert last.rigid_body_keys()["anchor"] == "rigid_bodies[1]"
    assert [key for key, _ in last.geometries()] == [
        "boundaries[0].geometry", "rigid_bodies[1].geometry",
    ]  # fmt: skip
    assert Model.from_dict(model.to_dict()) == model


def test_motions_and_forces_go_on_from_where_they_were() -> None:
    model = Model.from_dict(
        staged(
            stage("press", 2.0), stage("hold"),
            stage("pull", factors={"pipe": [[0, 1], [1, 3]]},
                  force_factors={"anchor": [[0, 1], [1, -1]]}),
        )
    )  # fmt: skip
    press, hold, pull = model.of_stages
    pipe, anchor = press.rigid_bodies
    assert [pipe.prescribed("y", t, 2.0) for t in (0, 1, 2)] == [0, -0.125, -0.25]
    assert [pipe.prescribed("x", t, 2.0) for t in (0, 1, 2)] == [0, 3, 5]
    assert [anchor.applied("y", t, 2.0) for t in (0, 1, 2)] == [0, 5, 10]
    pipe, anchor = hold.rigid_bodies
    assert [pipe.prescribed("y", t, 1.0) for t in (0, 1)] == [-0.25, -0.25]
    assert [pipe.prescribed("x", t, 1.0) for t in (0, 0.5, 1)] == [5, 5, 5]
    assert [anchor.applied("y", t, 1.0) for t in (0, 1)] == [10, 10]
    pipe, anchor = pull.rigid_bodies
    assert [pipe.prescribed("y", t, 1.0) for t in (0, 0.5, 1)] == [-0.25, -0.5, -0.75]
    assert pipe.prescribed("x", 1.0, 1.0) == 5
    assert [anchor.applied("y", t, 1.0) for t in (0, 0.5, 1)] == [10, 0, -10]
    assert not pull.stage.jumps


def test_a_table_longer_than_its_stage_is_cut_off() -> None:
    press, hold = Model.from_dict(staged(stage("press", 1.0), stage("hold"))).of_stages
    assert press.rigid_bodies[0].prescribed("x", 1.0, 1.0) == 3
    assert hold.rigid_bodies[0].prescribed("x", 1.0, 1.0) == 3


def test_a_force_that_jumps_is_known() -> None:
    model = Model.from_dict(
        staged(stage("press"), stage("pull", force_factors={"anchor": [[0, 0], [1, 2]]}))
    )
    assert model.of_stages[1].stage.jumps == (("anchor", 1.0, 0.0),)


@pytest.mark.parametrize(
    ("stages", "key", "words"),
    [
        ([stage("a", activate=["pip"])], "stages[0].activate", "did you mean `pipe`?"),
        ([stage("a"), stage("b", deactivate=["pipe"]), stage("c", activate=["pipe"])],
         "stages[2].activate", "cannot come back"),
        ([stage("a"), stage("b", factors={"pipe": [[0, 0], [1, 1]]})], "stages[1].factors",
         "cannot jump"),
        ([stage("a"), stage("b", factors={"pipe": [[0, 1], [2, 1]]})], "stages[1].factors",
         "the stage ends at 1"),
        ([stage("a", force_factors={"pipe": [[0, 0], [1, 1]]})], "stages[0].force_factors",
         "no number in `force` or `moment`"),
        ([stage("a", force_factors={"ancor": [[0, 0], [1, 1]]})], "stages[0].force_factors",
         "did you mean `anchor`?"),
        ([stage("a", force_factors={"anchor": [[0, 0], [2, 1]]})], "stages[0].force_factors",
         "ends after the stage"),
        ([stage("a", deactivate=[]), stage("b", activate=["anchor"]),
          stage("c", deactivate=["anchor"], force_factors={"anchor": [[0, 0], [1, 1]]})],
         "stages[2].force_factors", "does not act in this stage"),
    ],
)  # fmt: skip
def test_wrong_stages_of_rigid_bodies(stages: Any, key: str, words: str) -> None:
    error = refused(staged(*stages))
    assert error.key == key
    assert words in str(error)


def test_a_body_moved_by_tables_alone_has_nothing_to_scale() -> None:
    towed = {**PIPE, "displacement": {"x": [[0, 0], [1, 3]], "y": [[0, 0], [1, 0]]},
             "rotation": [[0, 0], [1, 0]]}  # fmt: skip
    error = refused(staged(stage("a", factors={"pipe": [[0, 0], [1, 1]]}), bodies=(towed,)))
    assert error.key == "stages[0].factors"
    assert "`force_factors`" in str(error)
