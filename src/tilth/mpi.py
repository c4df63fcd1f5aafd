# SPDX-License-Identifier: BSD-3-Clause
"""The processes that `mpiexec` starts, through mpi4py."""

from __future__ import annotations

import ctypes
import io
import math
import pickle
import sys
import time
import traceback
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from types import TracebackType
from typing import Any, TypeVar

import numpy as np

from tilth.comm import SERIAL, Array, Communicator
from tilth.environment import several_processes
from tilth.errors import BadInput

T = TypeVar("T")

INSTALL = "install mpi4py and petsc4py (docs/howto/many_machines.md), or run without mpiexec"


@cache
def world() -> Communicator:
    """Returns the communicator of all processes of this run; the serial one without `mpiexec`.

    Raises:
        BadInput: `mpiexec` started several processes, but mpi4py is not installed.
    """
    if not several_processes():
        return SERIAL
    try:
        from mpi4py import MPI
    except ImportError as error:
        raise BadInput(
            f"mpiexec started several processes, but mpi4py cannot be imported ({error})", INSTALL
        ) from error
    if MPI.COMM_WORLD.size == 1:
        what = "mpiexec is that of another MPI library than mpi4py's: each process is alone"
        raise BadInput(what, "start the run with the mpiexec of the library that mpi4py uses")
    sys.excepthook = _abort
    return Processes(MPI.COMM_WORLD)


def return_memory() -> None:
    """Gives memory that is not used any more back to the system: glibc would keep it."""
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)


LONGEST_WAIT = 10.0
"""How long a process that ends by an error waits for the others to end, too [s]."""


def begin_together() -> bool:
    """Connects the processes of a command; returns whether this is the one that prints anything.

    Raises:
        BadInput: see `world`.
    """
    if world().rank == 0:
        return True
    sys.stdout = sys.stderr = io.StringIO()
    return False


def leave_together(code: int) -> None:
    """Waits for the other processes, which end with the same exit code or as they are.

    Where this one ends by an error and another does not come, it waits for a message of this one,
    and all are ended.
    """
    with suppress(BadInput):  # there is no connection that could be ended
        if world().size > 1:
            _leave(code)


def _leave(code: int) -> None:
    from mpi4py import MPI

    arrived, deadline = MPI.COMM_WORLD.Ibarrier(), time.monotonic() + LONGEST_WAIT
    while not arrived.Test():
        if code != 0 and time.monotonic() > deadline:
            if isinstance(sys.stderr, io.StringIO):
                print(sys.stderr.getvalue(), file=sys.__stderr__, flush=True)
            MPI.COMM_WORLD.Abort(code)
        time.sleep(0.01)


def _abort(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    """Ends all processes where one ends by an unexpected error: the others would wait for it."""
    from mpi4py import MPI

    traceback.print_exception(kind, error, trace)
    sys.stderr.flush()
    MPI.COMM_WORLD.Abort(4)


class Processes:
    """The processes of an MPI communicator, see `Communicator`.

    Arrays go as one message of bytes each, without a limit of 2 GiB for all together.

    Attributes:
        mpi: the communicator of mpi4py.
    """

    def __init__(self, mpi: Any) -> None:
        self.mpi = mpi
        self.rank: int = mpi.rank
        self.size: int = mpi.size
        self.sent = 0

    def sum(self, value: float) -> float:
        """As `Communicator.sum`; exact, so that it does not depend on the order."""
        return math.fsum(self._of_all(value))

    def max(self, value: float) -> float:
        """As `Communicator.max`; a value that is not a number counts as the largest."""
        values = self._of_all(value)
        return math.nan if any(map(math.isnan, values)) else max(values)

    def _of_all(self, value: float) -> list[float]:
        values = np.empty(self.size)
        self.mpi.Allgather(np.array([value]), values)
        return values.tolist()

    def gathered(self, value: T) -> list[T]:
        """As `Communicator.gathered`."""
        found: list[T] = self.mpi.allgather(value)
        return found

    def gathered_first(self, value: T) -> list[T]:
        """As `Communicator.gathered_first`."""
        packed = pickle.dumps(value, protocol=5)
        if self.rank > 0:
            self.mpi.send(packed, dest=0)
            self.sent += len(packed)
            return []
        return [value, *(pickle.loads(self.mpi.recv(source=r)) for r in range(1, self.size))]

    def exchanged(self, values: Sequence[T]) -> list[T]:
        """As `Communicator.exchanged`; one message to each process that there is something for."""
        packed = [
            None if value is None or r == self.rank else pickle.dumps(value, protocol=5)
            for r, value in enumerate(values)
        ]
        lengths = self.mpi.alltoall([0 if each is None else len(each) for each in packed])
        self.sent += sum(len(each) for each in packed if each is not None)
        waiting = [
            self.mpi.Isend(each, dest=r) for r, each in enumerate(packed) if each is not None
        ]
        found: list[Any] = [None] * self.size
        found[self.rank] = values[self.rank]
        for r, length in enumerate(lengths):
            if length:
                buffer = bytearray(length)
                self.mpi.Recv(buffer, source=r)
                found[r] = pickle.loads(buffer)
        for each in waiting:
            each.Wait()
        return found

    def exchange_arrays(self, given: Sequence[Array | None], found: Sequence[Array | None]) -> None:
        """As `Communicator.exchange_arrays`."""
        waiting = [
            self.mpi.Irecv(each, source=r)
            for r, each in enumerate(found)
            if each is not None and r != self.rank
        ]
        for r, each in enumerate(given):
            if each is not None and r != self.rank:
                waiting.append(self.mpi.Isend(each, dest=r))
                self.sent += each.nbytes
        for request in waiting:
            request.Wait()
