# SPDX-License-Identifier: BSD-3-Clause
"""The phreatic surface, water in whole analyses, and what is refused or warned of."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from balances import blocks_at, residual_at
from resumed_runs import assert_same_results
from small_problems import KINDS, block_entries, dimension, rollers, weight

import tilth
from tilth import BadInput, Model, resume, run
from tilth.analysis.march import march
from tilth.analysis.memory import memory_of
from tilth.analysis.setup_picture import setup_of
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.cli import run_command
from tilth.mpm.water import PhreaticSurface, wet_share
from tilth.mpm.wet_mass import effective_stress, pore_mass, total_stress
from tilth.output import read_history, read_results
from tilth.report.setup import draw_setup
from tilth.report.setup_file import read_setup
from tilth.terms.balance import Balance

ALL_FROM_THE_START = {"factor": [[0.0, 1.0], [1.0, 1.0]]}


def wet(kind: str, level: Any = 1.3, basis: str = "gimp", **water: Any) -> dict[str, Any]:
    """A block of two cells with weight, on its base and between smooth sides, in water."""
    entries = block_entries(kind, basis, boundaries=rollers(kind))
    entries["loads"] = [weight(kind, 10.0) | ALL_FROM_THE_START]
    entries["materials"]["soil"] |= {"saturated_density": 2.2, "young_modulus": 1e4}
    entries["water"] = {"level": level, "unit_weight": 10.0, **water}
    entries["units"] = {"force": "kN", "stress": "kPa", "mass": "t"}
    return entries


def surface_of(entries: dict[str, Any]) -> PhreaticSurface:
    found = PhreaticSurface.of(Model.from_dict(entries))
    assert found is not None
    return found


def table_of(path: Path, dim: int) -> dict[str, str]:
    """A grid of levels in a file, over the horizontal axes."""
    random = np.random.default_rng(1)
    lines = np.array([-1.0, 0.4, 1.1, 3.0])
    axes = np.meshgrid(*[lines] * (dim - 1), indexing="ij")
    rows = np.column_stack([*(axis.ravel() for axis in axes), 1.0 + random.random(axes[0].size)])
    header = ",".join(("x", "y")[: dim - 1]) + ",value"
    np.savetxt(path / "level.csv", rows, delimiter=",", header=header, comments="")
    return {"file": str(path / "level.csv")}


def pressure_gradient(water: PhreaticSurface, place: Floats, time: float) -> Floats:
    """That of the planes from which the force of the water is computed."""
    planes = water.planes(place, time)
    wet = planes.depth > 0.0
    return np.asarray(water.unit_weight(time) * wet[:, None] * planes.direction)


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_the_gradient_is_the_derivative_of_the_pressure(kind: str, tmp_path: Path) -> None:
    """Of a number, a polyline and a grid, while the level moves; zero above it."""
    dim = dimension(kind)
    levels: list[Any] = [1.2, table_of(tmp_path, dim)]
    levels += [[[-1.0, 0.7], [0.6, 1.9], [3.0, 1.0]]] if dim == 2 else []
    place = np.random.default_rng(2).uniform(0.0, 2.0, (200, dim))
    for level in levels:
        water = surface_of(wet(kind, level, initial_level=0.4, factor=[[0.0, 0.5], [1.0, 1.0]]))
        found = pressure_gradient(water, place, 0.6)
        assert 20 < np.count_nonzero(found[:, -1]) < 180
        for k in range(dim):
            step = 1e-7 * np.eye(dim)[k]
            ahead, behind = (water.pore_pressure(place + s * step, 0.6) for s in (1.0, -1.0))
            np.testing.assert_allclose(found[:, k], (ahead - behind) / 2e-7, atol=1e-6)


def test_the_pressure_is_that_of_the_depth_and_the_time() -> None:
    level = [[0.0, 1.0], [2.0, 2.0]]
    water = surface_of(wet("plane_strain", level, initial_level=3.0))
    place = np.array([[0.5, 1.0], [1.0, 1.0], [1.0, 1.6], [9.0, 1.0], [-9.0, 1.5]])
    np.testing.assert_allclose(water.pore_pressure(place, 1.0), [2.5, 5.0, 0.0, 10.0, 0.0])
    np.testing.assert_allclose(water.pore_pressure(place, 0.0), [20.0, 20.0, 14.0, 20.0, 15.0])
    np.testing.assert_allclose(water.pore_pressure(place, 0.5)[:3], [11.25, 12.5, 6.5])
    assert pressure_gradient(water, place, 1.0)[3] == pytest.approx([0.0, -10.0]), "level goes on"
    assert pressure_gradient(water, place, 1.0)[0] == pytest.approx([5.0, -10.0])
    assert water.unit_weight(0.3) == 10.0


def inside(depth: float, extents: Floats) -> float:
    """The wet share of a domain by counting places in it."""
    places = 200 if len(extents) == 2 else 60
    axes = [(np.arange(places) + 0.5) * 2.0 / places - 1.0] * len(extents)
    height = sum(a * axis for a, axis in zip(extents, np.meshgrid(*axes), strict=True))
    return float((depth + height > 0.0).mean())


@pytest.mark.parametrize("extents", [(0.5, 0.2), (0.3, 0.3), (0.7, 0.0), (0.4, 0.3, 0.1),
                                     (0.3, 0.3, 0.3), (0.5, 0.0, 0.0)])  # fmt: skip
def test_the_wet_share_is_that_of_the_domain(extents: tuple[float, ...]) -> None:
    """By counting in the domain; its derivative by differences."""
    sizes = np.array(extents)
    depth = np.linspace(-1.2, 1.2, 25) * sizes.sum() + 1e-3
    found, slope = wet_share(depth, np.tile(sizes, (25, 1)))
    counted = [inside(d, sizes) for d in depth]
    np.testing.assert_allclose(found, counted, atol=0.012)
    ahead, behind = (wet_share(depth + s * 1e-6, np.tile(sizes, (25, 1)))[0] for s in (1, -1))
    np.testing.assert_allclose(slope, (ahead - behind) / 2e-6, atol=1e-6)
    opposite = wet_share(-depth, np.tile(sizes, (25, 1)))[0]
    np.testing.assert_allclose(found + opposite, 1.0, atol=1e-14)


@pytest.mark.parametrize("kind", KINDS)
def test_the_base_carries_the_effective_weight(kind: str) -> None:
    """A stiff block that is cut by the level: moist above, buoyant below, in every step."""
    entries = wet(kind, 0.3, initial_level=1.7) | {"schedule": {"steps": 7}}
    entries["materials"]["soil"]["young_modulus"] = 1e9
    area = {"plane_strain": 2.0, "axisymmetric": 4.0 * np.pi, "3d": 4.0}[kind]
    base = f"low {'xyz'[dimension(kind) - 1]}"
    found: list[tuple[float, float]] = []
    march(
        Model.from_dict(entries),
        lambda simulation, result, time: found.append((time, result.resultant(base)[-1])),
    )
    for time, force in found:
        height = 1.7 - 1.4 * time
        expected = area * (height * 12.0 + (2.0 - height) * 20.0)
        assert force == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_the_tangent_of_a_wet_rotation(kind: str) -> None:
    """Of all terms together, in the middle of the motion, against differences."""
    dim = dimension(kind)
    turn = np.eye(dim)
    turn[:2, :2] = [[0.0, -1.0], [1.0, 0.0]] if kind != "axisymmetric" else [[1.1, 0], [0, 0.8]]
    stress = [-9.0, -30.0, -12.0, 4.0] + [0.0] * (2 if dim == 3 else 0)
    entries = wet(kind, -0.2 if kind == "plane_strain" else 0.9, "cpdi1")
    entries["boundaries"] = [
        {"type": "affine", "name": "turn", "deformation_gradient": turn.tolist(),
         "path": "exponential"}
    ]  # fmt: skip
    entries["initial"] = {"stress": [{"type": "given", "body": "block", "stress": stress}]}
    simulation = Simulation(Model.from_dict(entries))
    simulation.advance(0.0, 0.25)
    step = simulation.prepare(0.25, 0.5)
    terms = simulation.terms(step, simulation.soil_on(step.active))
    balance = Balance(step.active, terms)
    random = np.random.default_rng(4)
    u, way = (size * random.normal(size=(step.active.nodes, dim)) for size in (5e-3, 1.0))
    if kind == "axisymmetric":
        for each in (u, way):
            each[:, 0] *= np.minimum(1.0, step.active.position[:, 0])
    ahead, behind = (residual_at(balance, u + s * 1e-6 * way).u for s in (1.0, -1.0))
    residual_at(balance, u)
    active = balance.active
    blocks = np.zeros((len(active.column), dim, dim))
    blocks[:] = blocks_at(balance, u)
    rows = np.repeat(np.arange(active.nodes), np.diff(active.row_start))
    found = np.zeros_like(u)
    np.add.at(found, rows, np.einsum("nij,nj->ni", blocks, way[active.column]))
    difference = (ahead - behind) / 2e-6
    np.testing.assert_allclose(found, difference, rtol=0, atol=2e-7 * np.abs(difference).max())


def test_results_history_and_report_have_the_water(tmp_path: Path) -> None:
    """Total stress, effective stress and pore pressure, at their places; an undrained soil."""
    track = {"at": [0.25, 0.25], "component": "yy"}
    entries = wet("plane_strain", [[0.0, 2.4], [2.0, 1.3]], initial_level=2.4)
    entries |= {"schedule": {"steps": 2}, "output": {"colour_by": "pore_pressure"}, "track": [
        track | {"name": "total", "quantity": "stress"},
        track | {"name": "effective", "quantity": "effective_stress"},
        {"name": "u", "quantity": "pore_pressure", "at": [0.25, 0.25]},
    ]}  # fmt: skip
    entries["materials"]["soil"]["pore_fluid_bulk_modulus"] = 1e5
    result = run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    last = read_results(result.folder / "results.vtkhdf").snapshot(-1)
    fields, place = last.point_fields, last.position
    pressure = 10.0 * np.maximum(2.4 - 0.55 * place[:, 0] - place[:, 1], 0.0)
    np.testing.assert_allclose(fields["pore_pressure"], pressure, atol=1e-12)
    excess = fields["excess_pore_pressure"] * 0.5**2 / fields["volume"]  # of Kirchhoff's stress
    assert np.abs(excess).max() > 1.0
    both = pressure + excess
    found = fields["effective_stress"] - fields["cauchy_stress"]
    np.testing.assert_allclose(found[:, :3], np.tile(both[:, None], 3), atol=1e-10)
    assert not found[:, 3:].any()
    history = read_history(result.folder / "history.csv")
    number = int(np.linalg.norm(place - [0.25, 0.25], axis=1).argmin())
    assert history["u [kPa]"][-1] == pytest.approx(pressure[number])
    assert history["total [kPa]"][-1] == pytest.approx(fields["cauchy_stress"][number, 1])
    assert history["effective [kPa]"][-1] == pytest.approx(fields["effective_stress"][number, 1])
    setup = read_setup(result.folder / "setup.npz", last)
    half = setup.water_at(0.5)
    assert half is not None
    np.testing.assert_allclose(np.interp([0.0, 1.0, 2.0], *half.T), [2.4, 2.125, 1.85])


def test_the_setup_draws_the_level(tmp_path: Path) -> None:
    """At the end as a line, at the start dashed; far above the soil it is left out."""
    figure = draw_setup(setup_of(Model.from_dict(wet("plane_strain", 1.3, initial_level=2.2))))
    axes = figure.axes[0]
    heights = {float(line.get_ydata()[0]) for line in axes.lines}
    assert {1.3, 2.2} <= heights
    low, high = axes.get_ylim()
    assert low < 1.3 < 2.2 < high
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "water level\nat the end, dashed at the start" in labels
    far = draw_setup(setup_of(Model.from_dict(wet("plane_strain", 50.0))))
    assert far.axes[0].get_ylim()[1] < 5.0
    assert setup_of(Model.from_dict(wet("3d"))).water_at(0.5) is None


@pytest.mark.slow
def test_a_resumed_run_has_the_same_bits(tmp_path: Path) -> None:
    model = Model.from_dict(
        wet("plane_strain", 0.4, initial_level=1.9) | {"schedule": {"steps": 4}}
    )
    run(model, tmp_path / "whole", quiet=True)
    run(model, tmp_path / "parts", until=0.5, quiet=True)
    resume(tmp_path / "parts", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "parts")


def test_masses_below_the_water() -> None:
    """The added mass of a layer that has one; a watertight layer keeps its mass."""
    entries = wet("plane_strain")
    entries["materials"]["rock"] = {**entries["materials"]["soil"], "watertight": True}
    del entries["materials"]["rock"]["saturated_density"]
    entries["bodies"][0] |= {"layers": [{"material": "soil", "bottom": 1.0}, {"material": "rock"}]}
    del entries["bodies"][0]["material"]
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    upper = simulation.state.points.position[:, 1] > 1.0
    np.testing.assert_allclose(pore_mass(simulation.state.points), 0.2 * 0.25 * upper)
    np.testing.assert_allclose(simulation.state.points.mass, 2.0 * 0.25)


def test_stresses_without_water_are_those_of_the_laws() -> None:
    entries = wet("plane_strain")
    del entries["water"]
    simulation = Simulation(Model.from_dict(entries))
    points = simulation.state.points
    assert total_stress(points, simulation.setup.water, 0.0) is points.stress
    np.testing.assert_array_equal(effective_stress(points), points.stress)
    assert simulation.setup.water is None


REFUSED: dict[str, tuple[dict[str, Any], str, str]] = {
    "no unit weight": ({"unit_weight": 0.0}, "water.unit_weight", "greater than zero"),
    "a negative one": ({"unit_weight": -9.81}, "water.unit_weight", "greater than zero"),
    "a polyline that goes back": (
        {"level": [[0.0, 1.0], [0.0, 2.0]]},
        "water.level",
        "must increase",
    ),
    "a polyline of one point": ({"level": [[0.0, 1.0]]}, "water.level", "at least two rows"),
    "text": ({"level": "high"}, "water.level", "must be a number"),
    "a wrong start": (
        {"initial_level": [[2.0, 1.0], [1.0, 2.0]]},
        "water.initial_level",
        "must increase",
    ),
    "an unknown key": ({"depth": 1.0}, "water.depth", "unknown key"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_wrong_water_is_refused(case: str) -> None:
    changed, key, words = REFUSED[case]
    with pytest.raises(BadInput, match=words) as error:
        Model.from_dict(wet("plane_strain", **{"level": 1.0, **changed}))
    assert key in str(error.value)


def test_a_polyline_is_for_the_plane() -> None:
    with pytest.raises(BadInput, match=r"water\.level = .* is for 2D"):
        Model.from_dict(wet("3d", [[0.0, 1.0], [2.0, 1.0]]))
    Model.from_dict(wet("axisymmetric", [[0.0, 1.0], [2.0, 1.0]]))


def test_soil_beside_the_level_is_refused() -> None:
    with pytest.raises(BadInput, match=r"water\.level: the material point at .* outside the table"):
        tilth.check(Model.from_dict(wet("plane_strain", [[0.0, 1.0], [1.5, 1.0]])))


@pytest.mark.parametrize("later", [False, True])
def test_soil_below_the_water_needs_a_density_there(later: bool) -> None:
    """Named with its place, also where the water comes only later; not without a body force."""
    entries = wet("plane_strain", initial_level=-1.0 if later else 1.3)
    del entries["materials"]["soil"]["saturated_density"]
    with pytest.raises(BadInput) as error:
        tilth.check(Model.from_dict(entries))
    text = str(error.value)
    assert "materials.soil.saturated_density: missing, but at time" in text
    assert f"at time {1 if later else 0:g} the body 'block'" in text
    assert "(0.25, 0.25)" in text
    assert "watertight = true" in text
    tilth.check(Model.from_dict(entries | {"water": {"level": -0.1, "unit_weight": 10.0}}))
    tilth.check(Model.from_dict(entries | {"loads": []}))


def test_densities_that_do_not_fit_together_are_refused() -> None:
    entries = wet("plane_strain")
    soil = entries["materials"]["soil"]
    soil["saturated_density"] = 1.9
    with pytest.raises(BadInput, match=r"saturated_density.* is less than the density 2"):
        Model.from_dict(entries)
    soil |= {"saturated_density": 2.1, "watertight": True}
    with pytest.raises(BadInput, match=r"saturated_density.* watertight material"):
        Model.from_dict(entries)


def test_only_water_has_a_pore_pressure() -> None:
    entries = wet("plane_strain")
    del entries["water"]
    tracked = {"name": "u", "quantity": "pore_pressure", "at": [0.0, 0.0]}
    with pytest.raises(BadInput, match=r"track\[0\].quantity = .*: there is no water"):
        Model.from_dict(entries | {"track": [tracked]})
    with pytest.raises(BadInput, match=r"output.colour_by = .*: no field of this name"):
        Model.from_dict(entries | {"output": {"colour_by": "pore_pressure"}})


def warnings_of(entries: dict[str, Any]) -> list[str]:
    units = {"force": "kN", "stress": "kPa", "mass": "t"}
    return tilth.check(Model.from_dict({**entries, "units": units})).warnings


def test_water_that_is_probably_not_meant_is_warned_of() -> None:
    assert warnings_of(wet("plane_strain")) == []
    (dry,) = warnings_of(wet("plane_strain", -0.5))
    assert dry.startswith("water.level: no soil is under water")
    assert "0.5 below all soil" in dry
    floating = wet("plane_strain")
    del floating["loads"][0]["factor"]
    (floats,) = warnings_of(floating)
    assert "floats" in floats
    floating["water"]["factor"] = [[0.0, 0.0], [1.0, 1.0]]
    assert warnings_of(floating) == []
    weightless = wet("plane_strain")
    del weightless["loads"]
    (light,) = warnings_of(weightless)
    assert light.startswith("water.unit_weight: the water has a weight, but no body force acts")
    twice = wet("plane_strain")
    twice["bodies"][0]["surface"] = {}
    twice["loads"].append(
        {"type": "surface", "body": "block", "start": [2.0, 2.0], "end": [0.0, 2.0],
         "hydrostatic": {"level": 3.0, "unit_weight": 10.0}}
    )  # fmt: skip
    (twice_said,) = warnings_of(twice)
    assert twice_said.startswith("loads[1].hydrostatic: the water of [water] already loads")


def test_the_estimate_of_memory_counts_it() -> None:
    without = wet("3d")
    del without["water"]
    one, other = (
        memory_of(Model.from_dict(each)).parts["the material points"]
        for each in (without, wet("3d"))
    )
    assert other > one + 8 * 50 * 64


def test_a_case_file_names_a_grid_beside_it(tmp_path: Path) -> None:
    """The path of a level is relative to the case file, as those of other files."""
    table_of(tmp_path, 2)
    entries = tilth.load_case(
        Path(__file__).parents[2] / "examples/buoyancy/drawdown.toml"
    ).to_dict()
    assert entries["water"]["initial_level"] == 5.0
    case = Path(__file__).parents[2] / "examples/buoyancy/drawdown.toml"
    text = case.read_text().replace("level = 1.3", 'level = { file = "level.csv" }')
    (tmp_path / "case.toml").write_text(text)
    model = tilth.load_case(tmp_path / "case.toml")
    assert model.water is not None
    assert model.water.level.file == str(tmp_path / "level.csv")  # type: ignore[union-attr]


def test_the_summary_says_what_the_water_is(tmp_path: Path, capsys: Any) -> None:
    """The command prints level and unit weight, and the densities with their units."""
    levels = {
        "level = 1.3": "level from 5 m to 1.3 m",
        "level = [[0.0, 1.0], [9.0, 1.5]]": "level from 5 m to a polyline between 1 and 1.5 m",
    }
    for level, words in levels.items():
        case = Path(__file__).parents[2] / "examples/buoyancy/drawdown.toml"
        (tmp_path / "case.toml").write_text(case.read_text().replace("\nlevel = 1.3", f"\n{level}"))
        assert run_command(["check", str(tmp_path / "case.toml")]) == 0
        said = " ".join(capsys.readouterr().out.split())
        assert f"water {words}, unit weight 10 kN/m^3" in said
        assert "density 1.8 t/m^3, saturated density 2 t/m^3, young" in said
