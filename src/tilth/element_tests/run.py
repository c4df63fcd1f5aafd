# SPDX-License-Identifier: BSD-3-Clause
"""Makes element tests: each test with each of its materials, stage by stage and step by step."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from tilth.arrays import Floats
from tilth.element_tests.output import write_outputs
from tilth.element_tests.point import ElementPoint
from tilth.element_tests.result import ElementResult, Row, result_of
from tilth.element_tests.stages import Specimen, stages_of, start_stress
from tilth.element_tests.step import advance
from tilth.errors import BadInput, StepFailed
from tilth.model import ElementCase, ElementTest
from tilth.model.element_tests import Biaxial, SimpleShear, Triaxial
from tilth.model.isotropic import ParametersAt
from tilth.model.problems import dotted
from tilth.mpm.interval import Interval
from tilth.mpm.user_moduli import require_declared_moduli
from tilth.output.folder import make_folder, require_empty


@dataclass(frozen=True)
class TakenStep:
    """A step of a test: the point before it, the deformation gradient (3, 3) after it, its time."""

    before: ElementPoint
    deformation_gradient: Floats
    interval: Interval


def element(
    case: ElementCase, out: Path | str | None = None, *, overwrite: bool = False
) -> list[ElementResult]:
    """Makes all element tests of a case with all their materials, in their order.

    A test ends early where a step has no solution, as in a drained test loaded beyond the strength;
    `ElementResult.stopped` then says why.

    Args:
        case: the declared tests.
        out: folder of the tables (CSV) and pictures; none are written if not given.
        overwrite: whether the outputs of earlier tests in the folder are replaced.

    Raises:
        BadInput: a material cannot have a test's start stress, or a law's own pore fluid is to be
            drained; or the folder is not empty, or cannot be made.
        AnalysisFailed: a file cannot be written.
    """
    if out is not None:
        require_empty(make_folder(out), overwrite)
    results = [
        run_test(case, number, name)
        for number, test in enumerate(case.tests)
        for name in test.material
    ]
    if out is not None:
        write_outputs(case, results, Path(out))
    return results


def run_test(case: ElementCase, number: int, material: str) -> ElementResult:
    """Makes one test of a case with one material; raises as `element`."""
    test = case.tests[number]
    specimen = specimen_of(case, number, material)
    pore_pressure = 0.0 if specimen.point.has_pore_fluid else None
    rows = [Row(0, specimen.point, specimen.strain, 0, pore_pressure)]
    stopped = ""
    try:
        for row, _ in taken_steps(test, specimen):
            rows.append(row)
    except StepFailed as error:
        stopped = f"stage {rows[-1].stage or 1}, after step {len(rows) - 1}: {error.reason}"
    return result_of(test, material, case.units, rows, stopped)


def specimen_of(case: ElementCase, number: int, name: str) -> Specimen:
    """Returns the specimen of a test at its start, of the material of that name.

    Raises:
        BadInput: a law of the user cannot be loaded or has other moduli than the declared ones, a
            start that the material cannot have, or a pore fluid that contradicts the drainage.
    """
    test, material, law = case.tests[number], case.materials[name], case.laws[name]
    key = f"tests[{number}]"
    parameters = material.parameter_array(ParametersAt(partial(getattr, material), 1.0), 1)
    require_declared_moduli(law, parameters, dotted(("materials", name)))
    try:
        point = ElementPoint.at_start(material, start_stress(test.start), law)
    except BadInput as error:
        start = test.start.model_dump(exclude_none=True)
        raise BadInput(error.problem, error.remedy, key=f"{key}.start", value=start) from None
    if isinstance(test, Triaxial | Biaxial | SimpleShear) and point.has_pore_fluid:
        what = f"the pore fluid of the material's law `{point.law.name}` cannot leave it"
        if test.drainage == "drained":
            remedy = 'make the test "undrained", or give a material without pore fluid'
            raise BadInput(what, remedy, key=f"{key}.drainage", value=test.drainage)
        if test.consolidation is not None:
            state = test.consolidation.model_dump(exclude_none=True)
            remedy = "leave the consolidation out: give its stress as `start`"
            raise BadInput(what, remedy, key=f"{key}.consolidation", value=state)
    return Specimen(point, np.zeros(6))


def taken_steps(test: ElementTest, specimen: Specimen) -> Iterator[tuple[Row, TakenStep]]:
    """Takes a specimen through a test; yields each step.

    Raises:
        StepFailed: a step has no solution.
    """
    for number, stage in enumerate(stages_of(test, specimen), start=1):
        for step in range(1, stage.steps + 1):
            before, begin, end = specimen.point, (step - 1) / stage.steps, step / stage.steps
            interval = stage.interval(specimen.time, begin, end)
            iterations = advance(specimen, stage, begin, end)
            point = specimen.point
            row = Row(number, point, specimen.strain, iterations, stage.pore_pressure(point))
            yield row, TakenStep(before, point.deformation_gradient, interval)
