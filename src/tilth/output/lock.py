# SPDX-License-Identifier: BSD-3-Clause
"""The lock of a run's folder: one run at a time writes there, and the lock ends with its process.

It is a lock of the operating system on a hidden file (`flock`), which the system releases however
the process ends. The file's content only says who holds it. The file is deleted before the lock is
released; a process that locked a file which was deleted meanwhile notices by its inode and tries
again.
"""

from __future__ import annotations

import errno
import json
import os
import platform
import shlex
import sys
import time
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from datetime import datetime
from pathlib import Path
from types import TracebackType

from tilth.errors import BadInput, shown
from tilth.input_files import require_file, require_plain_files

LOCK = ".tilth.lock"

_ATTEMPTS, _PAUSE = 10, 0.02
"""Attempts to lock and the pause between them [s]: `holder_of` locks for a moment too."""

_IN_USE = (errno.EAGAIN, errno.EACCES)


@dataclass(frozen=True)
class Holder:
    """Who holds the lock of a folder.

    Attributes:
        process: its number.
        host: name of its machine.
        since: date and time.
        command: what was started there.
    """

    process: int
    host: str
    since: str
    command: str

    def __str__(self) -> str:
        if (self.process, self.host) == (os.getpid(), platform.node()):
            return f"this process, number {self.process}, since {self.since}"
        return (
            f"process {self.process} on {self.host or 'this machine'}, since {self.since}: "
            f"{self.command}"
        )


class FolderLock:
    """Holds the folder of a run as a context manager; other processes and threads are refused.

    Attributes:
        warning: why the folder is not protected, where the file system has no locks; otherwise "".

    Raises:
        BadInput: at entry: another run holds the folder, or the folder cannot be written.
    """

    def __init__(self, folder: Path | str) -> None:
        self.folder = Path(folder)
        self.warning = ""
        self._file: int | None = None

    def __enter__(self) -> FolderLock:
        path = self.folder / LOCK
        require_plain_files([path])
        for attempt in range(_ATTEMPTS):
            if attempt:
                time.sleep(_PAUSE)
            try:
                file = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
            except OSError as error:
                raise BadInput(
                    f"{self.folder} cannot be written: {error.strerror}",
                    "name a folder in which you may write",
                ) from None
            try:
                _lock(file)
            except OSError as error:
                if error.errno in _IN_USE:
                    os.close(file)
                    continue
                self.warning = (
                    f"{self.folder} cannot be locked on this file system ({error.strerror}): "
                    "take care that no other run uses it"
                )
            if not self.warning and not _is_same(file, path):
                os.close(file)  # the run before it ended between our two calls
                continue
            self._file = file
            with suppress(OSError):  # a full disk: the first file of the run says so
                os.ftruncate(file, 0)
                os.pwrite(file, json.dumps(asdict(_this_process())).encode(), 0)
            return self
        holder = _read_holder(path)
        who = f" by {holder}" if holder else ""
        raise BadInput(
            f"the folder {self.folder} is in use{who}",
            "wait until that run has ended, or choose another folder",
        )

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        assert self._file is not None
        (self.folder / LOCK).unlink(missing_ok=True)
        os.close(self._file)
        self._file = None


def holder_of(folder: Path | str) -> Holder | None:
    """Returns who runs in a folder at the moment; None if nobody does, or nobody can tell."""
    path = Path(folder) / LOCK
    try:
        require_file(path)
        file = os.open(path, os.O_RDWR)
    except OSError:
        return None
    try:
        _lock(file)
    except OSError as error:
        return _read_holder(path) if error.errno in _IN_USE else None
    finally:
        os.close(file)
    return None


def _lock(file: int) -> None:
    """Locks an open file without waiting; raises `OSError` if it is locked or cannot be."""
    try:
        import fcntl
    except ImportError:  # not a POSIX system
        raise OSError(errno.ENOTSUP, os.strerror(errno.ENOTSUP)) from None
    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _is_same(file: int, path: Path) -> bool:
    """Returns whether `path` still is the open file."""
    try:
        return os.path.samestat(os.fstat(file), os.stat(path))
    except FileNotFoundError:
        return False


def _this_process() -> Holder:
    command = shlex.join([Path(sys.argv[0]).name or "python", *sys.argv[1:]])
    return Holder(
        process=os.getpid(),
        host=platform.node(),
        since=datetime.now().astimezone().isoformat(sep=" ", timespec="seconds"),
        command=shown(command).strip('"'),
    )


def _read_holder(path: Path) -> Holder | None:
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
        return Holder(**{entry.name: entries[entry.name] for entry in fields(Holder)})
    except (OSError, ValueError, TypeError, KeyError):
        return None
