# SPDX-License-Identifier: BSD-3-Clause
"""Water that moves from stage to stage: balance, results and pictures, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_problems import block_entries, rollers, weight

import tilth.analysis.staged
from tilth import BadInput, Model, run
from tilth.output import read_history, read_results
from tilth.report.setup_file import read_staged_setup


def staged(**of_last: Any) -> dict[str, Any]:
    """A stiff block of 2 by 2 m: weight and water grow together, stand, and the water falls."""
    entries = block_entries("plane_strain", "gimp", boundaries=rollers("plane_strain"))
    entries["loads"] = [weight("plane_strain", 10.0) | {"name": "gravity"}]
    entries["materials"]["soil"] |= {"saturated_density": 2.2, "young_modulus": 1e8}
    entries["water"] = {"level": 1.7, "unit_weight": 10.0, "factor": [[0.0, 0.0], [1.0, 1.0]]}
    del entries["schedule"]
    entries["stages"] = [
        {"name": "fill", "schedule": {"steps": 2}},
        {"name": "rest", "schedule": {"steps": 1}},
        {"name": "draw down", "schedule": {"steps": 4, "end": 2.0},
         "water": {"level": 0.3, "unit_weight": 10.0}, **of_last},
    ]  # fmt: skip
    entries["output"] = {"report": False}
    entries["track"] = [
        {"name": "base", "quantity": "reaction", "boundary": "low y", "component": "y"},
        {"name": "u", "quantity": "pore_pressure", "at": [0.25, 0.25]},
    ]
    return entries


def test_the_base_carries_the_effective_weight_in_all_stages(tmp_path: Path) -> None:
    """The water keeps its factor in later stages, and falls from where it was."""
    result = run(Model.from_dict(staged()), tmp_path / "out", quiet=True)
    history = read_history(result.folder / "history.csv")
    time = np.asarray(history["time"], dtype=float)
    share = np.minimum(time, 1.0)
    level = 1.7 - 0.7 * np.maximum(time - 2.0, 0.0)
    expected = share * 2.0 * (12.0 * level + 20.0 * (2.0 - level))
    np.testing.assert_allclose(history["base [N/m]"], expected, rtol=0, atol=1e-5)
    pressure = 10.0 * share * np.maximum(level - 0.25, 0.0)
    np.testing.assert_allclose(history["u [Pa]"], pressure, rtol=0, atol=1e-4)
    results = read_results(result.folder / "results.vtkhdf")
    last = results.snapshot(-1)
    np.testing.assert_allclose(
        last.point_fields["pore_pressure"],
        10.0 * np.maximum(0.3 - last.position[:, 1], 0.0),
        atol=1e-12,
    )
    setup = read_staged_setup(result.folder / "setup.npz")
    assert setup is not None
    for moment, height in ((0.5, 1.7), (2.0, 1.7), (3.0, 1.0), (4.0, 0.3)):
        line = setup.water_at(moment)
        assert line is not None
        np.testing.assert_allclose(line[:, 1], height)


def test_water_that_comes_in_a_later_stage(tmp_path: Path) -> None:
    """All outputs have its fields; the soil before is dry."""
    entries = staged()
    del entries["water"]
    result = run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    results = read_results(result.folder / "results.vtkhdf")
    first, last = results.snapshot(0), results.snapshot(-1)
    assert not first.point_fields["pore_pressure"].any()
    assert last.point_fields["pore_pressure"].any()
    found = results.snapshot(1).point_fields
    np.testing.assert_array_equal(found["effective_stress"], found["cauchy_stress"])
    history = read_history(result.folder / "history.csv")
    assert history["base [N/m]"][-1] == pytest.approx(2.0 * (12.0 * 0.3 + 20.0 * 1.7), rel=1e-6)
    setup = read_staged_setup(result.folder / "setup.npz")
    assert setup is not None
    assert setup.water_at(1.5) is None
    assert setup.water_at(4.0) is not None


@pytest.mark.slow
def test_going_on_from_a_stage_with_water_that_was_not_there(tmp_path: Path) -> None:
    """The outputs of the earlier stages get the fields of water."""
    dry = staged()
    del dry["water"], dry["stages"][2]["water"], dry["track"][1]
    wet = staged()
    del wet["water"], wet["track"][1]
    run(Model.from_dict(dry), tmp_path / "dry", quiet=True)
    whole = run(Model.from_dict(wet), tmp_path / "whole", quiet=True)
    gone_on = run(
        Model.from_dict(wet), tmp_path / "on", from_stage=(tmp_path / "dry", "rest"), quiet=True
    )
    for one, other in zip(
        read_results(whole.folder / "results.vtkhdf"),
        read_results(gone_on.folder / "results.vtkhdf"),
        strict=True,
    ):
        assert one.point_fields.keys() == other.point_fields.keys()
        for name, values in one.point_fields.items():
            np.testing.assert_array_equal(values, other.point_fields[name])


def test_a_stage_that_floods_soil_without_a_density_for_it_is_refused() -> None:
    """One message with the material, the place and the stage, before anything is computed."""
    entries = staged(water={"level": 1.0, "unit_weight": 10.0})
    del entries["materials"]["soil"]["saturated_density"], entries["water"]
    entries["track"] = []
    with pytest.raises(BadInput) as error:
        tilth.analysis.staged.StagedAnalysis(Model.from_dict(entries)).check()
    text = str(error.value)
    assert "materials.soil.saturated_density" in text
    assert "missing" in text
    assert "below the water at (0.25, 0.25)" in text
    assert "draw down" in text


def test_a_polyline_in_a_stage_is_for_the_plane_too() -> None:
    entries = staged()
    entries["stages"][2]["water"]["level"] = [[0.0, 0.3], [0.0, 0.5]]
    with pytest.raises(BadInput, match=r"stages\[2\]\.water\.level.*increase"):
        Model.from_dict(entries)
