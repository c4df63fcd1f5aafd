# SPDX-License-Identifier: BSD-3-Clause
"""Replacing a file so that neither a kill nor a power cut leaves a broken one behind."""

from __future__ import annotations

import os
import shutil
from pathlib import Path


def sync_file(path: Path) -> None:
    """Wait until the content of ``path`` is on the disk."""
    with path.open("rb+") as file:
        os.fsync(file.fileno())


def sync_folder(folder: Path) -> None:
    """Wait until the names in ``folder`` are on the disk (where the system can do that)."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def replace_durably(new: Path, path: Path) -> None:
    """Give the finished file ``new`` the name ``path``, atomically; both in the same folder."""
    sync_file(new)
    os.replace(new, path)
    sync_folder(path.parent)


def write_durably(path: Path, content: bytes) -> None:
    """Write ``content`` to ``path``: at any moment the old or the new file is there, whole."""
    new = path.with_name(f".{path.name}.new")
    new.write_bytes(content)
    replace_durably(new, path)


def exchange_durably(new: Path, path: Path) -> bool:
    """Like :func:`replace_durably`, but the file that was at ``path`` lives on under ``new``.

    Returns whether there was such a file. Without hard links it is copied.
    """
    old = new.with_name(f"{new.name}.old")
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
