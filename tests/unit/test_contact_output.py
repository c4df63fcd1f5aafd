# SPDX-License-Identifier: BSD-3-Clause
"""Contact and rigid bodies in results, contact.csv, tracked quantities and pictures."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contact_shapes import PRESSURE, RADIUS, SHEAR, ball, lower_half, with_contact
from report_setups import UNITS, snapshot
from result_snapshots import assert_same, make_snapshot, opened_by_vtk
from small_problems import block_entries, rollers

from tilth import BadInput, Model, resume, run
from tilth.analysis.energies import Energies
from tilth.analysis.rigid_shapes import rigid_shapes
from tilth.analysis.simulation import Simulation
from tilth.analysis.tracker import Tracker
from tilth.boundaries.contact.state import RigidBodyState
from tilth.output import (
    ContactShape,
    ResultsWriter,
    read_contacts,
    read_history,
    read_results,
    write_contacts,
)
from tilth.report.contact_plots import along_surface, contact_chart, contact_view
from tilth.report.field_plots import draw_frames
from tilth.terms.outcome import ContactState

BALL = {
    "name": "ball", "geometry": {"type": "circle", "centre": [1.0, 2.5], "radius": 0.5,
                                 "soil": "outside"},
    "contact": {"normal": "unilateral", "tangential": "smooth"}, "centre": [1.0, 2.5],
    "displacement": {"x": 0.0, "y": -0.2}, "rotation": 0.0,
}  # fmt: skip


def contact_equal(one: ContactShape, other: ContactShape) -> None:
    np.testing.assert_array_equal(one.position, other.position, strict=True)
    assert one.fields.keys() == other.fields.keys()
    for name in one.fields:
        np.testing.assert_array_equal(one.fields[name], other.fields[name], strict=True)


@pytest.mark.parametrize("dim", [2, 3])
def test_results_give_back_contact_and_bodies(dim: int, tmp_path: Path) -> None:
    path = tmp_path / "results.vtkhdf"
    states = [with_contact(make_snapshot(step, dim, surfaces=True)) for step in range(4)]
    empty = ContactShape.empty("ball", dim)
    states[0] = replace(states[0], contacts=(empty,))
    writer = ResultsWriter(path, units=UNITS)
    for state in states:
        writer.append(state)
    writer.close()
    ResultsWriter.resume(path, 2).close()
    results = read_results(path)
    assert results.names["contacts"] == results.names["rigid_bodies"] == ("ball",)
    assert results.steps == [0, 1, 2]
    for state, read in zip(states, results, strict=False):
        assert_same(state, read)
        contact_equal(state.contacts[0], read.contacts[0])
        np.testing.assert_array_equal(state.rigid_bodies[0].position, read.rigid_bodies[0].position)
        np.testing.assert_array_equal(state.rigid_bodies[0].cells, read.rigid_bodies[0].cells)


def test_vtk_reads_the_blocks(tmp_path: Path) -> None:
    path = tmp_path / "results.vtkhdf"
    writer = ResultsWriter(path, units=UNITS)
    for step in range(2):
        writer.append(with_contact(make_snapshot(step)))
    writer.close()
    reader = opened_by_vtk(path, information_first=False)
    output = reader.GetOutputDataObject(0)
    names = [output.GetMetaData(i).Get(output.NAME()) for i in range(4)]
    assert names == ["points", "grid", "contact_ball", "rigid_ball"]
    contact = output.GetPartition(2, 0)
    assert contact.GetNumberOfPoints() == contact.GetNumberOfCells() == 60
    fields = {contact.GetPointData().GetArrayName(i) for i in range(7)}
    assert {"normal_stress", "shear_stress", "gap", "in_contact"} <= fields


def test_table_has_every_point_and_its_state(tmp_path: Path) -> None:
    state = with_contact(snapshot())
    write_contacts(tmp_path / "contact.csv", state, {**UNITS, "area": "m^2/m"})
    table = read_contacts(tmp_path / "contact.csv")
    assert list(table) == [
        "step", "time", "boundary", "x [m]", "y [m]", "normal_x", "normal_y", "area [m^2/m]",
        "normal_stress [kPa]", "shear_x [kPa]", "shear_y [kPa]", "gap [m]", "state",
    ]  # fmt: skip
    (shape,) = state.contacts
    np.testing.assert_array_equal(table["y [m]"], shape.position[:, 1])
    np.testing.assert_array_equal(table["normal_stress [kPa]"], shape.fields["normal_stress"])
    np.testing.assert_array_equal(table["shear_x [kPa]"], shape.fields["shear_stress"][:, 0])
    depth = -shape.fields["normal"][:, 1]
    expected = np.where(depth <= 0.2, "open", np.where(depth < 0.6, "slip", "stick"))
    np.testing.assert_array_equal(table["state"], expected)
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    with pytest.raises(BadInput, match=r"not the contact\.csv"):
        read_contacts(tmp_path / "other.csv")


def test_body_is_turned_about_its_centre_then_moved() -> None:
    shape = ball(2).at(np.array([0.3, -0.1]), np.array([0.0, 0.0, 0.7]))
    np.testing.assert_allclose(np.linalg.norm(shape.position - [0.3, -0.1], axis=1), RADIUS)
    (line,) = shape.polylines
    assert line[0] == line[-1]
    x, y = shape.position[line].T
    assert 0.5 * float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum()) < -3.0  # the soil on the left


def test_the_outline_of_a_box_is_one_chain() -> None:
    """Its facets come side by side, in any order."""
    box = {"name": "box", "geometry": {"type": "box", "lower": [0.0, 2.0], "upper": [2.0, 3.0],
                                       "soil": "outside"},
           "contact": BALL["contact"], "centre": [1.0, 2.5],
           "displacement": {"x": 0.0, "y": -0.2}, "rotation": 0.0}  # fmt: skip
    entries = block_entries("plane_strain", "gimp", rigid_bodies=[box])
    model = Model.from_dict({**entries, "boundaries": rollers("plane_strain")})
    shape = rigid_shapes(model, Simulation(model).state.points)["box"]
    (line,) = shape.at(np.zeros(2), np.zeros(3)).polylines
    assert line[0] == line[-1]
    assert len(line) == 13  # facets of half a cell


@pytest.mark.parametrize("dim", [2, 3])
def test_lowest_point_of_a_ball_is_exact(dim: int) -> None:
    moved = np.arange(dim) * 0.25
    lowest = ball(dim).lowest(moved, np.array([0.0, 0.0, 0.4]))
    expected = moved.copy()
    expected[-1] -= RADIUS
    np.testing.assert_allclose(lowest, expected, atol=1e-12)


def test_points_in_any_order_are_followed_along_the_surface() -> None:
    shape = lower_half(200)
    order, length, breaks = along_surface(shape.position, shape.fields["normal"])
    x = shape.position[order, 0]
    assert (np.diff(x) > 0.0).all() or (np.diff(x) < 0.0).all()
    assert length[-1] == pytest.approx(math.pi * 199 / 200, rel=1e-4)
    assert len(breaks) == 0


def test_two_sides_of_a_thin_plate_are_apart() -> None:
    x = np.linspace(0.0, 1.0, 21)
    place = np.column_stack([np.tile(x, 2), np.repeat([0.0, 1e-6], 21)])
    normal = np.repeat([[0.0, -1.0], [0.0, 1.0]], 21, axis=0)
    order, _, _ = along_surface(place, normal)
    assert set(order[:21]) in ({*range(21)}, {*range(21, 42)})


def test_curves_of_pressure_and_shear() -> None:
    state = with_contact(snapshot())
    (shape,) = state.contacts
    chart = contact_chart(shape, UNITS)
    pressure, shear = (line.y for line in chart.lines)
    assert np.nanmax(pressure) == pytest.approx(PRESSURE, rel=1e-3)
    touching = pressure > 0.0
    assert pressure[touching].min() == pytest.approx(0.2 * PRESSURE, rel=0.3)
    np.testing.assert_allclose(shear[touching], SHEAR, rtol=1e-12)
    assert chart.x == "arc length [m]"
    view = contact_view(state, shape, UNITS)
    assert "kPa" in view.panels[0].title
    bars = next(part for part in view.clouds[0].lines if part["kind"] == "bars")
    length = np.linalg.norm(np.diff(bars["position"], axis=1)[:, 0], axis=1)
    size = float(np.ptp(shape.position, axis=0).max())
    assert length.max() == pytest.approx(0.22 * size)


def test_contact_in_space_colours_points_in_contact() -> None:
    state = with_contact(snapshot(3))
    view = contact_view(state, state.contacts[0], UNITS)
    assert [panel.bar for panel in view.panels] == ["pressure [kPa]", "shear stress [kPa]"]
    values = view.panels[0].values
    assert values is not None
    touching = state.contacts[0].fields["in_contact"] != 0
    assert np.isnan(values[~touching]).all()
    assert values[touching].max() == pytest.approx(PRESSURE, rel=0.01)
    assert values[touching].min() > 0.09 * PRESSURE


@pytest.mark.parametrize("dim", [2, 3])
def test_bodies_are_drawn_where_they_are(dim: int) -> None:
    frames = [with_contact(snapshot(dim, step)) for step in (0, 5)]
    figure = draw_frames(frames, "displacement", UNITS)
    for axes, frame in zip(figure.axes, frames, strict=False):
        if dim == 2:
            outline = next(line for line in axes.lines if line.get_color() == "0.15")
            np.testing.assert_allclose(
                outline.get_ydata().min(), frame.rigid_bodies[0].position[:, 1].min()
            )
            assert axes.get_ylim()[0] < -1.4  # of the lower one
        else:
            low, _ = axes.get_zlim()
            assert low < -1.4


def problem(**more: Any) -> Model:
    entries = block_entries("plane_strain", "gimp", **more)
    entries["boundaries"] = rollers("plane_strain")
    entries["rigid_bodies"] = [BALL]
    return Model.from_dict(entries)


def tracked(asked: list[dict[str, Any]], state: RigidBodyState | None) -> list[float]:
    entries = problem(track=[{"name": f"t{i}", **item} for i, item in enumerate(asked)]).to_dict()
    entries["rigid_bodies"][0]["displacement"]["y"] = 0.2  # away from the soil, which stays
    model = Model.from_dict(entries)
    simulation = Simulation(model)
    tracker = Tracker(model, simulation.state.points)
    result = simulation.advance(0.0, 0.5)
    body = simulation.state.bodies[0]
    body.displacement, body.turn = np.zeros(2), np.zeros(1)
    if state is not None:
        body.displacement, body.turn = state.displacement, state.rotation[2:]
        body.force, body.moment = state.force, state.moment[2:]
    contact = ContactState(
        np.zeros((3, 2)), np.ones((3, 2)), np.array([1.0, 2.0, 4.0]), np.zeros(3),
        np.zeros((3, 2)), np.zeros(3), np.zeros(3, bool), np.array([True, False, True]),
    )  # fmt: skip
    result.contacts["ball"] = contact
    return tracker.values(
        simulation.setup, simulation.state, result, Energies(work=3.0, friction=2.0)
    )


STATE = RigidBodyState(
    np.array([0.3, -0.4]), np.array([0.0, 0.0, math.radians(30.0)]), np.array([2.0, 5.0]),
    np.array([0.0, 0.0, 7.0]),
)  # fmt: skip


def test_quantities_of_a_rigid_body() -> None:
    of_ball = {"boundary": "ball"}
    values = tracked(
        [
            {"quantity": "rigid_displacement", "component": "y", **of_ball},
            {"quantity": "rigid_displacement", "component": "magnitude", **of_ball},
            {"quantity": "rigid_rotation", "component": "z", **of_ball},
            {"quantity": "reaction", "component": "y", **of_ball},
            {"quantity": "moment", "component": "z", **of_ball},
            {"quantity": "moment", "component": "z", "about": [0.0, 0.0], **of_ball},
            {"quantity": "contact_area", **of_ball},
            {"quantity": "embedment", "from": "original", **of_ball},
            {"quantity": "embedment", "from": "current", **of_ball},
            {"quantity": "energy", "kind": "friction_dissipation"},
        ],
        STATE,
    )
    about_origin = 7.0 + 1.3 * 5.0 - 2.1 * 2.0  # of the soil on the body
    depth = 2.0 - (2.5 - 0.4 - 0.5)
    expected = [-0.4, 0.5, 30.0, -5.0, -7.0, -about_origin, 5.0, depth, depth, 2.0]
    assert values == pytest.approx(expected, rel=1e-12)


def test_embedment_of_a_body_that_is_above_or_beside_soil() -> None:
    asked = [{"quantity": "embedment", "from": key, "boundary": "ball"}
             for key in ("original", "current")]  # fmt: skip
    assert tracked(asked, None) == pytest.approx([0.0, 0.0], abs=1e-12)
    beside = replace(STATE, displacement=np.array([1.6, -0.4]))
    original, current = tracked(asked, beside)
    assert math.isnan(original)  # no soil was where its lowest point is
    assert current == pytest.approx(0.4)  # the soil to its left, within half its width
    away = replace(STATE, displacement=np.array([5.0, 0.0]))
    assert all(math.isnan(value) for value in tracked(asked, away))


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"quantity": "rigid_displacement", "boundary": "low y", "component": "y"}, "rigid bodies"),
        ({"quantity": "penetration", "boundary": "ball"}, "implicit boundaries"),
        ({"quantity": "contact_area", "boundary": "low y"}, "implicit boundaries and rigid"),
        ({"quantity": "embedment", "boundary": "ball"}, "`from`"),
        ({"quantity": "rigid_rotation", "boundary": "ball", "component": "x"}, "about z only"),
        ({"quantity": "reaction", "boundary": "bal", "component": "x"}, "ball"),
        ({"quantity": "energy", "kind": "elastic", "from": "current"}, "has no meaning"),
    ],
)
def test_quantities_that_are_not_of_the_boundary(asked: dict[str, Any], words: str) -> None:
    with pytest.raises(BadInput) as caught:
        problem(track=[{"name": "t", **asked}])
    assert words in str(caught.value)


@pytest.mark.slow
def test_run_writes_contact_and_resumes_to_the_same_bytes(tmp_path: Path) -> None:
    rough = {"normal": "unilateral", "tangential": "friction", "friction": 0.2}
    entries = problem(
        schedule={"steps": 4, "outputs": 2},
        track=[
            {"name": "lost", "quantity": "energy", "kind": "friction_dissipation"},
            {"name": "force", "quantity": "reaction", "boundary": "ball", "component": "y"},
        ],
    ).to_dict()
    ploughing = {"x": 0.3, "y": -0.2}
    entries["rigid_bodies"][0] |= {"contact": rough, "displacement": ploughing}
    model = Model.from_dict(entries)
    run(model, tmp_path / "whole", quiet=True)
    run(model, tmp_path / "part", until=0.5, quiet=True)
    assert read_contacts(tmp_path / "part" / "contact.csv")["step"][0] == 2
    resume(tmp_path / "part", quiet=True)
    for name in ("history.csv", "boundaries.csv", "contact.csv"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "part" / name).read_bytes()
    history = read_history(tmp_path / "whole" / "history.csv")
    assert (np.diff(history["lost [N m/m]"]) >= 0.0).all()
    assert history["lost [N m/m]"][-1] > 0.0
    rows = read_history(tmp_path / "whole" / "boundaries.csv")
    np.testing.assert_allclose(rows["ball displacement_y [m]"], -0.2 * rows["time"])
    assert rows["ball force_y [N/m]"][-1] < 0.0
    np.testing.assert_array_equal(rows["ball force_y [N/m]"], history["force [N/m]"])
    table = read_contacts(tmp_path / "whole" / "contact.csv")
    assert set(table["boundary"]) == {"ball"}
    assert table["step"][0] == 4
    touching = table["state"] != "open"
    pressure = table["normal_stress [Pa]"] * table["normal_y"] + table["shear_y [Pa]"] * -1.0
    force = float((table["area [m^2/m]"] * pressure)[touching].sum())
    assert force == pytest.approx(-rows["ball force_y [N/m]"][-1], rel=1e-12)
    last = read_results(tmp_path / "whole" / "results.vtkhdf").snapshot(-1)
    assert last.rigid_bodies[0].position[:, 1].min() == pytest.approx(1.8, abs=1e-12)
    page = (tmp_path / "whole" / "report.html").read_text()
    assert page.index("<h2>Force and displacement") < page.index("<h2>Set-up")
    assert "Pressure and shear on ball" in page
