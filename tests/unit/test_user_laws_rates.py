# SPDX-License-Identifier: BSD-3-Clause
"""A user's law that depends on rates: TIME and DTIME of a UMAT, in element tests and analyses.

The law is Maxwell's in shear: the deviatoric stress relaxes with the time eta / G. In an Euler
backward step of size dt it shrinks by 1 / (1 + G dt / eta).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_problems import block_entries, plane
from user_laws import library

from tilth import ElementCase, Model, element
from tilth.analysis.march import march_stages
from tilth.analysis.simulation import Simulation
from tilth.analysis.staged import StagedAnalysis
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.element_tests.check import check_tangents

MAXWELL = """
#define SIX(a, b) ddsdde[(a) + 6 * (b)]

void umat(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd,
          double *rpl, double *ddsddt, double *drplde, double *drpldt, double *stran,
          double *dstran, double *time, double *dtime, double *temp, double *dtemp,
          double *predef, double *dpred, char *cmname, int *ndi, int *nshr, int *ntens,
          int *nstatv, double *props, int *nprops, double *coords, double *drot, double *pnewdt,
          double *celent, double *dfgrd0, double *dfgrd1, int *noel, int *npt, int *layer,
          int *kspt, int *jstep, int *kinc) {
  const double shear = props[0] / (2 * (1 + props[1]));
  const double bulk = props[0] / (3 * (1 - 2 * props[1]));
  const double left = 1 / (1 + shear * *dtime / props[2]);
  double trial[3], mean = 0, volumetric = dstran[0] + dstran[1] + dstran[2];
  for (int a = 0; a < 3; ++a) {
    trial[a] = stress[a] + bulk * volumetric + 2 * shear * (dstran[a] - volumetric / 3);
    mean += trial[a] / 3;
  }
  for (int a = 0; a < 3; ++a) {
    stress[a] = mean + left * (trial[a] - mean);
    for (int b = 0; b < 3; ++b) SIX(a, b) = bulk + 2 * shear * left * ((a == b) - 1.0 / 3);
    SIX(a + 3, a + 3) = shear * left;
  }
  statev[0] = time[0] + *dtime;
  statev[1] = time[1] + *dtime;
}
"""
YOUNG, POISSON, VISCOSITY = 1000.0, 0.25, 800.0
CLOCKS = ("time_in_stage", "total_time")
SHEAR = YOUNG / (2.0 * (1.0 + POISSON))


def maxwell(folder: Path) -> dict[str, Any]:
    """Entries of the material."""
    return {
        "model": "user_umat",
        "library": str(library(folder, MAXWELL, "maxwell")),
        "routine": "umat",
        "properties": [YOUNG, POISSON, VISCOSITY],
        "young_modulus": YOUNG,
        "poisson_ratio": POISSON,
        "state_variables": [{"name": name, "unit": "-", "initial": 0.0} for name in CLOCKS],
        "density": 2.0,
    }


def deviator(stress: Floats) -> Floats:
    """The deviatoric part of stresses, (n, 6)."""
    return stress - stress[:, :3].mean(axis=1)[:, None] * [1, 1, 1, 0, 0, 0]


def test_relaxation_in_an_element_test(tmp_path: Path) -> None:
    """A strain grows for 2 and rests for 3 units of time, in 5 steps each; others begin at 0."""
    path = {"name": "relaxation", "type": "path", "material": "soil", "steps": 5,
            "start": {"isotropic": 0.0},
            "strain": {"xx": [[0, 0], [5, 0]], "yy": [[0, 0], [2, 0.01], [5, 0.01]],
                       "zz": [[0, 0], [5, 0]]}}  # fmt: skip
    case = ElementCase.from_dict({"materials": {"soil": maxwell(tmp_path)}, "tests": [path]})
    (result,) = element(case)
    deviatoric = result.columns["q"]
    left = 1.0 / (1.0 + SHEAR * 0.6 / VISCOSITY)
    np.testing.assert_allclose(deviatoric[6:] / deviatoric[5:-1], left, rtol=1e-9)
    grown, step = 0.0, 1.0 / (1.0 + SHEAR * 0.4 / VISCOSITY)
    for _ in range(5):
        grown = step * (grown + 2.0 * SHEAR * 0.002)
    assert deviatoric[5] == pytest.approx(grown * np.exp(0.01), rel=1e-9)  # Cauchy stress: / J
    (check,) = check_tangents(case)
    assert check.error < 1e-8


def block(folder: Path, steps: int, factor: float) -> dict[str, Any]:
    """Squeezed in a stage of `factor` units of time, then held in one twice as long."""
    entries = block_entries("plane_strain", "gimp", boundaries=[
        plane("base", "y", 0.0), plane("left", "x", 0.0), plane("right", "x", 2.0),
        plane("top", "y", 2.0, condition="prescribed", displacement={"y": -0.02},
              factor=[[0.0, 0.0], [factor, 1.0]]),
    ])  # fmt: skip
    del entries["schedule"]
    entries["materials"]["soil"] = maxwell(folder)
    entries["materials"]["soil"]["properties"][2] *= factor
    entries["stages"] = [
        {"name": "squeeze", "schedule": {"steps": steps, "end": factor}},
        {"name": "rest", "schedule": {"steps": steps, "end": 2.0 * factor}},
    ]
    return entries


@pytest.mark.parametrize("factor", [1.0, 60.0])
def test_relaxation_in_an_analysis_of_two_stages(tmp_path: Path, factor: float) -> None:
    """In any unit of time. TIME has the time in the stage and the total one."""
    steps, found = 4, []

    def after_step(analysis: StagedAnalysis, result: StepResult) -> None:
        points = analysis.simulation.state.points
        found.append((np.linalg.norm(deviator(points.stress), axis=1), points.state.copy()))

    march_stages(Model.from_dict(block(tmp_path, steps, factor)), after_step)
    size = np.array([each.mean() for each, _ in found])
    left = 1.0 / (1.0 + SHEAR * 2.0 / steps / VISCOSITY)
    # the block is not quite homogeneous once the plate has left the grid line
    np.testing.assert_allclose(size[steps:] / size[steps - 1 : -1], left, rtol=1e-4)
    clock = np.array([state[:, :2].mean(axis=0) for _, state in found]) / factor
    in_stage = [*np.arange(1, 5) / 4, *np.arange(1, 5) / 2]
    total = [*np.arange(1, 5) / 4, *(1.0 + np.arange(1, 5) / 2)]
    np.testing.assert_allclose(clock, np.column_stack([in_stage, total]), rtol=1e-12)


def test_no_time_passes_in_the_equilibrium_at_the_start(tmp_path: Path) -> None:
    """The stress at the start does not relax while its equilibrium is found."""
    entries = block(tmp_path, 1, 1.0)
    entries["initial"] = {
        "stress": [{"type": "given", "body": "block", "stress": [-10.0, -20.0, -10.0, 0.0]}]
    }
    entries["boundaries"][-1] |= {"displacement": {"y": 0.0}}
    simulation = Simulation(Model.from_dict(entries).of_stages[0])
    assert (simulation.state.points.state[:, :2] == 0.0).all()
    before = np.linalg.norm(deviator(simulation.state.points.stress), axis=1)
    simulation.advance(0.0, 1.0)
    after = np.linalg.norm(deviator(simulation.state.points.stress), axis=1)
    np.testing.assert_allclose(after / before, 1.0 / (1.0 + SHEAR / VISCOSITY), rtol=1e-9)
