# SPDX-License-Identifier: BSD-3-Clause
"""Results of water that flows: fields, tracked quantities, energies, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from resumed_runs import assert_same_results
from small_problems import plane, rollers

import tilth
from tilth import BadInput, Model, resume, run
from tilth.analysis.setup_picture import setup_of
from tilth.arrays import Floats
from tilth.mpm.initial_points import initial_points
from tilth.output import read_history, read_results
from tilth.report.fields import field_unit
from tilth.report.setup import draw_setup
from tilth.report.setup_data import Setup
from tilth.report.setup_page import setup_view
from tilth.report.stage_setups import StagedSetup
from tilth.report.water_line import WATER_COLOUR
from tilth.results.run_results import RunResults

LOAD, HEIGHT, GAMMA, CONDUCTIVITY, END = 10.0, 3.0, 10.0, 1e-4, 40.0
HISTORY, RESULTS = "history.csv", "results.vtkhdf"


def track(quantity: str, height: float, **more: Any) -> dict[str, Any]:
    """A quantity that is tracked above the base, named after itself."""
    name = quantity + more.get("kind", "")
    return {"name": name, "quantity": quantity, "at": [0.75, height], **more}


def clay(**changed: Any) -> dict[str, Any]:
    """A material through which water flows."""
    return {
        "model": "hencky_elastic", "young_modulus": 5e3, "poisson_ratio": 0.3, "porosity": 0.5,
        "hydraulic_conductivity": CONDUCTIVITY, **changed,
    }  # fmt: skip


def column(steps: int = 4, ramp_to: float | None = None, **changed: Any) -> dict[str, Any]:
    """A column of clay, drained at its base and loaded at its top, as a dictionary."""
    end = ramp_to or END
    table = [[0.0, 0.0], [end, 1.0]] if ramp_to else [[0.0, 1.0], [end, 1.0]]
    entries: dict[str, Any] = {
        "units": {"length": "m", "force": "kN", "stress": "kPa", "mass": "t", "time": "day"},
        "analysis": {"kind": "plane_strain", "solver": "superlu"},
        "grid": {"cell_size": 1.0},
        "flow": {
            "unit_weight": GAMMA,
            "boundaries": [
                {"name": "drain", "type": "plane", "axis": "y", "at": 0.0, "condition": "drained"}
            ],
        },
        "materials": {"clay": clay()},
        "bodies": [
            {
                "name": "column",
                "material": "clay",
                "shape": {"type": "box", "lower": [0.0, 0.0], "upper": [1.0, HEIGHT]},
                "basis": "gimp",
                "points_per_cell": 2,
                "surface": {},
            }
        ],
        "boundaries": [*rollers("plane_strain", sides=False), plane("right", "x", 1.0)],
        "loads": [
            {
                "type": "surface", "name": "fill", "body": "column", "start": [1.0, HEIGHT],
                "end": [0.0, HEIGHT], "pressure": LOAD, "factor": table,
            }
        ],
        "schedule": {"end": end, "steps": steps},
        "output": {"report": False},
        "track": [
            track("excess_pore_pressure", 2.75),
            track("pore_pressure", 2.75),
            track("stress", 2.75, component="yy"),
            track("effective_stress", 2.75, component="yy"),
            track("displacement", 0.25, component="y"),
        ],
    }  # fmt: skip
    return {**entries, **changed}


def layered(**upper: Any) -> dict[str, Any]:
    """The column with another material in its upper third."""
    entries = column()
    entries["materials"]["other"] = {"model": "hencky_elastic", "young_modulus": 5e3,
                                     "poisson_ratio": 0.3, **upper}  # fmt: skip
    body = entries["bodies"][0]
    del body["material"]
    body["layers"] = [{"material": "other", "bottom": 2.0}, {"material": "clay"}]
    return entries


@pytest.fixture(scope="module")
def consolidated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The column under water at rest, which stands 1 m above it."""
    folder = tmp_path_factory.mktemp("column") / "out"
    entries = column(water={"level": HEIGHT + 1.0, "unit_weight": GAMMA})
    run(Model.from_dict(entries), folder, quiet=True)
    return folder


def fields(folder: Path, output: int = -1) -> tuple[Floats, dict[str, Floats]]:
    found = read_results(folder / RESULTS).snapshot(output)
    return found.position, {name: np.asarray(found.point_fields[name]) for name in (
        "excess_pore_pressure", "pore_pressure", "cauchy_stress", "effective_stress",
        "darcy_velocity",
    )}  # fmt: skip


def test_the_total_stress_is_the_effective_one_less_the_pore_pressure(consolidated: Path) -> None:
    place, found = fields(consolidated)
    at_rest = GAMMA * (HEIGHT + 1.0 - place[:, 1])
    np.testing.assert_allclose(
        found["pore_pressure"], at_rest + found["excess_pore_pressure"], rtol=1e-12
    )
    between = found["effective_stress"] - found["cauchy_stress"]
    np.testing.assert_allclose(
        between[:, :3], np.tile(found["pore_pressure"][:, None], 3), atol=1e-10
    )
    assert not between[:, 3:].any()
    mean = found["effective_stress"][:, 1].mean() - found["excess_pore_pressure"].mean()
    buoyant = -GAMMA * 0.5 * HEIGHT  # of soil without weight: the water lifts it
    assert mean == pytest.approx(-LOAD - buoyant, rel=1e-3)
    assert fields(consolidated, 0)[1]["excess_pore_pressure"].tolist() == [0.0] * len(place)


def test_tracked_quantities_are_those_of_the_fields(consolidated: Path) -> None:
    place, found = fields(consolidated)
    history = read_history(consolidated / HISTORY)
    number = int(np.linalg.norm(place - [0.75, 2.75], axis=1).argmin())
    for name in ("excess_pore_pressure", "pore_pressure"):
        assert history[f"{name} [kPa]"][-1] == found[name][number]
    assert history["stress [kPa]"][-1] == found["cauchy_stress"][number, 1]
    assert history["effective_stress [kPa]"][-1] == found["effective_stress"][number, 1]
    assert abs(found["excess_pore_pressure"][number]) > 0.5
    assert history["excess_pore_pressure [kPa]"][0] == 0.0
    assert history["pore_pressure [kPa]"][0] == pytest.approx(12.5)


def test_the_velocity_of_steady_flow_is_that_of_darcy(tmp_path: Path) -> None:
    """Between two pressures; per area of soil, and out of the column where there is none."""
    entries = column(steps=2, loads=[], schedule={"end": 1e5, "steps": 2})
    ends: list[dict[str, Any]] = [{"at": 0.0, "condition": "pressure", "excess_pressure": 6.0},
                                  {"at": HEIGHT, "condition": "drained"}]  # fmt: skip
    entries["flow"]["boundaries"] = [
        {"name": f"end {k}", "type": "plane", "axis": "y", **end} for k, end in enumerate(ends)
    ]
    entries["bodies"][0]["basis"] = "linear"
    del entries["bodies"][0]["surface"]
    result = run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    _, found = fields(result.folder)
    expected = CONDUCTIVITY / GAMMA * 6.0 / HEIGHT
    np.testing.assert_allclose(found["darcy_velocity"][:, 1], expected, rtol=1e-3)
    np.testing.assert_allclose(found["darcy_velocity"][:, 0], 0.0, atol=1e-9 * expected)
    assert not fields(result.folder, 0)[1]["darcy_velocity"].any()
    assert RunResults(result.folder).field("darcy_velocity_y").shape == (len(result.points),)
    assert field_unit("darcy_velocity", {"length": "m", "time": "day"}) == "m/day"
    assert field_unit("darcy_velocity", {"length": "m", "time": ""}) == "-"
    assert field_unit("hydraulic_conductivity", {"length": "m", "time": "day"}) == "m/day"
    assert field_unit("hydraulic_conductivity", {"length": "", "time": ""}) == "length / time"


def test_soil_that_lets_no_water_in_has_no_excess_pressure(tmp_path: Path) -> None:
    """Its pore pressure is that at rest, none here, and its total stress the effective one."""
    result = run(Model.from_dict(layered()), tmp_path / "out", quiet=True)
    place, found = fields(result.folder)
    upper = place[:, 1] > 2.0 - 0.1
    assert np.isnan(found["excess_pore_pressure"]).tolist() == upper.tolist()
    assert np.isnan(found["darcy_velocity"]).all(axis=1).tolist() == upper.tolist()
    assert not found["pore_pressure"][upper].any()
    np.testing.assert_array_equal(found["cauchy_stress"][upper], found["effective_stress"][upper])
    assert np.isnan(read_history(result.folder / HISTORY)["excess_pore_pressure [kPa]"]).all()


def test_undrained_soil_beside_soil_in_which_water_flows(tmp_path: Path) -> None:
    """Its excess pressure is the law's own, in addition to the pore pressure."""
    entries = layered(pore_fluid_bulk_modulus=1e5)
    entries["track"].append(track("state", 2.75, variable="excess_pore_pressure"))
    result = run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    place, found = fields(result.folder)
    upper = place[:, 1] > 2.0 - 0.1
    excess = found["excess_pore_pressure"]
    assert excess[~upper].max() > 2.0
    assert not found["pore_pressure"][upper].any()
    np.testing.assert_array_equal(found["pore_pressure"][~upper], excess[~upper])
    between = (found["effective_stress"] - found["cauchy_stress"])[:, 1]
    np.testing.assert_allclose(between, excess, rtol=1e-2)  # above of Kirchhoff's stress
    history = read_history(result.folder / HISTORY)
    assert history["excess_pore_pressure [kPa]"][-1] == history["state [kPa]"][-1] > 0.5


def test_a_run_begins_with_the_effective_stress_of_one_with_flow(consolidated: Path) -> None:
    """Also of an undrained law, whose excess pressure begins at zero."""
    for law in ({}, {"pore_fluid_bulk_modulus": 1e5}):
        entries = column()
        entries["materials"]["clay"] = {"model": "hencky_elastic", "young_modulus": 5e3,
                                        "poisson_ratio": 0.3, **law}  # fmt: skip
        del entries["flow"]
        entries["track"] = []
        folder = str(consolidated)
        entries["initial"] = {"stress": [{"type": "run", "body": "column", "folder": folder}]}
        points = initial_points(Model.from_dict(entries))
        place, found = fields(consolidated)
        nearest = np.linalg.norm(points.position[:, None] - place, axis=2).argmin(axis=1)
        np.testing.assert_allclose(points.stress, found["effective_stress"][nearest], atol=0.1)
        if law:
            assert not points.state_variable("excess_pore_pressure").any()


def test_work_is_stored_or_dissipated_by_the_flow(tmp_path: Path) -> None:
    """Of a load that grows; what the steps take by backward Euler goes with their size."""
    lost = []
    for steps in (8, 16):
        entries = column(steps, ramp_to=5.0 * END)
        entries["track"] = [
            {"name": kind, "quantity": "energy", "kind": kind}
            for kind in ("external_work", "elastic", "seepage")
        ]
        folder = tmp_path / f"{steps}"
        run(Model.from_dict(entries), folder, quiet=True)
        history = read_history(folder / HISTORY)
        work, elastic, seepage = (each for name, each in history.items() if "kN" in name)
        assert (np.diff(seepage) > 0.0).all()
        lost.append((work - elastic - seepage)[-1] / work[-1])
    assert seepage[-1] > 0.2 * work[-1]
    assert abs(lost[1]) < 0.01
    assert lost[0] / lost[1] == pytest.approx(2.0, rel=0.1)


@pytest.mark.slow
def test_a_resumed_run_has_the_same_bits(tmp_path: Path) -> None:
    entries = column()
    entries["track"].append({"name": "lost", "quantity": "energy", "kind": "seepage"})
    model = Model.from_dict(entries)
    run(model, tmp_path / "whole", quiet=True)
    run(model, tmp_path / "parts", until=0.5 * END, quiet=True)
    resume(tmp_path / "parts", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "parts")


def test_the_report_is_coloured_by_the_excess_pressure(tmp_path: Path) -> None:
    """Also where a part of the soil has none."""
    output = {"colour_by": "excess_pore_pressure"}
    result = run(Model.from_dict(layered() | {"output": output}), tmp_path / "out", quiet=True)
    page = (result.folder / "report.html").read_text()
    assert "Excess pore pressure [kPa]" in page
    assert "Darcy velocity y [m/day]" in page


@pytest.mark.parametrize(
    ("colour", "known"), [("excess_pore_pressure", True), ("pore_pressure", True),
                          ("darcy_velocity_y", True), ("effective_stress_mean", True),
                          ("darcy_velocity_z", True), ("excess_pore_presure", False)],
)  # fmt: skip
def test_fields_that_colour(colour: str, known: bool) -> None:
    entries = column(output={"colour_by": colour})
    if known:
        tilth.check(Model.from_dict(entries))
        return
    with pytest.raises(BadInput, match='did you mean "excess_pore_pressure"'):
        tilth.check(Model.from_dict(entries))


def test_without_flow_there_is_nothing_of_it() -> None:
    entries = column()
    del entries["flow"]
    entries["materials"]["clay"] = clay(hydraulic_conductivity=None, porosity=None)
    entries["materials"]["clay"] = {
        key: value for key, value in entries["materials"]["clay"].items() if value is not None
    }
    for quantity, words in (
        (track("excess_pore_pressure", 1.0), "no water flows"),
        (track("pore_pressure", 1.0), "there is no water"),
        ({"name": "lost", "quantity": "energy", "kind": "seepage"}, "no water flows"),
    ):
        with pytest.raises(BadInput, match=words):
            Model.from_dict(entries | {"track": [quantity]})
    with pytest.raises(BadInput, match="no field of this name"):
        tilth.check(Model.from_dict(entries | {"track": [], "output": {
            "colour_by": "darcy_velocity"}}))  # fmt: skip


def test_the_setup_shows_the_flow_boundaries() -> None:
    """Places on planes and geometries; those of tracked surfaces in the legend alone."""
    entries = column()
    circle = {"type": "circle", "centre": [0.5, 1.5], "radius": 0.3, "soil": "outside"}
    entries["flow"]["boundaries"] += [
        {"name": "well", "type": "implicit", "condition": "pressure", "excess_pressure": -3.0,
         "geometry": circle},
        {"name": "rain", "type": "surface", "body": "column", "condition": "flux", "flux": 1e-4,
         "start": [1.0, HEIGHT], "end": [0.0, HEIGHT]},
    ]  # fmt: skip
    setup = setup_of(Model.from_dict(entries))
    assert isinstance(setup, Setup)
    drain, well, rain = (each for each in setup.conditions if each.is_of_flow)
    assert drain.position.tolist() == [[0.0, 0.0], [1.0, 0.0]]
    distance = np.linalg.norm(well.position - [0.5, 1.5], axis=1)
    assert len(well.position) > 3
    np.testing.assert_allclose(distance, 0.3, atol=0.05)
    assert len(rain.position) == 0
    figure = draw_setup(setup)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    for label in (
        "drain\ndrained",
        "well\nexcess pore pressure given",
        "rain\nflux of water given",
    ):
        assert label in labels
    keys = setup_view(setup).keys
    assert ("\N{MULTIPLICATION SIGN}", WATER_COLOUR, "drain\ndrained") in keys


def test_a_stage_without_flow_shows_none() -> None:
    entries = column()
    schedule = entries.pop("schedule")
    entries["stages"] = [
        {"name": "fill", "schedule": schedule, "flow": False},
        {"name": "wait", "schedule": schedule},
    ]
    staged = setup_of(Model.from_dict(entries))
    assert isinstance(staged, StagedSetup)
    found = [[c.name for c in each.setup.conditions if c.is_of_flow] for each in staged.stages]
    assert found == [[], ["drain"]]
