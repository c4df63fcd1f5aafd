# SPDX-License-Identifier: BSD-3-Clause
"""Files that the user names: only those that can be read to their end, and never waited for.

A pipe is written by somebody some day, or never; a device such as /dev/zero has no end. Both look
like files to a program that opens them.
"""

from __future__ import annotations

import errno
import math
import os
import stat
from collections.abc import Iterable
from pathlib import Path

from tilth.errors import BadInput

_CIRCLE = "its symbolic links lead in a circle"
_NONE = "there is no such {}"

_KINDS = (
    (stat.S_ISREG, "a file"),
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


class NoFile(OSError):
    """A path that is not that of a file; `strerror` says why, in words of the user."""


def absolute(path: Path | str) -> Path:
    """Returns the path from the root, without symbolic links; those of a circle stay as they are.

    `Path.resolve` raises RuntimeError for a circle, in some versions of Python.
    """
    return Path(os.path.realpath(path))


def why_no_file(path: Path | str) -> str:
    """Returns why a path is not that of a file that can be read to its end; "" if it is."""
    return _why_not(path, "a file")


def why_no_folder(path: Path | str) -> str:
    """Returns why a path is not that of a folder; "" if it is."""
    return _why_not(path, "a folder")


def require_file(path: Path | str) -> None:
    """Passes if a path is that of a file that can be read to its end.

    Raises:
        FileNotFoundError: there is nothing.
        IsADirectoryError: it is a folder.
        NoFile: it is a pipe, a socket, a device or a circle of links, or nobody can tell.
    """
    if reason := why_no_file(path):
        number = errno.EINVAL
        if reason == _NONE.format("file"):
            number = errno.ENOENT
        elif os.path.isdir(path):
            number = errno.EISDIR
        raise (NoFile if number == errno.EINVAL else OSError)(number, reason, str(path))


def require_plain_files(paths: Iterable[Path]) -> None:
    """Refuses something else than a file where tilth reads and writes files of its own.

    Raises:
        BadInput: one of the paths is that of a pipe, a device or a folder.
    """
    for path in paths:
        reason = why_no_file(path) if os.path.lexists(path) else ""
        if reason and reason != _NONE.format("file"):
            problem = f"{path} has the name of a file of tilth's, but {reason}"
            raise BadInput(problem, "rename or delete it")


def why_failed(error: BaseException) -> str:
    """Returns why a file could not be read, in one line, from what a reader raised."""
    text = error.strerror if isinstance(error, OSError) else str(error)
    return " ".join((text or "").split()) or "it is not in that format, or not complete"


MOST_GROWTH = 1000
"""How often the size of a file its numbers may need in memory, at most."""


def asks_too_much(error: BaseException, path: Path) -> bool:
    """Returns whether a reader asked for memory out of all proportion to a file.

    The counts in such a file are wrong; more memory would not help.

    Args:
        error: of numpy, which says how large the array was to be.
        path: of the file.
    """
    shape, kind = getattr(error, "shape", None), getattr(error, "dtype", None)
    if shape is None or kind is None:
        return False
    return bool(math.prod(shape) * int(kind.itemsize) > MOST_GROWTH * path.stat().st_size)


def _why_not(path: Path | str, wanted: str) -> str:
    noun = wanted.removeprefix("a ")
    try:
        mode = os.stat(path).st_mode
    except (FileNotFoundError, NotADirectoryError):
        return _NONE.format(noun)
    except OSError as error:
        if error.errno == errno.ELOOP:
            return _CIRCLE
        return error.strerror or str(error)
    except ValueError:  # a character that no path has
        return _NONE.format(noun)
    kind = next((name for is_kind, name in _KINDS if is_kind(mode)), "something else")
    return "" if kind == wanted else f"it is {kind}, not {wanted}"
