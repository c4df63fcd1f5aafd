# SPDX-License-Identifier: BSD-3-Clause
"""A flux of water through lines and planes of the grid: closed forms, areas, and the balance."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from consolidating import with_flow
from small_problems import GRADED, block_entries, plane, rollers

from tilth import run
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.mpm.pore_water import PRESSURE

MODULUS, HEIGHT, FLUX = 1e6, 6.0, 1e-3
AREAS = {"plane_strain": 1.0, "axisymmetric": np.pi, "3d": 1.0}


def column(kind: str = "plane_strain", basis: str = "gimp", height: float = HEIGHT) -> Any:
    """A column of one cell by one, conductivity 1."""
    entries: dict[str, Any] = block_entries(kind, basis, cells=1)
    dim = len(entries["bodies"][0]["shape"]["lower"])
    entries["materials"]["soil"] |= {"young_modulus": MODULUS, "poisson_ratio": 0.0}
    entries["bodies"][0] |= {"surface": {}, "anti_locking": "none"}
    entries["bodies"][0]["shape"]["upper"] = [*[1.0] * (dim - 1), height]
    entries["boundaries"] = rollers(kind, 1.0)
    entries["schedule"] = {"steps": 1, "end": 1e9}
    return entries


def through(name: str, axis: str, at: float, **more: Any) -> dict[str, Any]:
    """A flow boundary on a plane; drained if nothing else is said."""
    return {"name": name, "type": "plane", "axis": axis, "at": at, "condition": "drained", **more}


def pressures(simulation: Simulation) -> tuple[Floats, Floats]:
    """Positions and pressures of the points."""
    points = simulation.state.points
    return points.position, points.water[:, PRESSURE]


@pytest.mark.parametrize("basis", ["linear", "gimp", "cpdi1"])
@pytest.mark.parametrize("source", ["top", "base"])
@pytest.mark.parametrize("kind", AREAS)
def test_a_steady_flux_has_its_gradient(kind: str, source: str, basis: str) -> None:
    """On either side of the soil; in axisymmetry as exact as with a geometry on the same line."""
    upward = "xyz"[2 if kind == "3d" else 1]
    at = {"top": HEIGHT, "base": 0.0}
    sink = "base" if source == "top" else "top"
    given = {"condition": "flux", "flux": 2.0 * FLUX, "factor": [[0.0, 0.5], [1e9, 0.5]]}
    flow = [through(source, upward, at[source], **given), through(sink, upward, at[sink])]
    simulation = Simulation(with_flow(column(kind, basis), flow))
    simulation.check()
    result = simulation.advance(0.0, 1e6)
    position, pressure = pressures(simulation)
    expected = FLUX * np.abs(position[:, -1] - at[sink])
    share = 0.01 if kind == "axisymmetric" else 1e-6
    np.testing.assert_allclose(pressure, expected, rtol=0, atol=share * expected.max())
    assert result.discharge(source) == pytest.approx(-FLUX * AREAS[kind], rel=1e-12)
    assert result.discharge(sink) == pytest.approx(FLUX * AREAS[kind], rel=1e-6)


@pytest.mark.parametrize("basis", ["linear", "gimp"])
def test_the_pressure_before_a_flux_rises_as_by_its_series(basis: str) -> None:
    """From the start to nearly steady; within 1 % of the pressure at the end."""
    entries = column(basis=basis, height=12.0)
    flow = [through("top", "y", 12.0, condition="flux", flux=FLUX), through("base", "y", 0.0)]
    simulation = Simulation(with_flow(entries, flow))
    unit, begun = 12.0**2 / MODULUS, 0.0
    root = np.pi * (np.arange(100) + 0.5)[:, None]
    sign = (-1.0) ** np.arange(100)[:, None]
    for time in (0.05, 0.2, 1.0):
        shares = np.linspace(0.0, 1.0, 41) ** (2.0 if begun == 0.0 else 1.0)
        for before, after in pairwise(unit * (begun + (time - begun) * shares)):
            simulation.advance(before, after)
        begun = time
        position, pressure = pressures(simulation)
        z = position[:, 1] / 12.0
        decaying = 2.0 * sign / root**2 * np.sin(root * z) * np.exp(-(root**2) * time)
        expected = z - decaying.sum(axis=0)
        np.testing.assert_allclose(pressure / (FLUX * 12.0), expected, rtol=0, atol=0.01)


def test_a_flux_through_the_outer_face_of_a_ring() -> None:
    """q R ln(r/a) with the conductivity 1, drained at a; within 1 % of the greatest pressure."""
    entries = column("axisymmetric")
    entries["grid"]["cell_size"] = 0.5
    entries["bodies"][0]["shape"] = {"type": "box", "lower": [2.0, 0.0], "upper": [10.0, 1.0]}
    entries["boundaries"] = [plane("low y", "y", 0.0), plane("high y", "y", 1.0)]
    flow = [through("rim", "x", 10.0, condition="flux", flux=FLUX), through("well", "x", 2.0)]
    simulation = Simulation(with_flow(entries, flow))
    result = simulation.advance(0.0, 1e6)
    position, pressure = pressures(simulation)
    expected = FLUX * 10.0 * np.log(position[:, 0] / 2.0)
    np.testing.assert_allclose(pressure, expected, rtol=0, atol=0.01 * expected.max())
    for name, sign in (("rim", -1.0), ("well", 1.0)):
        assert result.discharge(name) == pytest.approx(sign * FLUX * 20.0 * np.pi, rel=1e-6)


@pytest.mark.parametrize("spacing", ["uniform", "graded"])
def test_a_range_cuts_faces(spacing: str) -> None:
    """Its ends are in the middle of cells; the area is that of the range with soil."""
    entries = column("3d")
    entries["bodies"][0]["shape"] = {"type": "box", "lower": [0.0] * 3, "upper": [3.0, 2.0, 2.0]}
    entries["boundaries"] = [plane("base", "z", 0.0, condition="fixed")]
    if spacing == "graded":
        entries["grid"]["cell_size"] = {"x": GRADED["x"], "y": 1.0, "z": 1.0}
    part = {"x": [0.25, 2.75], "y": [1.5, 9.0]}
    flow = [through("top", "z", 2.0, condition="flux", flux=FLUX, range=part)]
    simulation = Simulation(with_flow(entries, flow))
    result = simulation.advance(0.0, 1e-3)
    assert result.discharge("top") == pytest.approx(-FLUX * 2.5 * 0.5, rel=1e-12)


def test_a_plane_inside_the_soil_feeds_both_of_its_sides() -> None:
    entries = column()
    flow = [
        through("middle", "y", 3.0, condition="flux", flux=FLUX),
        *(through(name, "y", at) for name, at in (("base", 0.0), ("top", HEIGHT))),
    ]
    simulation = Simulation(with_flow(entries, flow))
    result = simulation.advance(0.0, 1e6)
    position, pressure = pressures(simulation)
    np.testing.assert_allclose(
        pressure, FLUX * (3.0 - np.abs(position[:, 1] - 3.0)), rtol=0, atol=1e-6 * 3.0 * FLUX
    )
    assert result.discharge("middle") == pytest.approx(-2.0 * FLUX, rel=1e-12)


def test_no_water_enters_soil_without_pores() -> None:
    """A flux through the base of two columns, one of which lets no water in."""
    entries = column()
    shape = {"type": "box", "lower": [1.0, 0.0], "upper": [3.0, HEIGHT]}
    dry = {"name": "dry", "material": "dry", "shape": shape}
    entries["bodies"].append({**entries["bodies"][0], **dry})
    entries["materials"]["dry"] = dict(entries["materials"]["soil"])
    entries["boundaries"] = rollers("plane_strain", 3.0)
    flow = [through("foot", "y", 0.0, condition="flux", flux=1e-6)]
    result = Simulation(with_flow(entries, flow)).advance(0.0, 1.0)
    assert result.discharge("foot") == pytest.approx(-1e-6, rel=1e-9)


@pytest.mark.parametrize("kind", AREAS)
def test_what_enters_and_leaves_is_what_is_stored(kind: str, tmp_path: Path) -> None:
    """A block that settles by a third of a cell away from the plane with the flux.

    To the tolerance of Newton's iteration; the flux through the plane does not change by that.
    """
    entries = column(kind, height=4.0)
    dim = len(entries["bodies"][0]["shape"]["lower"])
    upward = "xyz"[dim - 1]
    entries["materials"]["soil"] |= {"young_modulus": 100.0, "poisson_ratio": 0.2}
    part: dict[str, Any] = {"start": [1.0, 4.0], "end": [0.0, 4.0]}
    if kind == "3d":
        part = {"part": "z+"}
    entries["loads"] = [{"type": "surface", "body": "block", "pressure": 15.0, **part}]
    flow = [
        through("top", upward, 4.0, condition="flux", flux=0.5), through("base", upward, 0.0),
    ]  # fmt: skip
    entries["analysis"]["tolerance"] = 1e-9
    entries["schedule"] = {"steps": 4, "end": 0.4}
    entries["track"] = [
        *({"name": name, "quantity": "drained_volume", "boundary": name}
          for name in ("top", "base")),
        {"name": "stored", "quantity": "stored_water"},
        {"name": "settlement", "quantity": "displacement", "body": "block", "component": upward,
         "at": [0.5] * (dim - 1) + [4.0]},
    ]  # fmt: skip
    entries["output"] = {"report": False}
    result = run(with_flow(entries, flow), tmp_path / "run", threads=1, quiet=True)
    history = {name.split(" [")[0]: column for name, column in result.history.items()}
    water, drained = history["stored"], history["top"] + history["base"]
    np.testing.assert_allclose(drained, water[0] - water, rtol=0, atol=1e-9 * water[0])
    np.testing.assert_allclose(history["top"], -0.5 * AREAS[kind] * history["time"], rtol=1e-12)
    assert history["base"][-1] > 0.1 * AREAS[kind]
    assert history["settlement"][-1] < -1.0 / 3.0


def test_a_flux_through_the_axis_is_refused() -> None:
    flow = [through("well", "x", 0.0, condition="flux", flux=FLUX)]
    with pytest.raises(BadInput, match="axis of symmetry, which has no area") as error:
        with_flow(column("axisymmetric"), flow)
    assert error.value.key == "flow.boundaries[0].at"
    assert "radius > 0" in str(error.value.remedy)
