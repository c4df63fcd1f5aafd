# SPDX-License-Identifier: BSD-3-Clause
"""Base motion of a shear column on rigid and on elastic rock, and pulses that leave a bar."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tilth.analysis.energies import Energies
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.model import Model
from tilth.variation.csv_file import read_csv
from tilth_verification.cases import example, folder_of_cases, varied
from tilth_verification.comparison import Comparison, relative, vanishing

PROBLEM = "shear_column"
HEIGHT, SPEED = 20.0, 200.0
"""Of the column [m] and of shear waves in it [m/s]."""
CELLS = 40
LOWEST = SPEED / (4.0 * HEIGHT)
"""Lowest natural frequency on rigid rock [Hz]."""
IMPEDANCE_RATIO = 2000.0 * SPEED / (2400.0 * 800.0)
"""Of the soil over that of the rock of case.toml."""
KRAMER = "S.L. Kramer, Geotechnical Earthquake Engineering, 1996, section 7.2"


def comparisons(long: bool) -> Iterator[Comparison]:
    """Harmonic motions, a wavelet, pulses; long: another frequency, rigid rock, finer grids."""
    quantity = "amplitude of top over base, rigid rock, 0.5 times the lowest frequency"
    source, exact = f"{KRAMER}: 1/cos kH", 1.0 / math.cos(0.25 * math.pi)
    yield relative(quantity, amplitude("rigid.toml", 0.5), exact, 5e-3, source)
    for share in (0.5, 1.0) if long else (0.5,):
        angle = 0.5 * math.pi * share
        exact = 1.0 / math.hypot(math.cos(angle), IMPEDANCE_RATIO * math.sin(angle))
        quantity = f"amplitude of top over outcrop, {share:g} times the lowest frequency"
        yield relative(quantity, amplitude("case.toml", share), exact, 5e-3, KRAMER)
    rocks = (("case.toml", "elastic"), ("rigid.toml", "rigid"))
    for file, rock in rocks if long else rocks[:1]:
        for cells in (CELLS, 2 * CELLS) if long else (CELLS,):
            quantity = f"error of the top's acceleration in L2, wavelet, {rock} rock, {cells} cells"
            yield vanishing(quantity, wavelet_error(file, cells), 0.03, "d'Alembert")
    source = "Lysmer and Kuhlemeyer 1969: exact at right angles"
    for name, changes, tolerance in pulses(long):
        quantity = f"energy left after a pulse has met the ends, {name}"
        yield vanishing(quantity, left_of_pulse(changes), tolerance, source)


def amplitude(file: str, share: float) -> float:
    """Returns the amplitude of the top's acceleration over that of a harmonic record.

    share: of the lowest frequency on rigid rock.
    """
    frequency = share * LOWEST
    size, end = 1.0 / (40.0 * frequency), 16.0 / LOWEST
    steps = round(end / size)
    end = steps * size
    time = np.linspace(0.0, end, 2 * steps + 1)
    grown = np.minimum(time / (0.3 * end), 1.0)
    grown = grown**3 * (10.0 - 15.0 * grown + 6.0 * grown**2)
    omega = 2.0 * math.pi * frequency
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "record.csv"
        rows = np.column_stack([time, 0.1 * grown * np.sin(omega * time)])
        np.savetxt(record, rows, "%.17g", ",", header="time,x", comments="")
        model = varied(
            example(PROBLEM, file),
            {
                "boundaries.0.acceleration.file": str(record),
                "grid.cell_size": 2.0 * HEIGHT / CELLS,
                "bodies.0.shape.upper": [2.0 * HEIGHT / CELLS, HEIGHT],
                "boundaries.2.at": 2.0 * HEIGHT / CELLS,
                "schedule": {"end": end, "steps": steps},
            },
        )
        at, top = acceleration_of_top(model)
    late = at > 0.7 * end
    rates = {omega, 2.0 * math.pi * LOWEST}  # what is left of a free vibration is told apart
    waves = [wave(rate * at[late]) for rate in sorted(rates) for wave in (np.sin, np.cos)]
    parts, *_ = np.linalg.lstsq(np.column_stack(waves), top[late], rcond=None)
    first = 2 * sorted(rates).index(omega)
    return float(np.hypot(*parts[first : first + 2])) / 0.1


def acceleration_of_top(model: Model) -> tuple[Floats, Floats]:
    """Returns times [s] and the acceleration of the topmost points [m/s^2], shape (steps,) each.

    They are half a point's height below the surface, which matters less than 2e-4.
    """
    rows: list[tuple[float, float]] = []

    def after_step(simulation: Simulation, result: object, time: float) -> None:
        points = simulation.state.points
        rows.append((time, float(points.motion[points.position[:, 1].argmax(), 1, 0])))

    march(model, after_step)
    time, value = np.array(rows).T
    return time, value


def wavelet_error(file: str, cells: int) -> float:
    """Returns the error of the top's acceleration in L2 over its norm, under the wavelet."""
    size = HEIGHT / cells
    changes = {
        "grid.cell_size": size,
        "bodies.0.shape.upper": [size, HEIGHT],
        "boundaries.2.at": size,
        "schedule": {"end": 2.0, "steps": 10 * cells},
    }
    time, top = acceleration_of_top(varied(example(PROBLEM, file), changes))
    exact = closed_form(file, time)
    return float(np.linalg.norm(top - exact) / np.linalg.norm(exact))


def closed_form(file: str, time: Floats) -> Floats:
    """Returns the acceleration of the top [m/s^2] by d'Alembert's waves, shape (n,).

    A wave comes up and is doubled at the top; what goes down is reflected at the base, by -1 on
    rigid rock.
    """
    record = str(folder_of_cases() / PROBLEM / "record.csv")
    _, table = read_csv(record, "", "", "", lambda names: True)
    elastic = file == "case.toml"
    reflected = (IMPEDANCE_RATIO - 1.0) / (IMPEDANCE_RATIO + 1.0) if elastic else -1.0
    share = 1.0 / (1.0 + IMPEDANCE_RATIO) if elastic else 1.0
    top, way = np.zeros_like(time), HEIGHT / SPEED
    for number in range(math.ceil(time[-1] / way)):
        delay = (2 * number + 1) * way
        came = np.interp(time - delay, table[:, 0], table[:, 1], left=0.0, right=0.0)
        top += 2.0 * share * reflected**number * came
    return top


def pulses(long: bool) -> Iterator[tuple[str, dict[str, Any], float]]:
    """Yields names of pulses, changes of the case file, and the energy that may be left."""
    yield "bar turned by 30 degrees, implicit ends", {}, 1e-4
    straight: dict[str, Any] = {
        "bodies.0.shape.angle": 0.0,
        "initial.velocity.0.x": _velocity("of_straight_bar"),
        "initial.velocity.0.y": None,
        "boundaries": [
            {"name": name, "type": "plane", "axis": "x", "at": at, "condition": "absorbing"}
            for name, at in (("lower", 0.0), ("upper", 1.0))
        ],
    }
    yield "ends on lines of the grid", straight, 1e-5
    if not long:
        return
    cpdi = {"bodies.0.basis": "cpdi2", "bodies.0.domain_update": None}
    yield "bar turned by 30 degrees, CPDI2", cpdi, 1e-4
    sides = [
        {"name": name, "type": "plane", "axis": "y", "at": at, "condition": "fixed",
         "components": ["x"]}
        for name, at in (("below", 0.0), ("above", 0.1))
    ]  # fmt: skip
    shear = {
        "materials.steel.young_modulus": 2e7,
        "initial.velocity.0.x": None,
        "initial.velocity.0.y": _velocity("of_straight_bar"),
        "boundaries": [*straight["boundaries"], *sides],
    }
    yield "shear pulse, ends on lines of the grid", straight | shear, 1e-5


def _velocity(function: str) -> str:
    return f"{folder_of_cases() / PROBLEM / 'pulse.py'}:{function}"


def left_of_pulse(changes: dict[str, Any]) -> float:
    """Returns kinetic and elastic energy at the end over that at the start."""
    model = varied(example(PROBLEM, "pulse.toml"), changes)
    simulation = Simulation(model)
    first = Energies.at_start(simulation.setup, simulation.state).start
    points = march(model).state.points
    return (points.kinetic_energy(points.mass) + points.stored_energy()) / first
