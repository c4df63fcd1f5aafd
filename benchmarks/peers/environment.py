# SPDX-License-Identifier: BSD-3-Clause
"""A virtual environment of its own with Kratos MPM from PyPI."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

PACKAGES = ("KratosMultiphysics", "KratosLinearSolversApplication", "KratosMPMApplication")
IMPORTS = "import KratosMultiphysics, KratosMultiphysics.MPMApplication"


class NoPeer(Exception):
    """Kratos cannot be had here; the message says why and what can be done."""


@dataclass(frozen=True)
class KratosEnvironment:
    """An environment in which Kratos MPM runs.

    Attributes:
        python: its interpreter.
        version: of Kratos MPM.
    """

    python: Path
    version: str


def kratos_environment(
    folder: Path, version: str | None = None, interpreter: str = sys.executable
) -> KratosEnvironment:
    """Returns the environment in `folder`, which is made when it is not there.

    Args:
        version: of Kratos; the newest that pip finds if None.
        interpreter: Python that the environment is made with.

    Raises:
        NoPeer: no environment can be made, or PyPI has no Kratos for it.
    """
    python = folder.absolute() / "bin/python"
    if not python.exists():
        run([interpreter, "-m", "venv", str(folder)], "no virtual environment can be made")
    found = installed(python)
    if found is None or version not in (None, found):
        wanted = [name if version is None else f"{name}=={version}" for name in PACKAGES]
        pip = [str(python), "-m", "pip", "install", "--only-binary", ":all:"]
        run(
            [*pip, *wanted],
            f"pip cannot install {', '.join(wanted)}; PyPI has Kratos as wheels for some systems "
            "and Python versions only: take another Python with --python, or another --version",
        )
        found = installed(python)
    run([str(python), "-c", IMPORTS], f"Kratos is installed in {folder} but cannot be imported")
    assert found is not None
    return KratosEnvironment(python, found)


def installed(python: Path) -> str | None:
    """The version of Kratos MPM in an environment; None without."""
    ask = f"import importlib.metadata as m; print(m.version({PACKAGES[-1]!r}))"
    answer = subprocess.run([str(python), "-c", ask], capture_output=True, text=True)
    return answer.stdout.strip() if answer.returncode == 0 else None


def run(command: list[str], failure: str) -> None:
    """Runs a command; raises NoPeer with `failure` and the end of what it wrote."""
    try:
        done = subprocess.run(command, capture_output=True, text=True)
    except OSError as error:
        raise NoPeer(f"{failure}: {error}") from error
    if done.returncode:
        end = (done.stdout + done.stderr).strip()[-800:]
        raise NoPeer(f"{failure}.\n{' '.join(command)}\n{end}")
