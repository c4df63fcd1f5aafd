# SPDX-License-Identifier: BSD-3-Clause
"""Pressures and fluxes of water on geometries and tracked surfaces, and the balance of its flow."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from consolidating import with_flow
from resumed_runs import assert_same_results, run_in_pieces
from small_problems import block_entries, plane, rollers

from tilth import Model, run
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.mpm.pore_water import PRESSURE, STORED

STIFF = {"young_modulus": 1e6, "poisson_ratio": 0.0}
OFF = 0.3
"""Coordinate of the lower end of columns: it is on no line of the grid."""


def implicit(name: str, axis: int, at: float, inward: float, dim: int, **more: Any) -> Any:
    """A flow boundary on a plane across an axis, with the soil on the side of `inward`."""
    point, normal = [0.0] * dim, [0.0] * dim
    point[axis], normal[axis] = at, inward
    geometry = {"type": "plane", "point": point, "normal": normal}
    return {"name": name, "type": "implicit", "geometry": geometry, "condition": "drained", **more}


def column(kind: str = "plane_strain", basis: str = "gimp", top: float = 6.0) -> Any:
    """A column of one cell by one that begins off the lines of the grid."""
    entries: dict[str, Any] = block_entries(kind, basis, cells=1)
    dim = len(entries["bodies"][0]["shape"]["lower"])
    entries["materials"]["soil"] |= STIFF
    entries["bodies"][0] |= {"surface": {}, "anti_locking": "none"}
    entries["bodies"][0]["shape"]["lower"][-1] = OFF
    entries["bodies"][0]["shape"]["upper"] = [*[1.0] * (dim - 1), top]
    across = rollers(kind, 1.0)
    foot = implicit("foot", dim - 1, OFF, 1.0, dim, condition="roller")
    entries["boundaries"] = [*(each for each in across if each["axis"] != "xyz"[dim - 1]), foot]
    if kind == "axisymmetric":
        entries["boundaries"] = entries["boundaries"][1:]
    entries["schedule"] = {"steps": 1, "end": 1e9}
    return entries


def top_part(kind: str, top: float) -> dict[str, Any]:
    """The top of such a column as a part of its surface."""
    if kind == "3d":
        return {"type": "surface", "body": "block", "part": "z+"}
    return {"type": "surface", "body": "block", "start": [1.0, top], "end": [0.0, top]}


def pressures(simulation: Simulation) -> tuple[Floats, Floats]:
    """Last coordinate and pressure of the points."""
    points = simulation.state.points
    return points.position[:, -1], points.water[:, PRESSURE]


AREAS = {"plane_strain": 1.0, "axisymmetric": np.pi, "3d": 1.0}


@pytest.mark.parametrize("where", ["surface", "implicit"])
@pytest.mark.parametrize("kind", AREAS)
def test_a_given_flux_has_its_gradient_when_it_is_steady(kind: str, where: str) -> None:
    """Water enters at the top of a column that ends anywhere, and leaves at its foot.

    Exact, but in axisymmetry within 1 % of the greatest pressure: points there do not integrate
    what is linear in the radius.
    """
    top, flux = 5.7, 1e-3
    entries = column(kind, top=top)
    dim = len(entries["bodies"][0]["shape"]["lower"])
    source = implicit("top", dim - 1, top, -1.0, dim)
    if where == "surface":
        source = top_part(kind, top) | {"name": "top"}
    source |= {"condition": "flux", "flux": 2.0 * flux, "factor": [[0.0, 0.5], [1e9, 0.5]]}
    drain = implicit("drain", dim - 1, OFF, 1.0, dim)
    simulation = Simulation(with_flow(entries, [source, drain]))
    simulation.check()
    result = simulation.advance(0.0, 1e6)
    height, pressure = pressures(simulation)
    expected = flux * (height - OFF)
    share = 0.01 if kind == "axisymmetric" else 1e-6
    np.testing.assert_allclose(pressure, expected, rtol=0, atol=share * expected.max())
    assert result.discharge("top") == pytest.approx(-flux * AREAS[kind], rel=1e-12)
    assert result.discharge("drain") == pytest.approx(flux * AREAS[kind], rel=1e-6)


def test_a_pressure_follows_its_table() -> None:
    entries = column()
    drain = implicit(
        "well", 1, OFF, 1.0, 2, condition="pressure", excess_pressure=2.0,
        factor=[[0.0, 0.0], [1e6, 1.0], [2e6, -0.5]],
    )  # fmt: skip
    simulation = Simulation(with_flow(entries, [drain]))
    for before, after, expected in ((0.0, 5e5, 1.0), (5e5, 1e6, 2.0), (1e6, 2e6, -1.0)):
        simulation.advance(before, after)
        np.testing.assert_allclose(pressures(simulation)[1], expected, rtol=1e-4)


def terzaghi(depth: Floats, time: float) -> Floats:
    """Pressure at depths over the drained length, for the load 1 and the time factor."""
    root = np.pi * (np.arange(100) + 0.5)[:, None]
    found: Floats = (2.0 / root * np.sin(root * depth) * np.exp(-(root**2) * time)).sum(axis=0)
    return found


def consolidated(entries: Any, boundaries: list[Any], length: float, **water: Any) -> Simulation:
    """Soil with a modulus of 1e3 that was loaded at once, at the time factor 0.2."""
    entries["materials"]["soil"] |= {"young_modulus": 1e3, "poisson_ratio": 0.0}
    simulation = Simulation(with_flow(entries, boundaries, **water))
    simulation.check()
    unit = length**2 / 1e3
    for before, after in pairwise([0.0, *np.geomspace(1e-4, 0.02, 10), *np.arange(3, 21) * 0.01]):
        simulation.advance(unit * before, unit * after)
    return simulation


LOAD = 1e-2


def test_a_block_in_space_on_a_drain_off_the_lines_of_the_grid() -> None:
    """Terzaghi's problem; errors over the load."""
    entries = column("3d", top=8.0)
    load = top_part("3d", 8.0) | {"pressure": LOAD, "factor": [[0, 1], [1e9, 1]]}
    entries["loads"] = [load]
    simulation = consolidated(entries, [implicit("drain", 2, OFF, 1.0, 3)], 8.0 - OFF)
    height, pressure = pressures(simulation)
    expected = terzaghi((height - OFF) / (8.0 - OFF), 0.2)
    np.testing.assert_allclose(pressure / LOAD, expected, atol=0.01)


@pytest.mark.parametrize("ratio", [1.0, 0.1, 10.0])
@pytest.mark.parametrize("drain", ["implicit", "surface"])
@pytest.mark.parametrize("basis", ["linear", "gimp"])
def test_a_turned_column_consolidates_as_an_upright_one(
    basis: str, drain: str, ratio: float
) -> None:
    """By 20 degrees, two cells wide and eight long, drained at its inclined base.

    Errors over the load. ratio: of the conductivity across the column to that along it.
    """
    angle, width, length = np.radians(20.0), 2.0, 8.0
    along, across = (
        np.array([-np.sin(angle), np.cos(angle)]), np.array([np.cos(angle), np.sin(angle)])
    )  # fmt: skip
    origin = np.array([0.21, 0.13])
    corners = [origin, origin + width * across]
    corners += [corners[1] + length * along, origin + length * along]
    low, right, high, left = (each.tolist() for each in corners)
    entries: dict[str, Any] = block_entries("plane_strain", basis)
    shape = {"type": "polygon", "vertices": [low, right, high, left]}
    entries["bodies"][0] |= {"shape": shape, "surface": {}, "anti_locking": "none"}
    sides = {"left": (low, across), "right": (high, -across), "base": (low, along)}
    entries["boundaries"] = [
        {"name": name, "type": "implicit", "condition": "roller",
         "geometry": {"type": "plane", "point": point, "normal": normal.tolist()}}
        for name, (point, normal) in sides.items()
    ]  # fmt: skip
    top = {"type": "surface", "body": "block", "start": high, "end": left}
    entries["loads"] = [{**top, "pressure": LOAD, "factor": [[0, 1], [1e9, 1]]}]
    entries["schedule"] = {"steps": 1, "end": 1e9}
    base = {"type": "implicit", "geometry": entries["boundaries"][2]["geometry"]}
    if drain == "surface":
        base = {"type": "surface", "body": "block", "start": low, "end": right}
    drained = {"name": "drain", "condition": "drained", **base}
    water = {}
    if ratio != 1.0:
        tensor = ratio * np.outer(across, across) + np.outer(along, along)
        water["conductivity_ratios"] = (0.5 * (tensor + tensor.T)).tolist()
    simulation = consolidated(entries, [drained], length, **water)
    points = simulation.state.points
    depth = (points.position - origin) @ along / length
    error = points.water[:, PRESSURE] / LOAD - terzaghi(depth, 0.2)
    mean, greatest = (0.01, 0.03) if ratio == 1.0 else (0.012, 0.035)
    assert np.sqrt((error**2).mean()) < mean
    assert np.abs(error).max() < greatest


def test_no_water_enters_soil_without_pores() -> None:
    """A flux at the foot of two columns, one of which lets no water in."""
    entries = column()
    shape = {"type": "box", "lower": [1.0, OFF], "upper": [3.0, 6.0]}
    dry = {"name": "dry", "material": "dry", "shape": shape}
    entries["bodies"].append({**entries["bodies"][0], **dry})
    entries["materials"]["dry"] = dict(entries["materials"]["soil"])
    for each in entries["boundaries"]:
        if each["name"] == "high x":
            each["at"] = 3.0
    source = implicit("foot drain", 1, OFF, 1.0, 2, condition="flux", flux=1e-6)
    simulation = Simulation(with_flow(entries, [source]))
    before = simulation.state.points.water[:, STORED].copy()
    result = simulation.advance(0.0, 1.0)
    points = simulation.state.points
    taken = (points.initial_volume * (points.water[:, STORED] - before)).sum()
    assert result.discharge("foot drain") == pytest.approx(-1e-6, rel=1e-9)
    assert taken == pytest.approx(1e-6, rel=1e-6)


LAYERS = [
    (1e3, 8.1, 0.5, "gimp"), (1e-3, 8.05, 1.0, "linear"), (1e-3, 8.1, 0.5, "gimp"),
    (1e-3, 8.3, 0.1, "linear"),
]  # fmt: skip


@pytest.mark.parametrize(("ratio", "top", "thickness", "basis"), LAYERS)
def test_a_drained_skin_of_other_conductivity(
    ratio: float, top: float, thickness: float, basis: str
) -> None:
    """The pressure stays between that of the drain and the load, up to 5 % of the load.

    With the mean conductivity in all of Nitsche's terms it was up to 3000 loads.
    """
    entries = column(basis=basis, top=top - thickness)
    entries["materials"]["soil"] |= {"young_modulus": 1e3, "poisson_ratio": 0.0}
    entries["bodies"][0]["shape"]["lower"][-1] = 0.0
    shape = {"type": "box", "lower": [0.0, top - thickness], "upper": [1.0, top]}
    skin = {"name": "skin", "material": "skin", "shape": shape}
    entries["bodies"].append({**entries["bodies"][0], **skin})
    entries["boundaries"] = rollers("plane_strain", 1.0)
    load = top_part("plane_strain", top) | {"body": "skin", "pressure": LOAD}
    entries["loads"] = [{**load, "factor": [[0, 1], [1e9, 1]]}]
    skin_soil = {"porosity": 0.5, "hydraulic_conductivity": ratio}
    entries["materials"]["skin"] = {**entries["materials"]["soil"], **skin_soil}
    simulation = Simulation(with_flow(entries, [implicit("drain", 1, top, -1.0, 2)]))
    unit = (8.0 if ratio > 1.0 else 3000.0) / 1e3
    for before, after in pairwise([0.0, *np.geomspace(5e-4, 0.1, 10), *np.linspace(0.15, 1.0, 18)]):
        simulation.advance(unit * before, unit * after)
        pressure = pressures(simulation)[1] / LOAD
        assert pressure.min() > -0.05
        assert pressure.max() < 1.05


def test_a_drain_inside_the_soil_takes_from_both_sides() -> None:
    """A pressure on a line of the grid at which the soil goes on; errors over this pressure.

    The strains of 1e-6 are next to round-off of what the pores store.
    """
    at, length = 8.0, 8.0
    entries = block_entries("plane_strain", "gimp")
    entries["materials"]["soil"] |= {"young_modulus": 1e3, "poisson_ratio": 0.0}
    entries["bodies"][0]["shape"]["upper"] = [2.0 * length, 1.0]
    middle = plane("middle", "x", at)
    entries["boundaries"] = [middle, plane("low", "y", 0.0), plane("high", "y", 1.0)]
    entries["schedule"] = {"steps": 1, "end": 1e9}
    line = {"type": "polyline", "vertices": [[at, -1.0], [at, 2.0]], "soil": "both"}
    drain = {"name": "drain", "type": "implicit", "geometry": {**line, "closed": False},
             "condition": "pressure", "excess_pressure": 1e-3}  # fmt: skip
    simulation = consolidated(entries, [drain], length)
    points = simulation.state.points
    depth = np.abs(points.position[:, 0] - at) / length
    pressure = points.water[:, PRESSURE] / 1e-3
    np.testing.assert_allclose(pressure, 1.0 - terzaghi(depth, 0.2), atol=0.01)


def drained_all_over(kind: str) -> tuple[Any, list[Any]]:
    """A pressed block with a pressure on a plane of the grid, and a flux and a drain elsewhere."""
    top = 4.6
    entries = column(kind, top=top)
    dim = len(entries["bodies"][0]["shape"]["lower"])
    entries["materials"]["soil"] |= {"young_modulus": 100.0, "poisson_ratio": 0.2}
    entries["bodies"][0]["shape"]["upper"][0] = 2.0
    for each in entries["boundaries"]:
        if each["name"] == "high x":
            each["at"] = 2.0
    part = top_part(kind, top)
    if kind != "3d":
        part["start"] = [2.0, top]
    entries["loads"] = [{**part, "pressure": 20.0}]
    flow = [
        {"name": "side", "type": "plane", "axis": "x", "at": 2.0, "condition": "pressure",
         "excess_pressure": 3.0, "range": {"xyz"[dim - 1]: [1.0, 3.0]}},
        implicit("base", dim - 1, OFF, 1.0, dim, condition="flux", flux=2.0),
        {**part, "name": "top", "condition": "drained"},
    ]  # fmt: skip
    entries["analysis"]["tolerance"] = 1e-9
    entries["schedule"] = {"steps": 4, "end": 0.4}
    names = [each["name"] for each in flow]
    entries["track"] = [
        *({"name": f"{q} {name}", "quantity": q, "boundary": name}
          for q in ("discharge", "drained_volume") for name in names),
        {"name": "stored", "quantity": "stored_water"},
        {"name": "stored in block", "quantity": "stored_water", "body": "block"},
    ]  # fmt: skip
    entries["output"] = {"report": False}
    return entries, flow


@pytest.mark.parametrize("scheme", ["backward_euler", "bdf2"])
@pytest.mark.parametrize("kind", AREAS)
def test_what_leaves_the_pores_leaves_through_the_boundaries(
    kind: str, scheme: str, tmp_path: Path
) -> None:
    """At a settlement of 12 %, to the tolerance of Newton's iteration."""
    entries, flow = drained_all_over(kind)
    model = with_flow(entries, flow, scheme)
    result = run(model, tmp_path / "whole", threads=1, quiet=True)
    history = {name.split(" [")[0]: column for name, column in result.history.items()}
    water, time = history["stored"], history["time"]
    rates = [history[f"discharge {each['name']}"] for each in flow]
    drained = [history[f"drained_volume {each['name']}"] for each in flow]
    assert water[0] - water[-1] > 0.01 * water[0]
    assert min(np.abs(each[-1]) for each in drained) > 0.01 * (water[0] - water[-1])
    np.testing.assert_allclose(sum(drained), water[0] - water, rtol=0, atol=1e-9 * water[0])
    np.testing.assert_array_equal(history["stored in block"], water)
    for rate, volume in zip(rates, drained, strict=True):
        np.testing.assert_allclose(np.diff(volume), rate[1:] * np.diff(time), rtol=1e-12)


@pytest.mark.parametrize("scheme", ["backward_euler", "bdf2"])
def test_resumed_run_has_the_same_bits(
    scheme: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The volumes that have left so far are in the checkpoint."""
    entries, flow = drained_all_over("plane_strain")
    model = with_flow(entries, flow, scheme)
    whole, stopped = tmp_path / "whole", tmp_path / "stopped"
    run(model, whole, threads=1, quiet=True)
    run_in_pieces(model, stopped, [2], monkeypatch, [1])
    assert_same_results(whole, stopped)


def test_stages_hand_on_surfaces_and_volumes(tmp_path: Path) -> None:
    """The drained surface acts first, then the flux; what has left stays counted."""
    entries, flow = drained_all_over("plane_strain")
    schedule = {"steps": 2, "end": 0.2}
    del entries["schedule"]
    entries["stages"] = [
        {"name": "drained", "schedule": schedule},
        {"name": "wetted", "schedule": schedule, "activate": ["base"], "deactivate": ["top"],
         "factors": {}},
    ]  # fmt: skip
    result = run(with_flow(entries, flow), tmp_path / "run", threads=1, quiet=True)
    history = {name.split(" [")[0]: column for name, column in result.history.items()}
    top, base = history["drained_volume top"], history["drained_volume base"]
    assert (np.diff(top[:3]) > 0.0).all()
    assert (base[:3] == 0.0).all()
    assert (top[3:] == top[2]).all()
    assert (history["discharge top"][3:] == 0.0).all()
    assert base[-1] == pytest.approx(-2.0 * 2.0 * 0.2, rel=1e-9)
    drained, water = top + base + history["drained_volume side"], history["stored"]
    np.testing.assert_allclose(drained, water[0] - water, rtol=0, atol=1e-8 * water[0])


def problem(entries: Any, boundary: dict[str, Any]) -> str:
    """What is wrong with a case with this flow boundary."""
    with pytest.raises(BadInput) as error:
        Simulation(
            with_flow(entries, [{"name": "drain", "condition": "drained", **boundary}])
        ).check()
    return str(error.value)


def test_boundaries_without_soil_are_refused() -> None:
    far = problem(column(), implicit("drain", 1, -3.0, 1.0, 2))
    assert "flow.boundaries[0].geometry" in far
    assert "the flow boundary 'drain' touches no soil" in far
    behind = problem(column(), implicit("drain", 1, OFF, -1.0, 2))
    assert "all material is behind the boundary 'drain'" in behind


def test_parts_of_surfaces_that_do_not_exist_are_refused() -> None:
    part = {"type": "surface", "body": "block", "part": "z*"}
    assert "flow.boundaries[0].part" in problem(column("3d"), part)
    backwards = {"type": "surface", "body": "block", "start": [0.0, 6.0], "end": [1.0, 6.0]}
    entries = column()
    vertices = [[1.0, 6.0], [0.5, 6.0], [0.0, 6.0]]
    entries["bodies"][0]["surface"] = {"vertices": vertices, "closed": False}
    found = problem(entries, backwards)
    assert "flow.boundaries[0].start" in found
    assert "exchange `start` and `end`" in found


def test_what_has_no_meaning_is_refused() -> None:
    on_plane = {"type": "plane", "axis": "y", "at": 1.0}
    assert "flow.boundaries[0].flux" in problem(column(), {**on_plane, "flux": 1.0})
    assert "flow.boundaries[0].flux" in problem(column(), {**on_plane, "condition": "flux"})
    for track, said in (
        ({"quantity": "discharge", "boundary": "foot"}, "track[0].boundary"),
        ({"quantity": "reaction", "boundary": "drain", "component": "y"}, "track[0].boundary"),
        ({"quantity": "drained_volume"}, "track[0].boundary"),
    ):
        entries = {**column(), "track": [{"name": "q", **track}]}
        assert said in problem(entries, implicit("drain", 1, OFF, 1.0, 2))
    entries = {**column(), "track": [{"name": "w", "quantity": "stored_water"}]}
    with pytest.raises(BadInput, match="no water flows"):
        Model.from_dict(entries)
