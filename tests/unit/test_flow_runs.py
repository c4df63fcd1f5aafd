# SPDX-License-Identifier: BSD-3-Clause
"""Runs with flowing water: resumed, gone on with, with a factor of safety, in a study."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from clay_columns import CLAY, ENTRIES, FREE_BLOCK, column
from resumed_runs import assert_same_results, run_in_pieces
from user_laws import LAWS, material

from tilth import BadInput, Model, check, run, safety
from tilth.analysis.staged import StagedAnalysis
from tilth.case import load_element_case
from tilth.element_tests.command import make_tests
from tilth.mpm.pore_water import PRESSURE
from tilth.output import read_checkpoint
from tilth.output.folder import CHECKPOINT
from tilth.output.safety_files import read_safety

QUIET: Any = {"output": {"report": False}}
SHUT = {"name": "loading", "schedule": {"end": 1.0, "steps": 2}, "flow": False}
OPEN = {"name": "consolidation", "schedule": {"end": 8.0, "steps": 4}}
GIVEN = {
    **ENTRIES["flow"]["boundaries"][0], "condition": "pressure", "excess_pressure": 2.0,
    "factor": [[0, 0], [4, 1], [8, 1]],
}  # fmt: skip


def model(**changes: Any) -> Model:
    return Model.from_dict(column({**QUIET, **changes}))


def staged(*stages: Any, **changes: Any) -> Model:
    return model(schedule=None, stages=list(stages), **changes)


def final_pressures(folder: Path) -> Any:
    arrays, _ = read_checkpoint(folder / CHECKPOINT)
    return arrays["water"][np.argsort(arrays["point_id"]), PRESSURE]


@pytest.mark.parametrize(
    "changes", [{}, {"flow.scheme": "bdf2"}, {"flow.scheme": "bdf2", "flow.largest_error": 0.5}]
)
def test_a_resumed_run_gives_the_same_results(
    changes: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    declared = staged(SHUT, OPEN, **{"flow.bulk_modulus": 1e5, **changes})
    run(declared, tmp_path / "whole", quiet=True)
    run_in_pieces(declared, tmp_path / "pieces", [1, 2, 4, 5], monkeypatch)
    assert_same_results(tmp_path / "whole", tmp_path / "pieces")
    found = [final_pressures(tmp_path / name) for name in ("whole", "pieces")]
    np.testing.assert_array_equal(*found)


def test_a_run_goes_on_with_the_same_flow(tmp_path: Path) -> None:
    """To a later time and with other rows after that of the run, but with nothing else changed."""
    whole = model(**{"flow.boundaries.0": GIVEN})
    run(whole, tmp_path / "whole", quiet=True)
    short = {"schedule": {"end": 4.0, "step_size": 2.0}}
    first = {**GIVEN, "factor": [[0, 0], [4, 1]]}
    run(model(**{"flow.boundaries.0": first}, **short), tmp_path / "run", quiet=True)
    changed = model(**{"flow.boundaries.0": {**GIVEN, "excess_pressure": 3.0}})
    with pytest.raises(BadInput) as error:
        run(changed, tmp_path / "run", continues=True, quiet=True)
    assert error.value.key == "flow.boundaries[0].excess_pressure"
    early = {**GIVEN, "factor": [[0, 1], [8, 1]]}
    with pytest.raises(BadInput) as error:
        run(model(**{"flow.boundaries.0": early}), tmp_path / "run", continues=True, quiet=True)
    assert error.value.key == "flow.boundaries[0].factor"
    longer = model(**{"flow.boundaries.0": GIVEN}, schedule={"end": 8.0, "step_size": 2.0})
    run(longer, tmp_path / "run", continues=True, quiet=True)
    found = [final_pressures(tmp_path / name) for name in ("whole", "run")]
    np.testing.assert_allclose(*found, rtol=1e-6)


def test_a_run_goes_on_from_a_stage_of_another(tmp_path: Path) -> None:
    run(staged(SHUT, OPEN), tmp_path / "first", quiet=True)
    slower = {**OPEN, "schedule": {"end": 16.0, "steps": 4}}
    run(staged(SHUT, slower), tmp_path / "next", quiet=True,
        from_stage=(tmp_path / "first", "loading"))  # fmt: skip
    assert final_pressures(tmp_path / "next").max() < final_pressures(tmp_path / "first").max()
    flows = {key: value for key, value in SHUT.items() if key != "flow"}
    with pytest.raises(BadInput) as error:
        run(staged(flows, OPEN), tmp_path / "wrong", quiet=True,
            from_stage=(tmp_path / "first", "loading"))  # fmt: skip
    assert "flow" in error.value.problem


def test_a_start_from_a_run_has_no_excess_pressure(tmp_path: Path) -> None:
    """Its stress is brought into equilibrium without; a warning says so."""
    run(model(), tmp_path / "first", quiet=True)
    stress = [{"type": "run", "body": "soil", "folder": str(tmp_path / "first")}]
    declared = model(**{"initial.stress": stress})
    (warning,) = check(declared).warnings
    assert warning.startswith("initial.stress[0].folder: water flows in this run")
    run(declared, tmp_path / "second", quiet=True)
    np.testing.assert_allclose(final_pressures(tmp_path / "second"), 0.0, atol=1e-6)


@pytest.mark.slow
def test_safety_of_a_run_holds_the_pore_pressure(tmp_path: Path) -> None:
    """In a stage, and of the folder afterwards; it grows with the time of consolidation."""
    reduction = {"type": "strength_reduction", "tolerance": 0.05}
    loading = {**SHUT, "schedule": {"end": 1.0, "steps": 4}}
    declared = staged(loading, {**reduction, "name": "before"},
                      {**OPEN, "schedule": {"end": 100.0, "steps": 2}},
                      {**reduction, "name": "after"}, **FREE_BLOCK)  # fmt: skip
    run(declared, tmp_path / "run", quiet=True)
    undrained, drained = (read_safety(tmp_path / "run", index).factor for index in (1, 3))
    assert undrained == pytest.approx(1.35, abs=0.05)
    assert drained == pytest.approx(1.7, abs=0.05)
    before = final_pressures(tmp_path / "run")
    assert safety(tmp_path / "run", quiet=True).factor == pytest.approx(1.7, abs=0.05)
    np.testing.assert_array_equal(final_pressures(tmp_path / "run"), before)


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_laws_of_the_user_consolidate_as_the_one_built_in(law: str, tmp_path: Path) -> None:
    """Elastic, so that state and stress are those of the built-in one."""
    pores = {key: CLAY[key] for key in ("porosity", "hydraulic_conductivity")}
    elastic = {key: CLAY[key] for key in ("model", "young_modulus", "poisson_ratio")}
    known = {**elastic, **pores, "young_modulus": 1000.0}
    own = {**material(law, tmp_path), **pores}
    del own["density"]
    found = []
    for each in (own, known):
        analysis = StagedAnalysis(model(**{"materials.clay": each}))
        for _ in analysis.steps():
            pass
        found.append(analysis.state.points.water[:, PRESSURE])
    np.testing.assert_allclose(*found, rtol=1e-5)


def test_element_tests_do_not_know_of_flowing_water(tmp_path: Path) -> None:
    """A material with a conductivity is that without one: a specimen is drained or undrained."""
    elastic = {key: CLAY[key] for key in ("model", "young_modulus", "poisson_ratio")}
    test = {
        "name": "squeezed", "type": "oedometer", "material": ["clay", "plain"], "steps": 4,
        "vertical_stress": [10.0], "start": {"isotropic": 1.0},
    }  # fmt: skip
    file = tmp_path / "tests.toml"
    case = {"format": 1, "materials": {"clay": CLAY, "plain": elastic}, "tests": [test]}
    file.write_text(tomli_w.dumps(case))
    make_tests(load_element_case(file), tmp_path / "out", overwrite=False, quiet=True)
    tables = [tmp_path / "out" / f"squeezed.{name}.csv" for name in ("clay", "plain")]
    assert tables[0].read_text() == tables[1].read_text()
