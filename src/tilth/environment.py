# SPDX-License-Identifier: BSD-3-Clause
"""Variables of the environment that libraries read when they are loaded."""

from __future__ import annotations

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
