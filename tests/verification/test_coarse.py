# SPDX-License-Identifier: BSD-3-Clause
"""Reference problems that take long, on coarse grids: within what half a cell of soil may change.

A layer of half a cell moves with a body: it makes it that much larger.
"""

from __future__ import annotations

from typing import Any

import pytest

from tilth_verification import column_collapse, hertz, plate_anchor, seabed_pipe, slope_run_out
from tilth_verification.cases import example, varied, with_basis
from tilth_verification.closed_forms.limit_loads import (
    DEEP_STRIP_ANCHOR,
    SEABED_PIPE_BOUNDS,
    strip_anchor_bound,
)
from tilth_verification.contact_runs import run_contact
from tilth_verification.rotating_disc import turned

pytestmark = pytest.mark.slow

COARSE = (
    "column_collapse",
    "hertz",
    "plate_anchor",
    "rotating_disc",
    "seabed_pipe",
    "slope_run_out",
)
"""The problems of this file."""


def test_a_column_collapses_on_cells_of_a_tenth() -> None:
    found = column_collapse.collapse(column_collapse.column("case.toml", 1.0, cells=10), 1.0)
    assert found.run_out == pytest.approx(column_collapse.plane_fit(1.0), rel=0.25)
    assert all(row.passed for row in column_collapse.rests(found, "coarse"))


def test_a_cylinder_on_elastic_soil_with_five_cells_across_its_contact() -> None:
    """First order: the tolerances of cells of 0.025 m, 1.6 times; half a cell of the half-width."""
    pressure, width, force = hertz.cylinder(0.04)
    assert pressure.error < 1.6 * pressure.tolerance
    assert width.error < 0.5 * 0.04 / 0.1
    assert force.passed


def test_an_anchor_on_cells_of_a_tenth_of_its_width() -> None:
    """Not below a thin plate, and not above one that is larger by half a cell on all sides."""
    model = varied(example("plate_anchor"), {"grid.cell_size": 0.1})
    scale = 2.0 / (plate_anchor.WIDTH * plate_anchor.STRENGTH)
    factor = run_contact(model).curve("plate", 1, scale).force.max()
    thickness = plate_anchor.THICKNESS + 0.1
    upper = strip_anchor_bound(thickness) * (plate_anchor.WIDTH + 0.1) / plate_anchor.WIDTH
    assert 0.95 * DEEP_STRIP_ANCHOR < factor < upper


def test_a_disc_turns_once() -> None:
    """A tenth of the ten turns of the reference problem has its tolerance."""
    kept = turned(with_basis(example("rotating_disc"), "gimp"), 1)
    assert abs(kept.momentum) < 1e-3
    assert abs(kept.energy) < 2e-3
    assert kept.drift < 1e-8


def test_a_pipe_pushed_into_clay_on_cells_of_an_eighth() -> None:
    """Between the lower bound at its depth and the fit half a cell deeper."""
    cells, depth = 8, 0.1
    factor = float(seabed_pipe.push("smooth", cells, to=depth, step=0.01).force[-1])
    lower, _ = SEABED_PIPE_BOUNDS[depth, "smooth"]
    assert lower < factor < seabed_pipe.seabed_pipe(depth + 0.5 / cells, "smooth")


def test_a_slope_that_loses_strength_on_cells_of_a_metre() -> None:
    model = varied(example("slope_run_out"), {"grid.cell_size": 1.0})
    found: Any = slope_run_out.slide(model)
    assert found.before == pytest.approx(slope_run_out.circle_factor(model), rel=0.1)
    assert found.at_rest == pytest.approx(1.0, rel=0.02)
    assert found.moving > 1
    assert found.run_out > 1.0
