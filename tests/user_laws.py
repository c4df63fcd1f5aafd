# SPDX-License-Identifier: BSD-3-Clause
"""The laws of docs/howto/write_your_own_material.md as files, and the same law of the core."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PAGE = Path(__file__).parents[1] / "docs" / "howto" / "write_your_own_material.md"

LAWS = ("user_python", "user_compiled", "user_umat", "umat_in_c")

ELASTIC = {"young_modulus": 1000.0, "poisson_ratio": 0.3}
PLASTIC = {"yield_stress": 60.0, "hardening_modulus": 40.0}

BUILT_IN: dict[str, Any] = {"model": "von_mises", **ELASTIC, **PLASTIC, "density": 2.0}

UMAT_IN_C = """
#include <math.h>
#include <string.h>

#define SIX(a, b) ddsdde[(a) + 6 * (b)]

void umat(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd,
          double *rpl, double *ddsddt, double *drplde, double *drpldt, double *stran,
          double *dstran, double *time, double *dtime, double *temp, double *dtemp,
          double *predef, double *dpred, char *cmname, int *ndi, int *nshr, int *ntens,
          int *nstatv, double *props, int *nprops, double *coords, double *drot, double *pnewdt,
          double *celent, double *dfgrd0, double *dfgrd1, int *noel, int *npt, int *layer,
          int *kspt, int *jstep, int *kinc) {
  if (*ndi != 3 || *nshr != 3 || *ntens != 6 || *nprops != 5 || *nstatv != 1 || *celent <= 0.0 ||
      memcmp(cmname, "UMAT ", 5) != 0 || cmname[79] != ' ' || drot[0] + drot[4] + drot[8] != 3.0 ||
      dstran[3] != 0.0 || dstran[4] != 0.0 || dstran[5] != 0.0 || *dtime < 0.0) {
    *pnewdt = 0.5;
    return;
  }
  const double shear = props[0] / (2 * (1 + props[1]));
  const double bulk = props[0] / (3 * (1 - 2 * props[1]));
  double trial[3], mean = 0, norm = 0, volumetric = 0;
  for (int a = 0; a < 3; ++a) volumetric += dstran[a];
  for (int a = 0; a < 3; ++a) {
    trial[a] = stress[a] + bulk * volumetric + 2 * shear * (dstran[a] - volumetric / 3);
    mean += trial[a] / 3;
  }
  for (int a = 0; a < 3; ++a) norm += (trial[a] - mean) * (trial[a] - mean);
  norm = sqrt(norm);
  const double excess = norm - sqrt(2.0 / 3) * (props[2] + props[3] * statev[0]);
  const double slope = 2 * shear + 2.0 / 3 * props[3];
  const double multiplier = excess > 0 ? excess / slope : 0;
  const double scaled = excess > 0 ? 1 - 2 * shear * multiplier / norm : 1;
  const double radial = excess > 0 ? 2 * shear / slope - 2 * shear * multiplier / norm : 0;
  for (int a = 0; a < 3; ++a) {
    stress[a] = mean + scaled * (trial[a] - mean);
    for (int b = 0; b < 3; ++b) {
      const double dyad = excess > 0 ? (trial[a] - mean) * (trial[b] - mean) / (norm * norm) : 0;
      SIX(a, b) = bulk + 2 * shear * (scaled * ((a == b) - 1.0 / 3) - radial * dyad);
    }
    SIX(a + 3, a + 3) = shear;
  }
  stress[3] = props[4];
  statev[0] += sqrt(2.0 / 3) * multiplier;
}
"""
"""The UMAT of the page; refuses other arguments than documented. The last of PROPS is a shear
stress that no isotropic law has."""


def code_blocks(language: str) -> list[str]:
    """The blocks of the page in one language, "" for none."""
    text = PAGE.read_text(encoding="utf-8")
    found = re.findall(r"^```(\w*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [block for of_block, block in found if of_block == language]


def of_page(model: str) -> dict[str, Any]:
    """The entries of the page's material of this model."""
    tables = [block for block in code_blocks("") if block.startswith("[materials")]
    found = [tomllib.loads(table)["materials"]["clay"] for table in tables]
    return next(entries for entries in found if entries["model"] == model)


def c_compiler() -> str:
    """The C compiler; the test is skipped where there is none."""
    found = shutil.which("cc") or shutil.which("gcc")
    if found is None:
        pytest.skip("needs a C compiler: cc or gcc")
    return found


def library(folder: Path, source: str, name: str = "c_umat") -> Path:
    """A shared library made of C source."""
    (folder / f"{name}.c").write_text(source, encoding="utf-8")
    made = folder / f"lib{name}.so"
    command = [c_compiler(), "-O2", "-shared", "-fPIC", "-o", str(made), str(folder / f"{name}.c")]
    subprocess.run([*command, "-lm"], check=True, capture_output=True)
    return made


def fortran_library(folder: Path) -> Path:
    """The page's UMAT, compiled as the page says; skipped without a Fortran compiler."""
    if shutil.which("gfortran") is None:
        pytest.skip("needs a Fortran compiler: gfortran")
    (folder / "clay_umat.f90").write_text(code_blocks("fortran")[0], encoding="utf-8")
    command = next(block for block in code_blocks("") if block.startswith("gfortran"))
    subprocess.run(command.split(), check=True, capture_output=True, cwd=folder)
    return folder / of_page("user_umat")["library"]


def material(law: str, folder: Path, **changed: Any) -> dict[str, Any]:
    """Entries of a law of `LAWS` with the constants of `BUILT_IN`; writes its files to `folder`."""
    if law == "umat_in_c":
        entries = {
            **of_page("user_umat"),
            "library": str(library(folder, UMAT_IN_C)),
            "routine": "umat",
            "properties": [*ELASTIC.values(), *PLASTIC.values(), 0.0],
            "property_kinds": [*of_page("user_umat")["property_kinds"], "stress"],
        }
    else:
        entries = of_page(law)
    if law == "user_python":
        (folder / "clay.py").write_text(code_blocks("python")[0], encoding="utf-8")
        entries |= {"class": f"{folder}/clay.py:Clay", "parameters": {**ELASTIC, **PLASTIC}}
    elif law == "user_compiled":
        pytest.importorskip("numba", reason="needs numba")
        (folder / "clay_compiled.py").write_text(code_blocks("python")[1], encoding="utf-8")
        strength = {**entries["state_variables"][0], "initial": PLASTIC["yield_stress"]}
        entries |= {
            "function": f"{folder}/clay_compiled.py:clay",
            "parameters": [PLASTIC["hardening_modulus"]],
            "state_variables": [strength],
        }
    elif law == "user_umat":
        entries["library"] = str(fortran_library(folder))
        entries["properties"] = [*ELASTIC.values(), *PLASTIC.values()]
    if law != "user_python":
        entries |= ELASTIC
    return {**entries, "density": 2.0, **changed}
