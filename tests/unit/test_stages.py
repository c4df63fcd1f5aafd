# SPDX-License-Identifier: BSD-3-Clause
"""Stages: what acts in each, what is refused, and what a table of factors means."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from staged_problems import KINDS, box, roller, staged_entries

from tilth import BadInput, Model, check, run
from tilth.analysis.staged import StagedAnalysis
from tilth.output import read_history, read_results, read_stages


def model_of(change: Callable[[dict[str, Any]], object] = lambda entries: None) -> Model:
    entries = staged_entries()
    change(entries)
    return Model.from_dict(entries)


def table(model: Model, stage: int, name: str) -> list[tuple[float, float]]:
    of_stage = model.of_stages[stage]
    found = [*of_stage.boundaries, *(load for _, load in of_stage.acting_loads())]
    item = next(each for each in found if each.name == name)
    return [tuple(row) for row in of_stage.load_curve(item).table]


def test_what_acts_in_each_stage() -> None:
    models = model_of().of_stages
    there = [{b.name for b in m.bodies if m.present(b.name)} for m in models]
    assert there[0] == {"ground", "pit", "bank"}
    assert there[1] == {"ground", "bank"}
    assert there[2] == there[4] == {"ground", "bank", "fill"}
    boundaries = [{b.name for b in m.boundaries} for m in models]
    assert boundaries[2] == {"base", "side", "left"}
    assert boundaries[3] == {"base", "side", "left", "plate"}
    assert boundaries[4] == {"base", "left"}
    assert [[load.name for _, load in m.acting_loads()] for m in models] == [
        ["gravity"], ["gravity"], ["gravity"], ["gravity", "footing"], ["gravity", "footing"]
    ]  # fmt: skip
    assert [m.stage.start for m in models] == [0.0, 1.0, 3.0, 4.0, 5.0]
    assert [m.cell_size[0] for m in models] == [0.5, 0.5, 0.5, 0.5, 0.25]


def test_factors_grow_stay_and_decrease() -> None:
    model = model_of()
    assert table(model, 0, "gravity") == [(0.0, 0.0), (1.0, 1.0)]
    assert table(model, 1, "gravity") == [(0.0, 1.0)]
    assert table(model, 3, "footing") == [(0.0, 0.0), (1.0, 1.0)]
    assert table(model, 4, "footing") == [(0.0, 1.0), (1.0, 0.0)]


def test_tables_run_in_the_time_of_the_stage_and_are_held() -> None:
    def change(entries: dict[str, Any]) -> None:
        entries["stages"][1]["factors"] = {"gravity": [[0.0, 1.0], [2.0, 0.5]]}

    model = model_of(change)
    assert table(model, 1, "gravity") == [(0.0, 1.0), (2.0, 0.5)]
    assert table(model, 2, "gravity") == [(0.0, 0.5)]


def test_a_motion_goes_on_from_where_it_was() -> None:
    def change(entries: dict[str, Any]) -> None:
        entries["stages"].append(
            {"name": "deeper", "schedule": {"steps": 1}, "factors": {"plate": [[0, 1], [1, 2]]}}
        )
        entries["stages"][4]["deactivate"] = ["side"]

    assert table(model_of(change), 4, "plate") == [(0.0, 1.0)]
    assert table(model_of(change), 5, "plate") == [(0.0, 1.0), (1.0, 2.0)]


def test_the_model_is_stored_without_loss() -> None:
    model = model_of()
    again = Model.from_dict(model.to_dict())
    assert again == model
    assert len(model.of_stages) == 5
    assert again == model, "what was computed from a model does not count"
    one = next(iter(model.of_stages))
    assert one.of_stages == (one,)
    assert "schedule" not in model.to_dict()


def set_in(stage: int, **entries: Any) -> Callable[[dict[str, Any]], object]:
    return lambda whole: whole["stages"][stage].update(entries)


REGION = {"type": "box", "lower": [0.0, 0.0], "upper": [1.0, 1.0]}


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        (set_in(1, activate=["banc"]), "stages[1].activate", "did you mean `bank`?"),
        (set_in(4, activate=["fill"]), "stages[4].activate", "'fill' is already there"),
        (set_in(2, deactivate=["pit"]), "stages[2].deactivate", "'pit' is not there before"),
        (set_in(4, activate=["plate"], deactivate=["side"]), "stages[4].activate", "acts already"),
        (set_in(1, activate=["pit"]), "stages[1].deactivate", "`activate` and in `deactivate`"),
        (set_in(1, activate="fill"), "stages[1].activate", 'such as ["fill"]'),
        (set_in(1, activate=["fill", "fill"]), "stages[1].activate", "names an entry twice"),
        (set_in(1, name="weight"), "stages[1].name", "already the name of stages[0]"),
        (set_in(1, name="a/b"), "stages[1].name", "a character that a stage's name cannot have"),
        (set_in(1, name="x" * 61), "stages[1].name", "longer than 60"),
        (set_in(1, factors={"gravty": [[0, 1], [1, 1]]}), "stages[1].factors", "mean `gravity`?"),
        (set_in(1, factors={"side": [[0, 1], [1, 1]]}), "stages[1].factors", "does not move"),
        (
            set_in(1, factors={"footing": [[0, 1], [1, 1]]}),
            "stages[1].factors",
            "does not act in this",
        ),
        (set_in(1, factors={"gravity": [[0, 1], [9, 1]]}), "stages[1].factors", "ends after"),
        (set_in(1, materials={"soil": "frim"}), "stages[1].materials", "mean `firm`?"),
        (set_in(1, release=[[0, 0], [1, 0.5]]), "stages[1].release", "ends with the share 0.5"),
        (set_in(1, release=[[0, 0], [3, 1]]), "stages[1].release", "ends after the stage"),
        (set_in(0, release=[[0, 0], [1, 1]]), "stages[0].release", "in the first stage"),
        (set_in(1, excavate=[{"body": "b", "shape": REGION}]), "stages[1].excavate[0].body", "no"),
        (
            set_in(3, excavate=[{"body": "fill", "shape": REGION}]),
            "stages[3].excavate[0].body",
            "has a tracked surface, which cannot be cut",
        ),
        (
            set_in(3, excavate=[{"body": "pit", "shape": REGION}]),
            "stages[3].excavate[0].body",
            "'pit' is not there before",
        ),
        (
            set_in(1, excavate=[{"body": "bank", "shape": {**REGION, "lower": [0, 0, 0]}}]),
            "stages[1].excavate[0].shape",
            "",
        ),
        (set_in(1, deactivate=["ground", "pit", "bank"]), "stages[1]", "no body is left"),
        (set_in(1, deactivate=["base"]), "stages[1]", "no condition constrains the y direction"),
        (set_in(4, deactivate=["side", "left", "plate"]), "stages[4]", "constrains the x"),
        (
            lambda e: (
                e["stages"][4].update(materials={"spare": "soil"})
                or e["materials"].update(spare=e["materials"]["firm"])
            ),
            "stages[4].materials",
            "no body consists of 'spare'",
        ),
        (
            lambda e: [each.update(materials={"soil": "firm"}) for each in e["stages"][1:3]],
            "stages[2].materials",
            "no body consists of 'soil' before this stage",
        ),
        (set_in(2, activate=["footing"]), "stages[2]", "acts on the body 'fill', which is not"),
        (
            set_in(4, factors={"plate": [[0, 0], [1, 1]]}, deactivate=["side"]),
            "stages[4].factors",
            "begins with the factor 0, but the last stage ended with 1",
        ),
        (
            set_in(1, water={"level": 1, "unit_weight": 10, "initial_level": 0}),
            "stages[1].water.initial_level",
            "has no meaning in a stage",
        ),
        (lambda e: e.update(schedule={"steps": 1}), "schedule", "given together with `stages`"),
        (lambda e: e.update(stages=[]), "schedule", "missing"),
        (lambda e: e["stages"][1].pop("schedule"), "stages[1].schedule", "missing"),
        (set_in(1, type="stage"), "stages[1].type", "choose from"),
    ],
)
def test_wrong_stages(change: Callable[[dict[str, Any]], object], key: str, words: str) -> None:
    if words.startswith("acts on the body"):  # the fill comes one stage later then
        before = change

        def change(entries: dict[str, Any]) -> None:
            before(entries)
            entries["stages"][3]["activate"] = ["plate", "fill"]

    with pytest.raises(BadInput) as caught:
        model_of(change)
    problem = next(p for p in caught.value.problems if p.key.startswith(key))
    assert words in f"{problem.problem} {problem.remedy}"


def refused_at_the_start_of(change: Callable[[dict[str, Any]], object]) -> BadInput:
    with pytest.raises(BadInput) as caught:
        StagedAnalysis(model_of(change)).check()
    return caught.value


def test_soil_is_not_placed_in_soil() -> None:
    error = refused_at_the_start_of(lambda e: e["stages"][1].pop("deactivate"))
    assert error.problems[0].key == "stages[2].activate"
    assert "would be placed inside soil that is there already" in error.problems[0].problem


def test_a_region_without_soil_is_refused() -> None:
    empty = {"type": "box", "lower": [0.0, 5.0], "upper": [1.0, 6.0]}
    error = refused_at_the_start_of(set_in(1, excavate=[{"body": "bank", "shape": empty}]))
    assert error.problems[0].key == "stages[1].excavate[0].shape"
    assert "no soil of 'bank' is in this region" in error.problems[0].problem


def test_a_material_that_cannot_have_the_stress_is_refused() -> None:
    clay = {
        "model": "modified_cam_clay", "compression_index": 0.2, "swelling_index": 0.05,
        "critical_state_slope": 1.2, "shear_modulus": 400.0, "preconsolidation_pressure": 150.0,
        "density": 1.0,
    }  # fmt: skip

    def change(entries: dict[str, Any]) -> None:
        entries["materials"]["clay"] = clay
        entries["stages"][2]["materials"] = {"soil": "clay"}
        entries["stages"][3].pop("materials")

    error = refused_at_the_start_of(change)
    assert error.problems[0].key == "stages[2].materials"
    assert "cannot have the stress of the soil at" in error.problems[0].problem


def test_a_stage_without_any_support_is_refused() -> None:
    """An implicit boundary constrains what touches it, which only the analysis knows."""

    def change(entries: dict[str, Any]) -> None:
        far = {"type": "plane", "point": [0.0, -5.0], "normal": [0.0, 1.0]}
        wall = {"name": "far", "type": "implicit", "condition": "fixed", "geometry": far}
        entries["boundaries"].append(wall)
        entries["stages"][1]["deactivate"] += ["base", "left", "side"]
        entries["stages"][4]["deactivate"].remove("side")

    error = refused_at_the_start_of(change)
    assert "(at the start of the stage 'dig')" in str(error)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_history_and_results_run_through(kind: str, tmp_path: Path) -> None:
    """The base carries the weight that is there, with the forces of walls and loads."""
    model = Model.from_dict(staged_entries(kind))
    run(model, tmp_path / "out", quiet=True)
    history = read_history(tmp_path / "out" / "history.csv")
    area = {"plane_strain": 1.0, "3d": 0.5, "axisymmetric": 3.14159265358979}[kind]
    ground, pit = {"axisymmetric": (9.0, 1.0)}.get(kind, (3.0, 1.0))
    unit = "N" if kind != "plane_strain" else "N/m"
    base = history[f"base [{unit}]"]
    full, dug = 20.0 * ground * area, (20.0 * ground - 5.0 * pit) * area
    assert base[[2, 4, 6, 10]] == pytest.approx([full, dug, full, full], rel=1e-8)
    assert (history[f"side [{unit}]"][-2:] == 0.0).all()
    assert (history["stage_time"][[2, 3, 4, 5]] == [1.0, 1.0, 2.0, 0.5]).all()
    stages = read_stages(tmp_path / "out" / "history.csv")
    assert stages[1] == ("dig", 1.0, 3.0)
    assert [name for name, _, _ in stages] == [stage.name for stage in model.stages]
    results = read_results(tmp_path / "out" / "results.vtkhdf")
    count = {state.step: len(state.position) for state in results}
    there = {state.step: set(state.body_id.tolist()) for state in results}
    assert count[4] < count[2] == count[6]
    assert there[4] == {0, 2}
    assert there[10] == {0, 2, 3}
    for state in results:
        assert len(state.surfaces) == 1
        assert (len(state.surfaces[0].position) > 0) == (3 in there[state.step])


def test_one_stage_gives_what_a_schedule_gives(tmp_path: Path) -> None:
    """The only stage of an analysis has the same bits as the analysis without stages."""
    entries: dict[str, Any] = {
        **staged_entries(),
        "bodies": [box("ground", [0.0, 0.0], [3.0, 1.5], 2)],
        "boundaries": [roller("y", 0.0, "base"), roller("x", 0.0)],
        "loads": [{"type": "body_force", "acceleration": [0.0, -10.0]}],
        "track": [],
    }
    entries["stages"] = [{"name": "weight", "schedule": {"steps": 3}}]
    one = run(Model.from_dict(entries), tmp_path / "one", quiet=True)
    del entries["stages"]
    other = run(Model.from_dict({**entries, "schedule": {"steps": 3}}), tmp_path / "b", quiet=True)
    assert (one.points.stress == other.points.stress).all()
    assert (one.points.position == other.points.position).all()


def test_a_grid_that_is_too_fine_for_the_points_is_named_as_the_cause() -> None:
    error = refused_at_the_start_of(set_in(1, grid={"cell_size": 0.05}))
    assert "stage 'dig', whose grid has cells smaller than the distance" in str(error)


def test_a_load_that_jumps_between_stages_is_warned_of() -> None:
    def change(entries: dict[str, Any]) -> None:
        entries["stages"][1]["factors"] = {"gravity": [[0.0, 0.5], [2.0, 1.0]]}

    warnings = [text for text in check(model_of(change)).warnings if "begins with" in text]
    assert len(warnings) == 1
    assert warnings[0].startswith(
        "stages[1].factors: in the stage 'dig': the load 'gravity' begins"
    )
    assert not [text for text in check(model_of()).warnings if "begins with" in text]
