# SPDX-License-Identifier: BSD-3-Clause
"""Copies of the source for mutants: one without changes, one that gets them; builds and tests.

As a plugin of pytest (`-p mutant_workshop`) this module writes down which test fails.
"""

from __future__ import annotations

import hashlib
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mutant_list import ROOT, Mutant

FOLDER = ROOT / "build" / "mutants"
FAILED = "TILTH_MUTANTS_FAILED"
"""Environment variable: the file to which a failing test is written."""

PETSC = "tests/unit/test_petsc.py"
"""Tests that need petsc4py in the Python that runs them: that of several processes."""

OPTIMISATION = "-O2"
"""Of the core's build. With -O1 GCC 12 makes a wrong stiffness in 3D."""

PATIENCE = 10.0
"""Wall-clock time over processor time from which on tests hang: they may wait for a message."""

FIRST_PASS = 0
NO_TESTS = 5
"""Exit codes of pytest without a failure."""


class BuildFailed(Exception):
    """The core cannot be built; the text is what the compiler says."""


@dataclass(frozen=True)
class Tested:
    """What became of a run of pytest: the first test that failed, or whether it took too long."""

    failed: str = ""
    hangs: bool = False


class Workshop:
    """Two copies of the tracked files, a build of the core, and what is known of tests without it.

    jobs: processes of the compiler.
    """

    def __init__(self, jobs: int) -> None:
        self._jobs = jobs
        self.clean, self.changed = FOLDER / "clean", FOLDER / "changed"
        self._core, self._core_clean = FOLDER / "core", FOLDER / "core_clean"
        self._passing = FOLDER / "passing.json"

    def __enter__(self) -> Workshop:
        FOLDER.mkdir(parents=True, exist_ok=True)
        marks = [_copy_tracked(each) for each in (self.clean, self.changed)]
        assert marks[0] == marks[1], "the working tree changes while it is copied"
        self._mark = marks[0]
        _restore_folder(self._core_clean, self._core)
        self._build()
        _restore_folder(self._core, self._core_clean)
        for tree in (self.clean, self.changed):
            self._install(tree)
        return self

    def __exit__(self, *_: object) -> None:
        return

    @property
    def has_processes(self) -> bool:
        """Whether runs of several processes can be started."""
        return "TILTH_MPI_PYTHON" in os.environ and shutil.which("mpiexec") is not None

    @contextmanager
    def applied(self, mutant: Mutant) -> Iterator[None]:
        """The changed copy has the change, and the core is built with it where it concerns it."""
        file = self.changed / mutant.file
        text = mutant.applied(file.read_text(encoding="utf-8"))
        try:
            file.write_text(text, encoding="utf-8")
            _forget_compiled(file)
            if mutant.is_compiled:
                self._build()
                self._install(self.changed)
            yield
        finally:
            shutil.copy2(self.clean / mutant.file, file)
            _forget_compiled(file)
            if mutant.is_compiled:
                _restore_folder(self._core_clean, self._core)
                self._install(self.changed)

    def first_failure(
        self, tests: Sequence[str], limit: float, excluded: Sequence[str] = (), clean: bool = False
    ) -> Tested:
        """Runs tests up to the first that fails.

        tests: arguments of pytest. limit: of the processor time [s]. excluded: tests that are left
        out. clean: in the copy without changes.
        """
        tree = self.clean if clean else self.changed
        note = FOLDER / "failed.txt"
        note.unlink(missing_ok=True)
        python = sys.executable
        if any(PETSC in each for each in tests):
            python = os.environ.get("TILTH_MPI_PYTHON", python)
        command = [python, "-m", "pytest", "-o", "addopts=-q", "-x", "--tb=no", "-p",
                   "no:cacheprovider", "-p", "mutant_workshop", *tests]  # fmt: skip
        for each in excluded:
            command += ["--deselect", each]
        code = _run(command, tree, {**_environment(tree), FAILED: str(note)}, limit)
        if code is None:
            return Tested(hangs=True)
        if note.exists():
            return Tested(note.read_text(encoding="utf-8").splitlines()[0])
        if code not in (FIRST_PASS, NO_TESTS):
            return Tested(f"pytest ends with {code}")
        return Tested()

    def passes_without(self, test: str) -> bool:
        """Returns whether a test passes in the copy without changes."""
        if "::" not in test and not test.endswith(".py"):
            return True
        known: dict[str, Any] = {}
        with suppress(OSError, ValueError):
            known = json.loads(self._passing.read_text(encoding="utf-8"))
        if known.get("mark") != self._mark:
            known = {"mark": self._mark, "passes": {}}
        if test not in known["passes"]:
            found = self.first_failure([test], 600.0, clean=True)
            known["passes"][test] = found == Tested()
            self._passing.write_text(json.dumps(known), encoding="utf-8")
        return bool(known["passes"][test])

    def _build(self) -> None:
        """Builds the core of the changed copy, only what its changes concern."""
        cmake = shutil.which("cmake") or _missing("cmake")
        if not (self._core / "build.ninja").exists():
            shutil.which("ninja") or _missing("ninja")
            compiled = "<CMAKE_CXX_COMPILER> <DEFINES> <INCLUDES> <FLAGS> "
            nanobind = subprocess.run(
                [sys.executable, "-m", "nanobind", "--cmake_dir"],
                check=True, capture_output=True, text=True,
            ).stdout.strip()  # fmt: skip
            _checked([
                cmake, "-S", str(self.changed), "-B", str(self._core), "-G", "Ninja",
                f"-DPython_EXECUTABLE={sys.executable}", f"-Dnanobind_DIR={nanobind}",
                f"-DCMAKE_CXX_COMPILE_OBJECT={compiled}{OPTIMISATION} -o <OBJECT> -c <SOURCE>",
            ])  # fmt: skip
        _checked([cmake, "--build", str(self._core), "-j", str(self._jobs)])

    def _install(self, tree: Path) -> None:
        """Copies the core that was built last to a copy of the sources, if it is another one."""
        for built in [*self._core.glob("_core*.so"), self._core / "_abaqus.so"]:
            place = tree / "src" / "tilth" / built.name
            if not place.exists() or place.read_bytes() != built.read_bytes():
                shutil.copy2(built, part := place.with_name("core.part"))
                part.replace(place)


def _missing(program: str) -> str:
    raise SystemExit(f"{program} is missing: pip install cmake ninja nanobind")


def _checked(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        errors = [line for line in done.stdout.splitlines() if "error" in line.lower()]
        raise BuildFailed("\n".join([done.stdout, done.stderr, *errors[:1]]).strip())


def _environment(tree: Path) -> dict[str, str]:
    paths = os.pathsep.join(str(tree / each) for each in ("src", "tests"))
    return {**os.environ, "PYTHONPATH": paths, "OMP_WAIT_POLICY": "passive"}


def _run(command: list[str], folder: Path, environment: dict[str, str], limit: float) -> int | None:
    """Returns the exit code; None if the command and what it started had to be ended.

    limit: processor time of each process [s], and a share of the wall-clock time (`PATIENCE`).
    """
    cpu = int(limit)
    process = subprocess.Popen(
        command, cwd=folder, env=environment, start_new_session=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (cpu, cpu)),
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        code = process.wait(timeout=PATIENCE * limit)
        return None if code in (-signal.SIGXCPU, -signal.SIGKILL) else code
    except subprocess.TimeoutExpired:
        return None
    finally:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _copy_tracked(tree: Path) -> str:
    """Makes a folder the same as the tracked files of the working tree; returns their check sum.

    Files that have the same contents are not touched, so that the core is built incrementally.
    """
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.split("\0")
    names = [name for name in listed if name and (ROOT / name).is_file()]
    every = hashlib.sha256()
    for name in names:
        source, place = ROOT / name, tree / name
        contents = source.read_bytes()
        every.update(name.encode() + contents)
        if not place.is_file() or place.read_bytes() != contents:
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, place)
            shutil.copymode(source, place)
            _forget_compiled(place)
    wanted = {tree / name for name in names}
    for found in [*tree.rglob("*.py"), *tree.rglob("*.hpp"), *tree.rglob("*.toml")]:
        if found not in wanted:
            found.unlink()
    return every.hexdigest()


def _restore_folder(source: Path, place: Path) -> None:
    """Makes a folder the same as another one, with the times of its files."""
    if not source.is_dir():
        return
    for file in place.rglob("*"):
        if file.is_file() and not (source / file.relative_to(place)).exists():
            file.unlink()
    for file in source.rglob("*"):
        if not file.is_file():
            continue
        other = place / file.relative_to(source)
        same = other.exists() and other.stat().st_mtime_ns == file.stat().st_mtime_ns
        if not same:
            other.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(file, other)


def _forget_compiled(file: Path) -> None:
    """Removes what Python keeps of a source: it compares times in whole seconds only."""
    for cached in (file.parent / "__pycache__").glob(f"{file.stem}.*.pyc"):
        cached.unlink(missing_ok=True)


def _write_down(report: Any) -> None:
    if report.failed and (note := os.environ.get(FAILED)):
        with open(note, "a", encoding="utf-8") as file:
            file.write(f"{report.nodeid}\n")


def pytest_runtest_logreport(report: Any) -> None:
    """Hook of pytest: after each part of a test."""
    _write_down(report)


def pytest_collectreport(report: Any) -> None:
    """Hook of pytest: after reading a file with tests."""
    _write_down(report)
