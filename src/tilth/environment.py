# SPDX-License-Identifier: BSD-3-Clause
"""Variables of the environment that libraries read when they are loaded."""

from __future__ import annotations

import os
from collections.abc import MutableMapping

THREAD_WAIT = {"OMP_WAIT_POLICY": "passive", "GOMP_SPINCOUNT": "10000"}
"""Idle threads spin for a fraction of a millisecond, then sleep. Sleeping threads leave the cores
free for Python and the linear solver; waking them takes longer than most loops of multigrid
(docs/decisions/0012-multigrid.md)."""

ONE_RUNTIME = {"MKL_THREADING_LAYER": "GNU"}
"""PARDISO uses the threads of the core's OpenMP runtime, not those of a second runtime."""


def set_environment(environment: MutableMapping[str, str]) -> None:
    """Sets the environment variables that the libraries read at load time, unless they are set.

    They apply to the whole process, so the command sets them and `import tilth` does not.
    """
    if "OMP_WAIT_POLICY" not in environment:
        for name, value in THREAD_WAIT.items():
            environment.setdefault(name, value)
    for name, value in ONE_RUNTIME.items():
        environment.setdefault(name, value)


def available_cores() -> int:
    """Returns the number of cores that this process may use; 1 where nobody can tell."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


USER_MODULE = "tilth_user_"
"""At the start of the names of the modules that the user's Python files become."""


SIZES = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_SIZE", "MPI_LOCALNRANKS")
"""Variables of the environment by which launchers tell a process how many there are."""


def several_processes() -> bool:
    """Returns whether a launcher such as `mpiexec` started several processes."""
    return any(int(os.environ.get(name) or 1) > 1 for name in SIZES)
