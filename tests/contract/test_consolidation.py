# SPDX-License-Identifier: BSD-3-Clause
"""Consolidation by the terms of pore water against answers from outside."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from consolidating import Pores, with_flow, with_pores
from scipy.optimize import brentq
from small_problems import block_entries, plane, rollers

from tilth import Model
from tilth.analysis.initial_equilibrium import find_initial_equilibrium
from tilth.analysis.pore_pressure import PorePressure
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.mpm.pore_water import CONSTANT, PRESSURE, Permeability
from tilth.mpm.soil import COMPRESSION
from tilth_verification import mandel, terzaghi
from tilth_verification.cases import example, varied, with_basis
from tilth_verification.consolidating import consolidate

NU = 0.2
SHEAR = 1000.0 / (2.0 * (1.0 + NU))
CONSTRAINED = 2.0 * SHEAR * (1.0 - NU) / (1.0 - 2.0 * NU)


class Mandel:
    """A slab of half width 1 between rigid plates, drained at its sides (Mandel 1953).

    Incompressible water, as in Cheng and Detournay (1988); T is time times kappa M. Forces are over
    the mean stress under the plate, pressures over half of it.
    """

    def __init__(self) -> None:
        slope = (1.0 - NU) / (0.5 - NU)
        low = np.pi * np.arange(200) + 1e-6
        self.roots = np.array(
            [brentq(lambda a: np.tan(a) - slope * a, x, x + 0.5 * np.pi - 2e-6) for x in low]
        )
        sine, cosine = np.sin(self.roots), np.cos(self.roots)
        self._share = sine / (self.roots - sine * cosine)

    def strain(self, time: float) -> float:
        """Vertical strain times G over the stress, compression positive."""
        terms = self._share * np.cos(self.roots) * np.exp(-(self.roots**2) * time)
        return float(0.5 * (1.0 - NU) - 0.5 * terms.sum()) if time > 0.0 else 0.0

    def pressure(self, x: float, time: float) -> float:
        """At a distance from the middle."""
        shape = np.cos(self.roots * x) - np.cos(self.roots)
        return float(2.0 * (self._share * shape * np.exp(-(self.roots**2) * time)).sum())


def test_the_series_is_that_of_another_computation() -> None:
    """Finite volumes gave these for T = 0.1."""
    mandel = Mandel()
    assert mandel.strain(0.1) == pytest.approx(0.28731, abs=1e-5)
    assert mandel.pressure(0.0, 0.1) == pytest.approx(1.09541, abs=1e-5)
    assert mandel.pressure(0.5, 0.1) == pytest.approx(0.86090, abs=1e-5)


@pytest.mark.parametrize(("basis", "bound"), [("linear", 0.004), ("gimp", 0.008)])
def test_pressure_rises_before_it_falls_as_by_mandel(basis: str, bound: float) -> None:
    """A quarter of the slab, eight cells wide; the plate moves as in the solution.

    The greatest pressure, and the force on the plate, which stays.
    """
    mandel, width, stress = Mandel(), 8.0, 1e-4 * SHEAR
    unit = width**2 / CONSTRAINED
    times = [0.0, *np.geomspace(1e-3, 0.1, 30)]
    motion = [[unit * time, mandel.strain(time)] for time in times]
    entries = block_entries("plane_strain", basis)
    entries["materials"]["soil"] |= {"young_modulus": 1000.0, "poisson_ratio": NU}
    entries["bodies"][0]["shape"]["upper"] = [width, 2.0]
    plate = plane("plate", "y", 2.0, condition="prescribed", factor=motion)
    plate["displacement"] = {"y": -2.0 * stress / SHEAR}
    entries["boundaries"] = [plane("middle", "x", 0.0), plane("low", "y", 0.0), plate]
    entries["schedule"] = {"steps": 1, "end": 1e9}
    pores = Pores(drained=lambda x: x[:, 0] > width - 1e-9)
    simulation = with_pores(Model.from_dict(entries), pores)
    found, force = [], []
    for before, after in pairwise(times):
        result = simulation.advance(unit * before, unit * after)
        middle = np.abs(result.active.position - [0.0, 1.0]).max(axis=1).argmin()
        found.append(float(pores.value[middle, 0]) / (0.5 * stress))
        force.append(-float(result.resultant("plate")[1]) / (stress * width))
    expected = [mandel.pressure(0.0, time) for time in times[1:]]
    assert max(expected) > 1.1
    assert max(found) == pytest.approx(max(expected), rel=bound)
    np.testing.assert_allclose(found[10:], expected[10:], rtol=2.0 * bound)
    np.testing.assert_allclose(force[10:], 1.0, rtol=0.012)


CENTRES = {
    "plane_strain": {0.05: 1.18226, 0.1: 1.10732, 0.2: 0.77614},
    "axisymmetric": {0.05: 1.36372, 0.1: 1.19410, 0.2: 0.68173},
}
"""Kind -> T -> pressure at the axis of a cylinder (de Leeuw 1964), or the centre of a sphere (Cryer
1963), over the load on the drained rim, for Poisson's ratio 0.2. By eigenvalues and by inversion of
the Laplace transform, 7 digits."""


def at_centre(
    kind: str, basis: str, radius: float, pores: Pores | PorePressure | None = None, drain: str = ""
) -> dict[float, float]:
    """Pressure at the centre of a quarter, in cells of size 1, over the load on the rim.

    Drained at its rim, a circle or the tracked surface, by the input, if there are no other pores.
    """
    entries = block_entries(kind, basis)
    entries["materials"]["soil"] |= {"young_modulus": 1000.0, "poisson_ratio": NU}
    angle = np.linspace(0.0, 0.5 * np.pi, 91)
    rim = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    rim[0, 1] = rim[-1, 0] = 0.0
    shape = {"type": "polygon", "vertices": [[0.0, 0.0], *rim.tolist()]}
    entries["bodies"][0] |= {"shape": shape, "surface": {}}
    axis = [plane("low x", "x", 0.0)] if kind == "plane_strain" else []
    entries["boundaries"] = [*axis, plane("low y", "y", 0.0)]
    stress = 1e-4 * SHEAR
    entries["loads"] = [
        {"type": "surface", "body": "block", "pressure": stress, "factor": [[0, 1], [1e9, 1]],
         "start": [radius, 0.0], "end": [0.0, radius]}
    ]  # fmt: skip
    entries["schedule"] = {"steps": 1, "end": 1e9}
    if pores is None:
        circle = {"type": "circle", "centre": [0.0, 0.0], "radius": radius, "soil": "inside"}
        boundary = {"type": "implicit", "geometry": circle}
        if drain == "surface":
            boundary = {key: entries["loads"][0][key] for key in ("type", "body", "start", "end")}
        boundary |= {"name": "rim", "condition": "drained"}
        simulation = Simulation(with_flow(entries, [boundary]))
        assert simulation.state.pore_pressure is not None
        pores = simulation.state.pore_pressure
    else:
        assert isinstance(pores, Pores)
        simulation = with_pores(Model.from_dict(entries), pores)
    found, unit = {}, radius**2 / CONSTRAINED
    times = [0.0, 1e-4, *np.geomspace(1e-3, 0.01, 8), *np.linspace(0.01, 0.2, 39)[1:]]
    for before, after in pairwise(times):
        result = simulation.advance(unit * before, unit * after)
        centre = np.abs(result.active.position).max(axis=1).argmin()
        found[round(after, 9)] = float(pores.value[centre, 0]) / stress
    return found


RIMS = [
    *((basis, radius, "implicit") for basis in ("linear", "gimp") for radius in (7.9, 8.3)),
    ("gimp", 8.3, "surface"),
]


@pytest.mark.parametrize(("basis", "radius", "drain"), RIMS)
@pytest.mark.parametrize(("kind", "bound"), [("plane_strain", 0.012), ("axisymmetric", 0.02)])
def test_a_drained_rim_that_cuts_cells_anywhere(
    kind: str, bound: float, basis: str, radius: float, drain: str
) -> None:
    """About eight cells to the centre; errors over the load."""
    found = at_centre(kind, basis, radius, drain=drain)
    for time, expected in CENTRES[kind].items():
        assert found[time] == pytest.approx(expected, abs=bound)


def test_no_pressure_at_the_nodes_outside_drains_too_late() -> None:
    """The usual practice, for comparison: the rim is then up to a cell too far away."""
    pores = Pores(drained=lambda x: np.hypot(*x.T) > 8.3)
    found = at_centre("plane_strain", "gimp", 8.3, pores)
    assert found[0.05] < CENTRES["plane_strain"][0.05] - 0.05
    assert found[0.2] > CENTRES["plane_strain"][0.2] + 0.1


KOZENY_CARMAN = Permeability("kozeny_carman")
TAYLOR, POWER = Permeability("taylor", 0.75), Permeability("power", 3.0)
LARGE_STRAIN = {
    (0.1, CONSTANT): {0.2: (0.07317, 0.04932), 0.5: (0.02844, 0.07310)},
    (0.5, CONSTANT): {0.1: (0.43960, 0.16429), 0.2: (0.25553, 0.22932)},
    (0.5, KOZENY_CARMAN): {0.2: (0.43341, 0.13970), 0.5: (0.27688, 0.21296)},
    (0.5, TAYLOR): {0.2: (0.46166, 0.11107), 0.5: (0.36205, 0.17276)},
    (0.5, POWER): {0.2: (0.44661, 0.12627), 0.5: (0.31719, 0.19433)},
}
"""(load, permeability) -> time -> pressure at the base and settlement, with modulus, height and
conductivity 1, n0 = 0.6; by finite volumes in material coordinates, 200 cells and 1,600 steps."""


SETTLING = [
    *((*case, "base") for case in LARGE_STRAIN),
    *((0.5, permeability, "surface") for permeability in (CONSTANT, KOZENY_CARMAN, TAYLOR)),
]


@pytest.mark.parametrize(("load", "permeability", "drain"), SETTLING)
def test_a_column_that_settles_by_up_to_a_quarter(
    load: float, permeability: Permeability, drain: str
) -> None:
    """Within 1 % of the load and of the final settlement; 16 cells.

    Drained at its base, which is on a line of the grid, or at its surface, which moves with the
    loaded top through the cells; the pressure is that at the other end.
    """
    height = 16
    entries: dict[str, Any] = block_entries("plane_strain", "gimp")
    entries["materials"]["soil"] |= {"young_modulus": 1.0, "poisson_ratio": 0.0}
    entries["bodies"][0] |= {"surface": {}, "anti_locking": "none"}
    entries["bodies"][0]["shape"]["upper"] = [1.0, float(height)]
    entries["boundaries"] = rollers("plane_strain", 1.0)
    top = {"type": "surface", "body": "block", "start": [1.0, height], "end": [0.0, height]}
    entries["loads"] = [{**top, "pressure": load, "factor": [[0, 1], [1e9, 1]]}]
    entries["analysis"]["tolerance"] = 1e-8
    entries["schedule"] = {"steps": 1, "end": 1e9}
    base = {"type": "plane", "axis": "y", "at": 0.0}
    drained = {"name": "drain", "condition": "drained", **(base if drain == "base" else top)}
    water: dict[str, Any] = {"porosity": 0.6, "permeability": permeability.law}
    if permeability in (TAYLOR, POWER):
        index = "change_index" if permeability is TAYLOR else "exponent"
        water[f"permeability_{index}"] = permeability.parameter
    simulation = Simulation(with_flow(entries, [drained], **water))
    unit, final = float(height**2), 1.0 - float(brentq(lambda s: np.log(s) / s + load, 0.2, 1.0))
    begun = 0.0
    for time, (pressure, settlement) in LARGE_STRAIN[load, permeability].items():
        shares = np.linspace(0.0, 1.0, 61) ** (2.0 if begun == 0.0 else 1.0)
        for before, after in pairwise(unit * (begun + (time - begun) * shares)):
            simulation.advance(before, after)
        points, begun = simulation.state.points, time
        y = points.position[:, 1]
        farthest = points.water[y.argmax() if drain == "base" else y.argmin(), PRESSURE]
        assert farthest == pytest.approx(pressure, abs=0.01 * load)
        assert 1.0 - top_of(simulation) / height == pytest.approx(settlement, abs=0.01 * final)


def top_of(simulation: Any) -> float:
    points = simulation.state.points
    ends: Floats = points.position[:, 1] + points.half_length[:, 1]
    return float(ends.max())


def test_soil_that_has_settled_stays() -> None:
    """Steps in which next to nothing flows: what is stored is the difference of two volumes."""
    model = terzaghi.column(8, 20, time=40.0, load=20.0)
    found = consolidate(model, [[0.0, terzaghi.HEIGHT]])
    assert abs(found.pressure[-1][0]) < 1e-6
    late = found.settlement(terzaghi.HEIGHT / 8)[-3:]
    np.testing.assert_allclose(late, late[-1], rtol=1e-9)


def test_a_drained_plane_that_domains_cross_by_a_little() -> None:
    """Soil that widens reaches nodes beyond it; they tell nothing of the gradient before it."""
    found = []
    for basis in ("linear", "gimp"):
        model, _, _ = mandel.slab(8, NU)
        found.append(mandel.run(with_basis(model, basis)).pressure[-1])
    np.testing.assert_allclose(*found, rtol=1e-4)


@pytest.mark.parametrize("share", [0.01, 0.1])
def test_normally_consolidated_clay_does_not_overshoot(share: float) -> None:
    """The load is doubled in a step of `share` l^2 / c, c with the elastic modulus.

    In its first compression the clay has a fifth of that modulus: a projection by the elastic one
    lets the pressure beside the drain rise to 1.30 of the load.
    """
    model = example("cam_clay_consolidation")
    step = share * 0.0625**2 / (1e-5 * 5333.0)
    rows = [[0.0, 1.0], [step, 1.0], [2.0 * step, 2.0], [1000.0, 2.0]]
    entries = {"loads.0.factor": rows, "schedule": {"end": 100.0, "steps": 1}, "track": []}
    simulation = Simulation(varied(model, entries))
    find_initial_equilibrium(simulation)
    for k in range(4):
        simulation.advance(k * step, (k + 1) * step)
        pressure = simulation.state.points.water[:, PRESSURE] / 100.0
        assert pressure.min() > -0.02
        assert pressure.max() < 1.05


@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric", "3d"])
def test_modulus_of_soil_that_yields_in_compression(kind: str) -> None:
    """By differences of the stress at that strain; in elastic soil it is the elastic one."""
    entries = block_entries(kind, "gimp", "hencky_elastic")
    elastic = Simulation(Model.from_dict(entries))
    soil = elastic.soil_on(elastic.prepare(0.0, 1.0).active)
    np.testing.assert_allclose(soil.compressed_moduli(), soil.elastic_moduli.constrained, rtol=1e-9)
    entries = block_entries(kind, "gimp", "modified_cam_clay")
    entries["materials"]["soil"] |= {"preconsolidation_pressure": 100.0}
    stress = [-100.0, -100.0, -100.0] + [0.0] * (3 if kind == "3d" else 1)
    given = {"type": "given", "body": "block", "stress": stress}
    entries["initial"] = {"stress": [given], "equilibrium": False}
    clay = Simulation(Model.from_dict(entries))
    active = clay.prepare(0.0, 1.0).active
    vertical = []
    for strain in (COMPRESSION * (1.0 + 1e-3), COMPRESSION * (1.0 - 1e-3)):
        moved = clay.soil_on(active)
        displacement = np.zeros((active.nodes, active.grid.dim))
        displacement[:, -1] = -strain * active.position[:, -1]
        moved.update(displacement)
        moved.advance(displacement, moved.moved_domains(displacement))
        points = moved.points
        axis = active.grid.dim - 1
        kirchhoff = points.stress[0, axis] * points.stress_jacobian[0]
        vertical.append((np.log(1.0 - strain), kirchhoff))
        clay = Simulation(Model.from_dict(entries))
        active = clay.prepare(0.0, 1.0).active
    (one, tau_one), (other, tau_other) = vertical
    found = clay.soil_on(active).compressed_moduli()
    assert found[0] < 0.6 * clay.state.points.elastic_moduli().constrained[0]
    np.testing.assert_allclose(found, (tau_one - tau_other) / (one - other), rtol=1e-3)
