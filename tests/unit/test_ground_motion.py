# SPDX-License-Identifier: BSD-3-Clause
"""Moving bases and absorbing boundaries of a user: wrong input, warnings, files, resume."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tilth import BadInput, Model, check, load_case, resume, run
from tilth.analysis.staged import StagedAnalysis
from tilth.output.history import read_history
from tilth.report.energies import _STYLES as ENERGY_STYLES
from tilth.report.energies import energy_charts, energy_table

RECORD = "time,x\n0,0\n0.01,1\n0.02,-1\n0.03,-1\n0.04,1\n0.05,0\n"


def entries_of(record: Path, **base: Any) -> dict[str, Any]:
    """A block of four cells on a base that moves, with an absorbing side."""
    bottom: dict[str, Any] = {
        "name": "base", "type": "plane", "axis": "y", "at": 0.0, "condition": "base_motion",
        "acceleration": {"file": str(record)},
    }  # fmt: skip
    side = {"name": "side", "type": "plane", "axis": "x", "at": 1.0, "condition": "absorbing"}
    return {
        "units": {"time": "s"},
        "analysis": {"kind": "plane_strain", "inertia": {"scheme": "newmark"}},
        "grid": {"cell_size": 0.5},
        "materials": {
            "soil": {"model": "hencky_elastic", "young_modulus": 1e7, "poisson_ratio": 0.3,
                     "density": 2000.0}
        },
        "bodies": [{"name": "soil", "material": "soil", "basis": "gimp", "points_per_cell": 2,
                    "shape": {"type": "box", "lower": [0, 0], "upper": [1, 1]}}],
        "boundaries": [{**bottom, **base}, side],
        "schedule": {"end": 0.05, "steps": 5},
        "track": [
            {"name": "top", "quantity": "velocity", "at": [0.5, 1.0], "component": "x"},
            {"name": "shaken", "quantity": "acceleration", "at": [0.5, 1.0], "component": "x"},
            {"name": "gone", "quantity": "energy", "kind": "radiation"},
        ],
        "output": {"report": False},
    }  # fmt: skip


def written(folder: Path, text: str = RECORD) -> Path:
    file = folder / "record.csv"
    file.write_text(text, encoding="utf-8")
    return file


WRONG_FILES = {
    "empty": ("", "is empty"),
    "other columns": ("t,x\n0,0\n1,0\n", "begins with 't,x' instead of the names"),
    "an axis too many": ("time,x,z\n0,0,0\n1,0,0\n", "instead of the names of its columns"),
    "a column twice": ("time,x,x\n0,0,0\n1,0,0\n", "instead of the names of its columns"),
    "no rows": ("time,x\n", "has no rows of 2 numbers"),
    "a single row": ("time,x\n0,0\n", "has a single row"),
    "text": ("time,x\n0,0\n1,no\n", "has a row that cannot be read"),
    "not finite": ("time,x\n0,0\n1,nan\n", "row 2 below the names has a number that is not finite"),
    "a late start": ("time,x\n0.5,0\n1,0\n", "begins with time 0.5"),
    "times that repeat": ("time,x\n0,0\n1,0\n1,2\n", "row 3 below the names: the time 1 follows 1"),
    "times that fall": ("time,x\n0,0\n2,0\n1,2\n", "the time 1 follows 2"),
}


@pytest.mark.parametrize("what", WRONG_FILES)
def test_a_wrong_record_is_refused_once(what: str, tmp_path: Path) -> None:
    text, expected = WRONG_FILES[what]
    model = Model.from_dict(entries_of(written(tmp_path, text)))
    with pytest.raises(BadInput) as caught:
        check(model)
    assert "boundaries[0].acceleration.file" in str(caught.value)
    assert expected in str(caught.value)


def test_a_missing_record_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="cannot be read: there is no such file"):
        check(Model.from_dict(entries_of(tmp_path / "none.csv")))
    case = tmp_path / "case.toml"
    text = 'format = 1\n[[boundaries]]\nacceleration = { file = "none.csv" }\n'
    case.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput, match=r"boundaries\[0\].acceleration.file.*there is no such file"):
        load_case(case)


def test_a_velocity_by_a_function_is_found_beside_the_case_file(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    text = 'format = 1\n[[initial.velocity]]\nx = "none.py:velocity"\n'
    case.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput, match=r"initial.velocity\[0\].x.*there is no such file"):
        load_case(case)


WRONG_ENTRIES = {
    "a base without a record": (
        {"acceleration": None}, "boundaries[0].acceleration: missing",
    ),
    "a record without a motion": (
        {"condition": "fixed"}, 'has no meaning with condition = "fixed"',
    ),
    "a ground of a rigid base": (
        {"ground": {"density": 1.0, "p_wave_speed": 2.0, "s_wave_speed": 1.0}},
        'has no meaning with condition = "base_motion"',
    ),
    "an impossible ground": (
        {"condition": "absorbing",
         "ground": {"density": 1.0, "p_wave_speed": 1.1, "s_wave_speed": 1.0}},
        "p_wave_speed = 1.1: needs a negative bulk modulus",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG_ENTRIES)
def test_a_wrong_entry_is_refused(what: str, tmp_path: Path) -> None:
    change, expected = WRONG_ENTRIES[what]
    entries = entries_of(written(tmp_path), **change)
    base = entries["boundaries"][0]
    entries["boundaries"][0] = {key: value for key, value in base.items() if value is not None}
    with pytest.raises(BadInput) as caught:
        Model.from_dict(entries)
    assert expected in str(caught.value).replace("'", '"')


def test_they_need_inertia(tmp_path: Path) -> None:
    entries = entries_of(written(tmp_path))
    del entries["analysis"]["inertia"]
    with pytest.raises(BadInput) as caught:
        Model.from_dict(entries)
    message = str(caught.value)
    assert 'boundaries[0].condition = "base_motion": has no meaning without inertia' in message
    assert 'boundaries[1].condition = "absorbing": has no meaning without inertia' in message
    assert 'track[0].quantity = "velocity": has no meaning without inertia' in message
    assert 'track[2].kind = "radiation": has no meaning without inertia' in message


def test_soil_on_both_sides_is_refused(tmp_path: Path) -> None:
    entries = entries_of(written(tmp_path))
    entries["boundaries"][1]["at"] = 0.5
    with pytest.raises(BadInput, match="soil lies on both sides of the absorbing boundary 'side'"):
        check(Model.from_dict(entries))


def test_a_side_that_holds_the_base_is_refused(tmp_path: Path) -> None:
    entries = entries_of(written(tmp_path))
    entries["boundaries"][1]["condition"] = "roller"
    with pytest.raises(BadInput, match="'base' and 'side' prescribe different x displacements"):
        check(Model.from_dict(entries))


def warnings_of(entries: dict[str, Any]) -> str:
    return "\n".join(check(Model.from_dict(entries)).warnings)


def test_what_is_probably_not_meant_is_warned_of(tmp_path: Path) -> None:
    assert warnings_of(entries_of(written(tmp_path))) == ""
    drifting = written(tmp_path, "time,x\n0,0\n0.02,1\n0.05,0\n")
    entries = entries_of(drifting)
    assert "the record ends with a velocity of 0.025, 100% of its greatest" in warnings_of(entries)
    entries = entries_of(written(tmp_path))
    entries["schedule"]["steps"] = 2
    assert "the steps of 0.025 are longer than the record's of 0.01" in warnings_of(entries)
    entries = entries_of(written(tmp_path))
    entries["boundaries"][1]["at"] = 2.5
    assert "the absorbing boundary 'side' touches no soil" in warnings_of(entries)


def test_soil_that_is_not_at_rest_is_warned_of(tmp_path: Path) -> None:
    entries = entries_of(written(tmp_path))
    entries["loads"] = [
        {"type": "body_force", "acceleration": [0, -9.81], "factor": [[0, 1], [1, 1]]}
    ]
    folder = tmp_path / "out"
    run(Model.from_dict(entries), folder, quiet=True)
    assert "it is not in equilibrium when inertia begins" in (folder / "log.txt").read_text()


def test_energies_are_balanced_in_every_row(tmp_path: Path) -> None:
    """Points that stay in their cells lose nothing with the linear basis."""
    entries = entries_of(written(tmp_path))
    entries["bodies"][0]["basis"] = "linear"
    result = run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    table = read_history(tmp_path / "out" / "energies.csv")
    energies = {name.partition(" [")[0]: table[name] for name in table}
    parts = [name for name in energies if name.endswith("dissipation")]
    total = sum(energies[name] for name in ("elastic", "kinetic", "radiation", *parts))
    scale = np.abs(energies["external_work"]).max()
    np.testing.assert_allclose(total, energies["external_work"], rtol=0, atol=1e-12 * scale)
    assert scale > 0.0
    np.testing.assert_array_equal(energies["radiation"], result.history["gone [N m/m]"])
    assert np.abs(energies["numerical_dissipation"]).max() < 1e-5 * scale
    assert list(result.history)[3:5] == ["top [m/s]", "shaken [m/s^2]"]


@pytest.mark.parametrize("step", [1, 3])
def test_a_resumed_run_ends_in_the_same_bits(step: int, tmp_path: Path) -> None:
    entries = entries_of(written(tmp_path))
    run(Model.from_dict(entries), tmp_path / "whole", quiet=True)
    run(Model.from_dict(entries), tmp_path / "parts", quiet=True, until=0.01 * step)
    resume(tmp_path / "parts", quiet=True)
    for name in ("history.csv", "energies.csv"):
        assert (tmp_path / "parts" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


def staged_entries_of(record: Path) -> dict[str, Any]:
    """Gravity on a base at rest between rollers, then its motion with an absorbing side."""
    entries = entries_of(record)
    roller = {"name": "roller", "type": "plane", "axis": "x", "at": 1.0, "condition": "roller"}
    entries["boundaries"].append(roller)
    entries["boundaries"][0]["range"] = {"x": [0.0, 0.5]}  # the roller holds its corner
    entries["loads"] = [{"type": "body_force", "acceleration": [0, -9.81]}]
    del entries["schedule"]
    entries["stages"] = [
        {"name": "gravity", "inertia": False, "schedule": {"end": 1.0, "steps": 2}},
        {"name": "shaking", "activate": ["side"], "deactivate": ["roller"],
         "schedule": {"end": 0.03, "steps": 3}},
        {"name": "more", "schedule": {"end": 0.02, "steps": 2}},
    ]  # fmt: skip
    return entries


@pytest.mark.slow
def test_stages_are_resumed_and_gone_on_from(tmp_path: Path) -> None:
    """Also in the middle of a record, which goes on in the next stage."""
    entries = staged_entries_of(written(tmp_path))
    whole, parts, other = tmp_path / "whole", tmp_path / "parts", tmp_path / "other"
    run(Model.from_dict(entries), whole, quiet=True)
    run(Model.from_dict(entries), parts, quiet=True, until=1.02)
    resume(parts, quiet=True)
    run(Model.from_dict(entries), other, quiet=True, from_stage=(whole, "shaking"))
    for name in ("history.csv", "energies.csv"):
        assert (parts / name).read_bytes() == (whole / name).read_bytes()
        assert (other / name).read_bytes() == (whole / name).read_bytes()


def test_a_record_has_no_steps_in_a_stage_without_inertia(tmp_path: Path) -> None:
    """Whose steps may be as long as they like, for the base stands still."""
    assert warnings_of(staged_entries_of(written(tmp_path))) == ""


def test_a_record_goes_on_in_the_next_stage(tmp_path: Path) -> None:
    """The base has the record's acceleration after its end in two stages as in one."""
    entries = staged_entries_of(written(tmp_path))
    analysis = StagedAnalysis(Model.from_dict(entries))
    accelerations = []
    for _ in analysis.steps():
        (base,) = analysis.simulation.state.waves.bases
        accelerations.append(float(base.state()["motion"][1, 0]))
    np.testing.assert_allclose(accelerations[2:], [1.0, -1.0, -1.0, 1.0, 0.0], atol=1e-12)


def test_the_report_has_the_balance_of_the_energies(tmp_path: Path) -> None:
    entries = entries_of(written(tmp_path)) | {"output": {"report": True}}
    entries["initial"] = {"velocity": [{"body": "soil", "x": 1e-3}]}
    run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "<h2>Energies</h2>" in page
    assert "left through absorbing boundaries" in page
    assert "energy after the last step [N m/m]" in page


def test_the_picture_of_the_energies_has_the_share_of_what_is_numerical() -> None:
    """In per cent of the energy at the start and the work since then, here 50 J and 150 J."""
    table = {f"{kind} [J]": np.zeros(3) for kind in ("external_work", *ENERGY_STYLES)}
    table |= {
        "time": np.array([0.0, 1.0, 2.0]),
        "external_work [J]": np.array([0.0, 100.0, 150.0]),
        "kinetic [J]": np.array([50.0, 140.0, 196.0]),
        "numerical_dissipation [J]": np.array([0.0, 10.0, 4.0]),
    }
    left, right = energy_charts(table, "s")
    np.testing.assert_allclose(left.lines[0].y, [50.0, 150.0, 200.0])
    np.testing.assert_allclose(right.lines[0].y, [0.0, 5.0, 2.0])
    assert "%" in right.y
    assert ["numerical", "4", "2 %"] in energy_table(table).rows


@pytest.mark.parametrize("part", [None, [0.0, 0.5]])
def test_an_absorbing_plane_may_have_a_range(part: list[float] | None, tmp_path: Path) -> None:
    """Dashpots on half of a side take half of the force."""
    from tilth.analysis.simulation import Simulation

    entries = entries_of(written(tmp_path))
    entries["boundaries"] = entries["boundaries"][1:]
    if part is not None:
        entries["boundaries"][0]["range"] = {"y": part}
    entries["initial"] = {"velocity": [{"body": "soil", "y": 0.01}]}
    simulation = Simulation(Model.from_dict(entries))
    simulation.state.dynamics.begun = True  # type: ignore[union-attr]
    force = simulation.advance(0.0, 1e-9).resultant("side")[1]
    whole = -np.sqrt(2000.0 * 1e7 / 2.6) * 0.01
    assert force == pytest.approx(whole * (1.0 if part is None else 0.5), rel=1e-4)
