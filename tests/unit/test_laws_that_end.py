# SPDX-License-Identifier: BSD-3-Clause
"""Laws of the user that end the process, crash, go to another folder, or return no real numbers."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from user_laws import PLASTIC, c_compiler, code_blocks, library

from tilth import BadInput, Model, run
from tilth.model.python_law import PythonLaw
from tilth.model.user_function import real_numbers
from tilth.output import read_history, read_log

UMAT = """
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static int overflow(volatile char *last) {
  volatile char here[4096];
  here[0] = *last;
  return overflow(here) + here[0];
}

void umat(double *stress, double *statev, double *ddsdde, double *a, double *b, double *c,
          double *d, double *e, double *f, double *g, double *stran, double *dstran, double *h,
          double *i, double *j, double *k, double *l, double *m, char *n, int *ndi, int *nshr,
          int *ntens, int *nstatv, double *props) {
  for (int x = 0; x < 36; ++x) ddsdde[x] = 0;
  for (int x = 0; x < 3; ++x) {
    ddsdde[7 * x] = 1e6;
    ddsdde[7 * (x + 3)] = 5e5;
    stress[x] += 1e6 * dstran[x];
  }
  if (stran[2] + dstran[2] > props[1]) return;
  switch ((int)props[0]) {
    case 0: printf("strain too large\\n"); exit(0);
    case 1: exit(7);
    case 2: quick_exit(0);
    case 3: abort();
    case 4: *(volatile int *)8 = 1; return;
    case 5: { char start = 0; stress[0] += overflow(&start); return; }
    case 6: raise(SIGFPE); return;
    case 7: if (chdir("/") != 0) abort(); return;
    case 8: if (system("exit 3") != 768) abort(); return;
  }
}
"""
"""Elasticity without lateral strain; below the strain PROPS(2) it does what PROPS(1) says."""

COLUMN: dict[str, Any] = {
    "format": 1,
    "analysis": {"kind": "plane_strain"},
    "grid": {"cell_size": 1.0},
    "bodies": [
        {
            "name": "column", "material": "clay", "basis": "linear", "points_per_cell": 2,
            "shape": {"type": "box", "lower": [0.0, 0.0], "upper": [1.0, 5.0]},
        }
    ],
    "boundaries": [
        {"name": "base", "type": "plane", "axis": "y", "at": 0.0, "condition": "fixed"}
    ],
    "loads": [{"type": "body_force", "acceleration": [0.0, -10.0]}],
    "schedule": {"steps": 10},
    "output": {"report": False},
}  # fmt: skip


def umat(file: Path, way: int, below: float) -> dict[str, Any]:
    return {
        "model": "user_umat", "library": str(file), "routine": "umat",
        "properties": [float(way), below], "young_modulus": 1e6, "poisson_ratio": 0.0,
        "state_variables": [], "density": 1000.0,
    }  # fmt: skip


def toml(entries: dict[str, Any], indent: str = "") -> str:
    """A case file; every value of JSON's kinds is one of TOML, tables inline."""

    def value(entry: Any) -> str:
        if isinstance(entry, dict):
            return "{" + ", ".join(f'"{k}" = {value(v)}' for k, v in entry.items()) + "}"
        if isinstance(entry, list):
            return "[" + ", ".join(value(each) for each in entry) + "]"
        if isinstance(entry, bool):
            return str(entry).lower()
        return f'"{entry}"' if isinstance(entry, str) else repr(entry)

    return "\n".join(f"{key} = {value(entry)}" for key, entry in entries.items())


def tilth(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "tilth", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=100)


@pytest.mark.slow
def test_a_run_whose_law_ends_the_process_is_resumed(tmp_path: Path) -> None:
    """Exit code 1, one message with the law and its material, and the steps before are kept."""
    file = library(tmp_path, UMAT)
    case = COLUMN | {"materials": {"clay": umat(file, 0, -0.02)}}
    (tmp_path / "case.toml").write_text(toml(case))
    ended = tilth(tmp_path, "run", "case.toml", "--out", "out", "--quiet")
    assert ended.returncode == 1
    message = "the law `umat` in `libc_umat.so` (materials.clay) ended the program, as exit, STOP"
    assert ended.stderr.count(message) == 1
    assert "tilth resume" in ended.stderr
    assert len(read_history(tmp_path / "out/history.csv")["step"]) == 1 + 4
    assert message in (read_log(tmp_path / "out/log.txt").failure or "")
    assert tilth(tmp_path, "report", "out").returncode == 0
    library(tmp_path, UMAT.replace(" exit(0);", " return;"))
    again = tilth(tmp_path, "resume", "out", "--quiet")
    assert again.returncode == 0, again.stderr
    assert len(read_history(tmp_path / "out/history.csv")["step"]) == 1 + 10
    assert read_log(tmp_path / "out/log.txt").finished


@pytest.mark.slow
@pytest.mark.parametrize("command", ["check", "element"])
def test_other_commands_say_it_too(command: str, tmp_path: Path) -> None:
    case = COLUMN | {"materials": {"clay": umat(library(tmp_path, UMAT), 0, 1.0)}}
    if command == "element":
        case = {
            "format": 1, "materials": case["materials"],
            "tests": [
                {"name": "t", "material": "clay", "type": "oedometer", "steps": 2,
                 "start": {"isotropic": 1.0}, "vertical_stress": [10.0]}
            ],
        }  # fmt: skip
    (tmp_path / "case.toml").write_text(toml(case))
    ended = tilth(tmp_path, command, "case.toml")
    assert (ended.returncode, ended.stderr.count("(materials.clay) ended the program")) == (1, 1)


ONE_CALL = """
import ctypes, sys
import numpy as np
from tilth import _core

class Law:
    kind, label, name, initial = "umat", "the law", "UMAT", np.zeros(0)
    library = ctypes.CDLL(sys.argv[1])
    address = ctypes.cast(library.umat, ctypes.c_void_p).value

n = int(sys.argv[3])
_core.set_threads(2)
_core.set_parallel_from(0)
_core.set_user_code_note("the rest is kept")
state, good = np.zeros((n, 3)), np.zeros(n, dtype=bool)
stress, elastic, tangent = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
_core.principal_update(
    Law(), np.array([1e6, 0.0, 1.0, float(sys.argv[2]), 0.0]), np.full((n, 3), -0.01),
    np.zeros((n, 2)), state.copy(), state, stress, elastic, tangent, good,
)
print("came back")
if len(sys.argv) > 4:
    exec(sys.argv[4])
"""
"""A call of the law for several points, without a model."""


def called(folder: Path, way: int, then: str = "") -> subprocess.CompletedProcess[str]:
    file = library(folder, UMAT)
    stack = ["sh", "-c", 'ulimit -s 8192; exec "$@"', "sh"]  # an endless one would take all memory
    command = [*stack, sys.executable, "-c", ONE_CALL, str(file), str(way), "64"]
    return subprocess.run(
        [*command, *([then] if then else [])],
        capture_output=True, text=True, timeout=100, cwd=folder,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("way", "how"),
    [
        (0, "ended the program"), (2, "ended the program"), (3, "SIGABRT"), (4, "SIGSEGV"),
        pytest.param(1, "ended the program", marks=pytest.mark.slow),
        pytest.param(5, "OMP_STACKSIZE", marks=pytest.mark.slow),
        pytest.param(6, "SIGFPE", marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_every_way_out_is_named(way: int, how: str, tmp_path: Path) -> None:
    """Whatever status it asks for: the exit code is that of a failed analysis."""
    ended = called(tmp_path, way)
    assert ended.returncode == 1
    assert ended.stderr.count("the law ") == 1
    assert how in ended.stderr
    assert ended.stderr.endswith("whatever it finds; the rest is kept\n")
    assert "came back" not in ended.stdout


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "darwin", reason="needs the C++ library of g++")
def test_a_cpp_exception_of_a_law_is_named(tmp_path: Path) -> None:
    (tmp_path / "c.cpp").write_text(
        '#include <stdexcept>\nextern "C" void umat() { throw std::runtime_error("no root"); }\n'
    )
    made = tmp_path / "libc.so"
    command = [c_compiler(), "-shared", "-fPIC", "-o", str(made), str(tmp_path / "c.cpp")]
    subprocess.run([*command, "-lstdc++"], check=True)
    ended = subprocess.run(
        [sys.executable, "-c", ONE_CALL, str(made), "0", "4"], capture_output=True, text=True
    )
    assert ended.returncode == 1
    assert "the law threw a C++ exception: no root" in ended.stderr


def test_what_ends_the_process_outside_of_a_law_is_left_alone(tmp_path: Path) -> None:
    """Also in a child process of the law; the handlers of before are there again."""
    ended = called(tmp_path, 8, "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)")
    assert ended.stdout == "came back\n"
    assert ended.returncode < 0
    assert "the law" not in ended.stderr
    ended = called(tmp_path, 9, "raise SystemExit(5)")
    assert (ended.returncode, ended.stderr) == (5, "")


def clay(folder: Path, change: str, imports: str = "") -> PythonLaw:
    """The class of the how-to with a line before the last one."""
    code = code_blocks("python")[0].splitlines()
    lines = [imports, *code[:-1], f"        {change}", code[-1], ""]
    (folder / "clay.py").write_text("\n".join(lines))
    parameters = {"young_modulus": 1e6, "poisson_ratio": 0.3, **PLASTIC}
    return PythonLaw(f"{folder}/clay.py:Clay", parameters, "materials.clay")


def updated(law: PythonLaw) -> Any:
    trial = np.linspace(-0.01, 0.01, 12).reshape(4, 3)
    return law.update(trial, np.zeros((4, 1)), np.full((4, 1), 60.0))


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ("stress = stress + 0j", "returned complex128 numbers as stress"),
        ("tangent = tangent.astype(object)", "returned a list of unlike entries as tangent"),
        ("elastic = elastic.astype(str)", "numbers as elastic, not an array of real numbers"),
        ("stress = np.ma.masked_less(stress, 0.0)", "returned an array with masked entries"),
        ("stress = {1: stress}", "returned a dict as stress"),
        ("stress = stress[:2]", "returned stress of shape (2, 3) for 4 points"),
        ("state = None; harder = 0.0 * harder", "TypeError"),
        ("raise SystemExit(0)", "`update` of the law `Clay` in `clay.py` failed: SystemExit: 0"),
        ("raise GeneratorExit", "failed: GeneratorExit"),
    ],
)
def test_no_real_numbers_are_one_error(change: str, what: str, tmp_path: Path) -> None:
    """It names the method, the class, its file and the key of the material."""
    law = clay(tmp_path, change)
    with pytest.raises(BadInput) as caught:
        updated(law)
    assert what in str(caught.value)
    assert "the law `Clay` in `clay.py`" in str(caught.value)
    assert caught.value.key == "materials.clay.class"


def test_arrays_that_a_law_changes_or_protects_do_no_harm(tmp_path: Path) -> None:
    """It has arrays of its own; read-only views, whole numbers and other orders are numbers."""
    expected = updated(clay(tmp_path, "pass"))
    for change in (
        "trial[:] = 7.0; state = state.copy(); plastic_strain[:] = 9.0",
        "stress = np.broadcast_to(np.asfortranarray(stress), stress.shape)",
        "stress = stress.astype('>f8'); tangent = tangent.tolist()",
    ):
        found = updated(clay(tmp_path, change))
        for one, other in zip(found, expected, strict=True):
            np.testing.assert_array_equal(one, other)
            assert one.flags.writeable


@pytest.mark.parametrize("value", [[1, 2.0], np.float32(3.0), (True, False), np.arange(3)])
def test_real_numbers(value: Any) -> None:
    found = real_numbers(value)
    assert found.dtype == np.float64
    np.testing.assert_array_equal(found, value)


@pytest.mark.parametrize(
    ("method", "body"),
    [
        ("energy", "np.full(len(strain), np.nan)"),
        ("moduli", "(np.full(len(strain), np.inf), np.ones(len(strain)))"),
    ],
)
def test_an_elasticity_without_finite_numbers_is_refused(
    method: str, body: str, tmp_path: Path
) -> None:
    law = clay(tmp_path, "pass", "")
    code = (tmp_path / "clay.py").read_text() + f"\n    def {method}(self, strain, state):\n"
    (tmp_path / "clay.py").write_text(f"{code}        return {body}\n")
    law = PythonLaw(f"{tmp_path}/clay.py:Clay", {"young_modulus": 1e6, "poisson_ratio": 0.3,
                                                 **PLASTIC}, "materials.clay")  # fmt: skip
    with pytest.raises(BadInput, match="finite"):
        getattr(law, method)(np.zeros((2, 3)), np.zeros((2, 1)))


def python_law(folder: Path) -> dict[str, Any]:
    clay(folder, 'os.chdir("/")', "import os")
    parameters = {"young_modulus": 1e6, "poisson_ratio": 0.3, **PLASTIC, "yield_stress": 2e4}
    reference = f"{folder}/clay.py:Clay"
    return {"model": "user_python", "class": reference, "parameters": parameters, "density": 1.0}


def compiled_law(folder: Path) -> dict[str, Any]:
    return umat(library(folder, UMAT), 7, 1.0)


@pytest.mark.parametrize("material", [python_law, compiled_law])
def test_results_go_to_the_given_folder_whatever_folder_the_law_goes_to(
    material: Callable[[Path], dict[str, Any]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    case = COLUMN | {"materials": {"clay": material(tmp_path)}, "schedule": {"steps": 3}}
    result = run(Model.from_dict(case), "out", quiet=True)
    assert result.finished
    assert Path.cwd() == tmp_path
    assert len(result.history["step"]) == 4
    assert (tmp_path / "out" / "results.vtkhdf").exists()
    assert not os.path.exists("/out")


@pytest.mark.slow
def test_a_study_says_which_law_ended_a_sample(tmp_path: Path) -> None:
    file = library(tmp_path, UMAT)
    case = COLUMN | {"materials": {"clay": umat(file, 0, -1.0)}, "track": [
        {"name": "top", "quantity": "displacement", "at": [0.5, 5.0], "component": "y"},
    ]}  # fmt: skip
    (tmp_path / "case.toml").write_text(toml(case))
    (tmp_path / "study.toml").write_text(
        'format = 1\ncase = "case.toml"\n[[vary]]\nkey = "loads.0.acceleration.1"\n'
        "values = [-1.0, -1000.0]\n"
        '[[outcomes]]\ntype = "history"\nname = "top"\ncolumn = "top"\ntake = "last"\n'
    )
    ended = tilth(tmp_path, "study", "study.toml", "--out", "out", "--quiet")
    assert ended.returncode == 1
    table = (tmp_path / "out/study.csv").read_text()
    assert table.count("(materials.clay) ended the program") == 1
