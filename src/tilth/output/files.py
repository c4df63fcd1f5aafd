# SPDX-License-Identifier: BSD-3-Clause
"""Replacement of files that is safe against a kill or a power cut at any moment."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tilth.input_files import absolute, require_file

WRITTEN_ASIDE = "new."
"""Before the number of a process that may write a file while another process does, too."""


RESTORE = "restore it from a copy, or run the case again"
"""What helps where a file of a run is damaged."""


def temporary(path: Path, use: str = "new") -> Path:
    """Returns the hidden name of a file that exists only while ``path`` is written."""
    return path.with_name(f".{path.name}.{use}")


def sync_file(path: Path) -> None:
    """Waits until the content of ``path`` is on the disk."""
    with path.open("rb+") as file:
        os.fsync(file.fileno())


def sync_folder(folder: Path) -> None:
    """Waits until the names in ``folder`` are on the disk (where the system can do that)."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def replace_durably(new: Path, path: Path) -> None:
    """Renames the complete file ``new`` to ``path`` atomically; both are in the same folder."""
    sync_file(new)
    os.replace(new, path)
    sync_folder(path.parent)


def write_durably(path: Path, content: bytes, use: str = "new") -> None:
    """Writes ``content`` to ``path``: at any moment the old or the new file exists, complete.

    ``use`` is part of the name of the temporary file: give each of several writers its own.
    """
    new = temporary(path, use)
    with removed_on_failure(new):
        new.write_bytes(content)
        replace_durably(new, path)


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Gives the hidden name of a file to write beside ``path``, which replaces it at the end.

    It has the same ending and is absolute, so that no program takes it for an option or another
    place. If it is not completed it is removed, and an earlier file stays as it is.

    Raises:
        OSError: there is something else than a file at ``path``, or it cannot be replaced.
    """
    target = absolute(path)
    if os.path.lexists(target):
        require_file(target)
    new = target.with_name(f".tilth.{WRITTEN_ASIDE}{os.getpid()}{target.suffix}")
    with removed_on_failure(new):
        yield new
        replace_durably(new, target)


@contextmanager
def removed_on_failure(new: Path) -> Iterator[None]:
    """Removes the file ``new`` if it is not completed within this context."""
    try:
        yield
    except BaseException:
        with suppress(OSError):
            new.unlink(missing_ok=True)
        raise


def exchange_durably(new: Path, path: Path) -> bool:
    """As :func:`replace_durably`, but the earlier file at ``path`` gets the name ``new``.

    Returns whether there was one. Without hard links it is copied.
    """
    old = temporary(path, "old")
    old.unlink(missing_ok=True)
    existed = path.exists()
    if existed:
        try:
            os.link(path, old)
        except OSError:
            shutil.copyfile(path, old)
    replace_durably(new, path)
    if existed:
        os.replace(old, new)
    return existed
