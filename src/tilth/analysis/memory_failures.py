# SPDX-License-Identifier: BSD-3-Clause
"""A run that the memory does not suffice for, as an error that says what can be done."""

from __future__ import annotations

import mmap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tilth.available_memory import limits_of_process
from tilth.errors import AnalysisFailed, TilthError
from tilth.memory_errors import REMEDY, is_memory_error, memory_sentence
from tilth.memory_estimate import MemoryEstimate
from tilth.output.folder import CHECKPOINT

BLAS_BUFFERS = 100 * 2**20
"""Memory that the linear algebra libraries of NumPy and SciPy take at their first use [byte]."""


@contextmanager
def memory_failures(estimate: MemoryEstimate, folder: Path) -> Iterator[None]:
    """Turns the failures of a run that come from too little memory into `AnalysisFailed`.

    The files in the folder are those of the last complete step: the state in memory may be
    incomplete and is not written.

    Args:
        estimate: of the run.
        folder: of the results.

    Raises:
        AnalysisFailed: there was not enough memory.
    """
    try:
        _take_blas_buffers()
        yield
    except TilthError:
        raise
    except Exception as error:
        if not is_memory_error(error):
            raise
        kept = "no step is complete"
        if (folder / CHECKPOINT).exists():
            kept = f"`tilth resume {folder}` continues after the last complete step"
        raise AnalysisFailed(
            f"{memory_sentence(error)} ({estimate.size}, linear solver {estimate.solver})",
            f"{kept}; {REMEDY}",
        ) from error


def _take_blas_buffers() -> None:
    """Lets the linear algebra libraries take their buffers while there is memory.

    OpenBLAS waits for ever if it cannot have them later. That can only be where a limit is set on
    the process; elsewhere the system grants memory until it is used.

    Raises:
        MemoryError: there is no memory for them.
    """
    if not any(limits_of_process()):
        return
    import numpy as np
    from scipy.linalg.blas import dgemm, dtrsv

    try:
        mmap.mmap(-1, BLAS_BUFFERS).close()
    except OSError as error:
        raise MemoryError("no memory for the buffers of the linear algebra libraries") from error
    square = np.eye(400, order="F")  # small products do without the buffers
    dgemm(1.0, square, square)
    dtrsv(square, square[0])
    np.dot(square, square)
