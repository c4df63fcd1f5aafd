# SPDX-License-Identifier: BSD-3-Clause
"""Gmsh for a test, which is skipped where it is not installed."""

from __future__ import annotations

import importlib
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """Gives Gmsh, started; afterwards a closed pipe is an error again, which Gmsh lets kill us."""
    try:
        gmsh = importlib.import_module("gmsh")
    except (ImportError, OSError) as error:  # it needs libraries of the screen
        pytest.skip(str(error))
    before = signal.getsignal(signal.SIGPIPE)
    gmsh.initialize(interruptible=False)
    try:
        yield gmsh
    finally:
        gmsh.finalize()
        signal.signal(signal.SIGPIPE, before)
