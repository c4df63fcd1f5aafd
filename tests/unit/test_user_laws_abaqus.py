# SPDX-License-Identifier: BSD-3-Clause
"""Abaqus' utility routines for UMATs against NumPy, and what happens where they end an analysis."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import tomli_w
from user_laws import BUILT_IN, code_blocks, library, of_page

from tilth import BadInput, resume
from tilth.cli import run_command
from tilth.model.abaqus_utilities import LIBRARY, load_umat

UTILITIES = ctypes.CDLL(str(LIBRARY))
Array = npt.NDArray[np.float64]
PLACES = {(3, 3): (0, 1, 2, 3, 4, 5), (3, 1): (0, 1, 2, 3), (2, 1): (0, 1, 3)}
"""Places of the components 11 22 33 12 13 23 that are stored with NDI and NSHR."""

every_storage = pytest.mark.parametrize(("ndi", "nshr"), PLACES)
stress_or_strain = pytest.mark.parametrize("lstr", [1, 2])


def call(routine: str, *arguments: Any) -> None:
    """Calls a routine as Fortran does: numbers and arrays by reference."""
    given = [
        a.ctypes.data_as(ctypes.c_void_p) if isinstance(a, np.ndarray) else ctypes.byref(a)
        for a in arguments
    ]
    getattr(UTILITIES, routine)(*given)


def whole(*numbers: int) -> list[ctypes.c_int]:
    return [ctypes.c_int(number) for number in numbers]


def tensors(ndi: int, nshr: int, lstr: int) -> list[tuple[Array, Array]]:
    """Random tensors, and some with equal values: as stored, and as matrices."""
    random = np.random.default_rng(3)
    found = [random.normal(size=6) * 10.0 ** random.uniform(-9, 9) for _ in range(40)]
    found += [np.zeros(6), np.array([2.0, 2, 2, 0, 0, 0]), np.array([1.0, 1, 5, 0, 0, 0])]
    found += [np.array([0.0, 0, 0, 1, 0, 0]), np.array([3.0, 3, 3, 1e-9, 0, 0])]
    pairs = []
    for six in found:
        stored = np.ascontiguousarray(six[list(PLACES[ndi, nshr])])
        full = np.zeros(6)
        full[list(PLACES[ndi, nshr])] = stored
        full[3:] *= 0.5 if lstr == 2 else 1.0
        pairs.append((stored, full[[[0, 3, 4], [3, 1, 5], [4, 5, 2]]]))
    return pairs


@every_storage
def test_invariants(ndi: int, nshr: int) -> None:
    """SINV: a third of the trace, and the equivalent stress of von Mises."""
    for stored, matrix in tensors(ndi, nshr, 1):
        first, second = ctypes.c_double(), ctypes.c_double()
        call("sinv_", stored, first, second, *whole(ndi, nshr))
        mean = np.trace(matrix) / 3.0
        deviator = matrix - mean * np.eye(3)
        size = np.abs(matrix).max()
        np.testing.assert_allclose(first.value, mean, rtol=1e-14, atol=1e-15 * size)
        mises = np.sqrt(1.5 * (deviator**2).sum())
        np.testing.assert_allclose(second.value, mises, rtol=1e-14, atol=1e-15 * size)


@every_storage
@stress_or_strain
def test_principal_values_and_directions(ndi: int, nshr: int, lstr: int) -> None:
    """SPRINC and SPRIND: largest first; rows of AN are orthonormal directions that diagonalise."""
    for stored, matrix in tensors(ndi, nshr, lstr):
        values, again, cosines = np.zeros(3), np.zeros(3), np.zeros((3, 3), order="F")
        call("sprinc_", stored, values, *whole(lstr, ndi, nshr))
        call("sprind_", stored, again, cosines, *whole(lstr, ndi, nshr))
        size = np.abs(matrix).max()
        expected = np.linalg.eigvalsh(matrix)[::-1]
        np.testing.assert_allclose(values, expected, rtol=0, atol=4e-15 * size)
        np.testing.assert_array_equal(again, values)
        np.testing.assert_allclose(cosines @ cosines.T, np.eye(3), rtol=0, atol=1e-14)
        turned = cosines @ matrix @ cosines.T
        np.testing.assert_allclose(turned, np.diag(values), rtol=0, atol=1e-14 * size)


@pytest.mark.parametrize(("ndi", "nshr"), [(3, 3), (3, 1)])
@stress_or_strain
def test_rotated_tensors(ndi: int, nshr: int, lstr: int) -> None:
    """ROTSIG: R t R^T, in the plane about the third axis."""
    angles = np.random.default_rng(5).normal(size=3) if nshr == 3 else np.array([0.0, 0.0, 0.7])
    (a, b, c), (s, t, u) = np.cos(angles), np.sin(angles)
    turn = np.array([[1, 0, 0], [0, a, -s], [0, s, a]]) @ np.array(
        [[b, 0, t], [0, 1, 0], [-t, 0, b]]
    )
    turn = np.asfortranarray(turn @ np.array([[c, -u, 0], [u, c, 0], [0, 0, 1]]))
    for stored, matrix in tensors(ndi, nshr, lstr):
        found = np.zeros(ndi + nshr)
        call("rotsig_", stored, turn, found, *whole(lstr, ndi, nshr))
        expected = turn @ matrix @ turn.T
        six = expected[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]] * ([1] * 3 + [lstr] * 3)
        places = list(PLACES[ndi, nshr])
        np.testing.assert_allclose(found, six[places], rtol=0, atol=4e-15 * np.abs(six).max())


MESSAGES = """
#include <string.h>
void stdb_abqerr_(int *lop, const char *text, int *whole, double *real, const char *words, ...);
void umat_(void) {
  int number[2] = {7, -12}, lop = 1;
  double real[2] = {0.125, 3e9};
  const char *text = "point %I of %I: %R, %R in %S and %S 100% %X  ";
  stdb_abqerr_(&lop, text, number, real, "SAND    CLAY NO2", strlen(text), (size_t)8);
  lop = -1;
  ((void (*)(int *, const char *, size_t))stdb_abqerr_)(&lop, "two arguments %I", 16);
  lop = -2;
  for (int i = 0; i < 30; ++i) stdb_abqerr_(&lop, "again", number, real, "", (size_t)5, (size_t)0);
  lop = -3;
  stdb_abqerr_(&lop, "no strength", number, real, "", (size_t)11, (size_t)0);
}
"""
CALLED = """
import sys
from pathlib import Path
from tilth.model.abaqus_utilities import load_umat
load_umat(Path(sys.argv[1]), "materials.clay", "x").umat_()
print("not here")
"""


def called(file: Path) -> subprocess.CompletedProcess[str]:
    """Calls the routine of a library in a process of its own."""
    return subprocess.run(
        [sys.executable, "-c", CALLED, str(file)], capture_output=True, text=True, check=False
    )


def test_messages(tmp_path: Path) -> None:
    """STDB_ABQERR: the values in their places; a flood of messages is cut, the last one is not."""
    process = called(library(tmp_path, MESSAGES))
    assert (process.returncode, process.stdout) == (1, "")
    said = [line for line in process.stderr.splitlines() if line]
    of = "tilth: materials.clay:"
    text = "point 7 of -12: 0.125, 3e+09 in SAND and CLAY NO2 100% %X"
    assert said[0] == f"{of} message of its routine: {text}"
    assert said[1] == f"{of} warning of its routine: two arguments %I"
    assert said.count(f"{of} error of its routine: again") == 18
    assert said[20] == "tilth: further messages are left out"
    assert said[21] == f"{of} error of its routine: no strength"
    assert "called Abaqus' STDB_ABQERR with LOP = -3, which ends the analysis" in said[22]


def test_the_end_of_an_analysis(tmp_path: Path) -> None:
    """XIT: the material is named, also where the call is made a jump."""
    process = called(library(tmp_path, "void xit_(void); void umat_(void) { xit_(); }"))
    assert (process.returncode, process.stdout) == (1, "")
    assert "tilth: materials.clay: its routine called Abaqus' XIT, which ends" in process.stderr


@pytest.mark.parametrize(
    ("symbol", "message"),
    [
        ("getvrm_", r"calls GETVRM \(`getvrm_`\), a utility routine of Abaqus that tilth does not"),
        ("MutexInit", r"calls MUTEXINIT \(`MutexInit`\), a utility routine of Abaqus"),
        ("SMAFloatArrayCreate", r"calls SMAFLOATARRAYCREATE .* a utility routine of Abaqus"),
        ("my_table_", "calls `my_table_`, which is in no library"),
    ],
)
def test_routines_that_are_not_there(symbol: str, message: str, tmp_path: Path) -> None:
    """Also beside one that is."""
    for other in ("", "xit_(); "):
        source = f"void xit_(void); void {symbol}(void); void umat_(void) {{ {other}{symbol}(); }}"
        made = library(tmp_path, source, f"lacks{len(other)}")
        with pytest.raises(BadInput, match=f"materials.clay.library = .*: {message}"):
            load_umat(made, "materials.clay", str(made))


def test_a_library_that_is_none(tmp_path: Path) -> None:
    file = tmp_path / "u.so"
    file.write_text("text")
    with pytest.raises(BadInput, match=r"cannot be loaded: .*\n.*compile it as a shared library"):
        load_umat(file, "materials.clay", str(file))


def clay(folder: Path, limit: float) -> dict[str, Any]:
    """The page's UMAT, with the invariants and rotation of the utilities; ends beyond a stress."""
    source = code_blocks("fortran")[0]
    begin, rest = source.split("  mean = sum(stress(1:3)) / 3d0\n")
    added = """
      call sinv(stress, mean, norm, ndi, nshr)
      if (norm > LIMIT) call xit
      call rotsig(stress, drot, flow, 1, ndi, nshr)
      call sprind(stress, values, directions, 1, ndi, nshr)
      if (abs(sum(values) - sum(flow(1:3))) > 1d-9 * norm) &
        call stdb_abqerr(-3, 'trace', 0, 0d0, ' ')
    """.replace("LIMIT", f"{limit:.1e}".replace("e", "d"))
    declared = "flow(6)\n  double precision :: values(3), directions(3, 3)"
    text = begin.replace("flow(6)", declared) + added + rest
    (folder / "clay_umat.f90").write_text(text, encoding="utf-8")
    command = next(block for block in code_blocks("") if block.startswith("gfortran"))
    if shutil.which("gfortran") is None:
        pytest.skip("needs a Fortran compiler: gfortran")
    subprocess.run(command.split(), check=True, capture_output=True, cwd=folder)
    return {**of_page("user_umat"), "library": str(folder / "libclay_umat.so")}


def pressed(soil: dict[str, Any]) -> dict[str, Any]:
    """A box of this soil under a plate that goes down."""
    sides = [
        {"name": name, "type": "plane", "axis": axis, "at": at, "condition": "roller"}
        for name, axis, at in (("left", "x", 0.0), ("base", "y", 0.0))
    ]
    plate = {
        "name": "plate", "type": "plane", "axis": "y", "at": 1.0, "condition": "prescribed",
        "displacement": {"y": -0.1},
    }  # fmt: skip
    shape = {"type": "box", "lower": [0.0, 0.0], "upper": [1.0, 1.0]}
    body = {"name": "b", "material": "clay", "shape": shape, "basis": "gimp", "points_per_cell": 2}
    return {
        "format": 1, "analysis": {"kind": "plane_strain"}, "grid": {"cell_size": 0.5},
        "materials": {"clay": soil}, "bodies": [body], "boundaries": [*sides, plate],
        "schedule": {"steps": 4}, "output": {"report": False},
    }  # fmt: skip


def test_a_routine_in_fortran_that_calls_them(tmp_path: Path) -> None:
    """A run is that of the law of the core; one that calls XIT ends with code 1 and its results."""
    (tmp_path / "free").mkdir()
    whole_run = tmp_path / "case.toml"
    built_in = {
        **BUILT_IN, "young_modulus": 1e6, "yield_stress": 2e4, "hardening_modulus": 1e5,
        "density": 1800,
    }  # fmt: skip
    stress = []
    for soil in (clay(tmp_path / "free", 1e9), built_in):
        whole_run.write_text(tomli_w.dumps(pressed(soil)))
        out = tmp_path / f"out{len(stress)}"
        assert run_command(["run", str(whole_run), "--out", str(out), "--quiet"]) == 0
        stress.append(resume(out, quiet=True).points.stress)
    size = np.abs(stress[1]).max()
    np.testing.assert_allclose(stress[0], stress[1], rtol=0, atol=1e-9 * size)
    whole_run.write_text(tomli_w.dumps(pressed(clay(tmp_path, 3.5e4))))
    process = subprocess.run(
        [sys.executable, "-m", "tilth", "run", str(whole_run), "--out", str(tmp_path / "ends")],
        capture_output=True, text=True, check=False, env={**os.environ, "OMP_NUM_THREADS": "2"},
    )  # fmt: skip
    assert process.returncode == 1
    assert "tilth: materials.clay: its routine called Abaqus' XIT" in process.stderr
    assert "Traceback" not in process.stderr
    assert (tmp_path / "ends" / "history.csv").read_text().count("\n") >= 2
