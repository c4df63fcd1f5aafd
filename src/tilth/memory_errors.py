# SPDX-License-Identifier: BSD-3-Clause
"""Failures of a run that come from too little memory, whichever library reports them."""

from __future__ import annotations

import errno
import re

REMEDY = (
    "a coarser grid, fewer material points, another linear solver, or a machine or a limit with "
    "more memory avoids this"
)
"""What helps where the memory does not suffice."""

_MESSAGE = re.compile(
    r"out of memory|not enough memory|malloc fail|bad_alloc|failed to map segment"
    r"|(cannot|can't|unable to|failed to) allocate|allocation failed",
    re.IGNORECASE,
)
"""What HDF5, SuperLU, PARDISO and the loader of shared libraries report."""


def is_memory_error(error: BaseException) -> bool:
    """Returns whether an exception, or the one that led to it, reports too little memory."""
    found: BaseException | None = error
    while found is not None:
        if isinstance(found, MemoryError):
            return True
        if isinstance(found, OSError) and found.errno == errno.ENOMEM:
            return True
        if isinstance(found, (OSError, ImportError, RuntimeError)) and _MESSAGE.search(str(found)):
            return True
        found = found.__cause__ or found.__context__
    return False


def requested(error: BaseException) -> str:
    """Returns how much memory was requested in vain, such as "7.45 GiB"; "" if it is not known."""
    known = re.search(r"Unable to allocate ([0-9.]+ [KMGTP]?i?B(?:ytes)?)", str(error))
    return known.group(1) if known else ""


def memory_sentence(error: BaseException) -> str:
    """Returns a sentence that says that the memory does not suffice, and for how much."""
    size = requested(error)
    return f"there is not enough memory{f' for another {size}' if size else ''}"
