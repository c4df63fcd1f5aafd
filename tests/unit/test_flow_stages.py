# SPDX-License-Identifier: BSD-3-Clause
"""Flowing water through the stages of an analysis: it stops, flows, is dug, comes and stays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from resumed_runs import assert_same_results, run_in_pieces
from staged_problems import KINDS, box, roller

from tilth import Model, run
from tilth.analysis.staged import StagedAnalysis
from tilth.mpm.pore_water import CONDUCTIVITY, POROSITY, PRESSURE, STORED

LOAD = 4.0


def entries_of(kind: str = "plane_strain") -> dict[str, Any]:
    """Soft ground on a drain with a block of concrete on it, and fill that comes and is loaded.

    The stages are "undrained", "consolidate", "fill", "dig" and "firm".
    """
    dim = 3 if kind == "3d" else 2
    up = "z" if dim == 3 else "y"
    wet = {
        "model": "hencky_elastic", "young_modulus": 200.0, "poisson_ratio": 0.2, "density": 0.0,
        "porosity": 0.5, "hydraulic_conductivity": 1e-2,
    }  # fmt: skip
    boundaries = [roller(up, 0.0, "base"), roller("x", 3.0, "side")]
    if kind != "axisymmetric":
        boundaries.append(roller("x", 0.0, "left"))
    if dim == 3:
        boundaries += [roller("y", 0.0), roller("y", 0.5)]
    where = {"part": "z+"} if dim == 3 else {"start": [1.0, 2.0], "end": [0.0, 2.0]}
    load = {"name": "load", "type": "surface", "body": "block", "pressure": LOAD, **where}
    return {
        "title": "flow in stages",
        "units": {"time": "s"},
        "analysis": {"kind": kind, "tolerance": 1e-10},
        "grid": {"cell_size": 0.5},
        "flow": {
            "unit_weight": 10.0,
            "boundaries": [
                {"name": "drain", "type": "plane", "axis": up, "at": 0.0, "condition": "drained"}
            ],
        },
        "materials": {
            "clay": wet | {"permeability": "kozeny_carman"},
            "sand": wet | {"hydraulic_conductivity": 1e-1, "young_modulus": 400.0},
            "concrete": {"model": "hencky_elastic", "young_modulus": 1e3, "poisson_ratio": 0.2,
                         "density": 0.0},
        },
        "bodies": [
            box("ground", [0.0, 0.0], [3.0, 1.5], dim, material="clay"),
            box("block", [0.0, 1.5], [1.0, 2.0], dim, material="concrete", surface={}),
            box("bank", [1.0, 1.5], [3.0, 2.0], dim, material="sand"),
        ],
        "boundaries": boundaries,
        "loads": [load],
        "stages": [
            {"name": "undrained", "schedule": {"steps": 2, "end": 1.0}, "flow": False},
            {"name": "consolidate", "schedule": {"steps": 3, "end": 3.0}},
            {"name": "fill", "schedule": {"steps": 2, "end": 1.0}, "activate": ["bank"]},
            {"name": "firm", "schedule": {"steps": 2, "end": 1.0}, "materials": {"clay": "sand"},
             "grid": {"cell_size": 0.25}},
            {"name": "dig", "schedule": {"steps": 2, "end": 1.0}, "deactivate": ["bank"]},
        ],
        "output": {"report": False},
        "track": [
            {"name": "base", "quantity": "reaction", "boundary": "base", "component": up},
            {"name": "block", "quantity": "displacement", "body": "block", "component": up,
             "at": [0.5, 0.25, 1.75] if dim == 3 else [0.5, 1.75]},
        ],
    }  # fmt: skip


@pytest.mark.parametrize("scheme", ["backward_euler", "bdf2"])
@pytest.mark.parametrize("kind", KINDS)
def test_water_in_stages(kind: str, scheme: str) -> None:
    entries = entries_of(kind)
    entries["flow"]["scheme"] = scheme
    model = Model.from_dict(entries)
    analysis = StagedAnalysis(model)
    found: dict[str, Any] = {}
    volume: dict[str, float] = {}
    for _ in analysis.steps():
        stage = analysis.setup.model.stage.name
        points = analysis.state.points
        ground = points.of_body("ground")
        found[stage] = points.water[ground].copy()
        volume[stage] = float(points.initial_volume[ground] @ points.water[ground, STORED])
        assert not points.water[points.of_body("block")].any()
        pressure = analysis.state.pore_pressure  # of nodes that hardly any wet soil reaches, too
        assert pressure is not None
        assert np.abs(pressure.value).max() < 2.0 * LOAD
    assert set(found) == {"undrained", "consolidate", "fill", "firm", "dig"}
    whole = 0.5 * float(points.initial_volume[ground].sum())
    assert volume["undrained"] == pytest.approx(whole, abs=1e-9 * whole)
    assert found["undrained"][:, PRESSURE].max() > 0.3 * LOAD
    assert volume["consolidate"] < whole * (1.0 - 1e-3)
    assert found["consolidate"][:, PRESSURE].max() < found["undrained"][:, PRESSURE].max()
    assert (found["firm"][:, CONDUCTIVITY] == 10.0 * found["fill"][:, CONDUCTIVITY]).all()
    np.testing.assert_array_equal(found["firm"][:, POROSITY], found["fill"][:, POROSITY])


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["backward_euler", "bdf2"])
@pytest.mark.parametrize("kind", KINDS)
def test_resumed_after_any_step(
    kind: str, scheme: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entries = entries_of(kind)
    entries["flow"]["scheme"] = scheme
    model = Model.from_dict(entries)
    run(model, tmp_path / "whole", quiet=True)
    run_in_pieces(model, tmp_path / "out", range(1, 11), monkeypatch)
    assert_same_results(tmp_path / "whole", tmp_path / "out")
