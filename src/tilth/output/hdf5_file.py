# SPDX-License-Identifier: BSD-3-Clause
"""Writing HDF5 files on a disk that may be full.

A write that fails inside HDF5 can end the process (HDF5 2.0 does at the close of the file), and
leaves the file open. So HDF5 writes through a Python file, which keeps the first error to itself
until HDF5 has closed the file, and then raises it.
"""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

SMALL = 65536
"""Size up to which a piece that could not be written is kept [bytes]: all of HDF5's metadata."""


@contextmanager
def open_to_write(raw: KeptError) -> Iterator[Any]:
    """Yields the `h5py.File` in ``raw``, which is closed at the end.

    Raises ``OSError`` at the end if anything could not be written; the file is then incomplete.
    """
    import h5py

    with raw:
        with h5py.File(raw, "a", libver=("v110", "v110")) as file:  # metadata with sums
            yield file
        raw.raise_kept()


class KeptError(io.RawIOBase):
    """A file for reading and writing that does not raise when a write fails.

    After a failed write nothing more is written, and reading gives what HDF5 needs in order to
    close the file. `raise_kept` raises the first error, also a KeyboardInterrupt.
    """

    def __init__(self, path: Path) -> None:
        """Opens or creates ``path``. Raises `OSError`, also if another program has it open."""
        super().__init__()
        self._file = io.FileIO(os.open(path, os.O_RDWR | os.O_CREAT, 0o666), "r+")
        self._error: BaseException | None = None
        self._lost: list[tuple[int, bytes]] = []
        self._at = 0
        try:
            _lock(self._file)
            self._end = self._file.seek(0, os.SEEK_END)
        except BaseException:
            self._file.close()
            raise

    def raise_kept(self) -> None:
        """Raises the error of the first write that failed."""
        if self._error is not None:
            raise self._error

    def readable(self) -> bool:
        """Returns True."""
        return True

    def writable(self) -> bool:
        """Returns True."""
        return True

    def seekable(self) -> bool:
        """Returns True."""
        return True

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Sets the position; returns it."""
        start = {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._end}
        self._at = start[whence] + offset
        return self._at

    def tell(self) -> int:
        """Returns the position."""
        return self._at

    def readinto(self, buffer: Any) -> int:
        """Reads at the position until ``buffer`` is full; zeros where the file ends before."""
        view = memoryview(buffer).cast("B")
        done = 0
        try:
            self._file.seek(self._at)
            while done < len(view) and (read := self._file.readinto(view[done:])):
                done += read
        except BaseException as error:
            self._keep(error)
        view[done:] = bytes(len(view) - done)
        for start, piece in self._lost:
            low, high = max(start, self._at), min(start + len(piece), self._at + len(view))
            if low < high:
                view[low - self._at : high - self._at] = piece[low - start : high - start]
        self._at += len(view)
        return len(view)

    def write(self, content: Any) -> int:
        """Writes at the position; returns the number of bytes, also if it failed."""
        view = memoryview(content).cast("B")
        if self._error is None:
            try:
                self._file.seek(self._at)
                done = 0
                while done < len(view):
                    done += self._file.write(view[done:])
            except BaseException as error:
                self._keep(error)
        if self._error is not None and len(view) <= SMALL:
            self._lost.append((self._at, bytes(view)))
        self._at += len(view)
        self._end = max(self._end, self._at)
        return len(view)

    def truncate(self, size: int | None = None) -> int:
        """Sets the length of the file; returns it."""
        self._end = self._at if size is None else size
        if self._error is None:
            try:
                self._file.truncate(self._end)
            except BaseException as error:
                self._keep(error)
        return self._end

    def close(self) -> None:
        """Closes the file."""
        try:
            self._file.close()
        except OSError as error:
            self._keep(error)
        super().close()

    def _keep(self, error: BaseException) -> None:
        if self._error is None:
            self._error = error


def _lock(file: io.FileIO) -> None:
    """Locks a file as HDF5 does, where the system can. Raises `OSError` if a program reads it."""
    try:
        import fcntl
    except ImportError:
        return
    try:
        fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except OSError:  # a file system without locks
        return
