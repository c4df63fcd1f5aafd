# SPDX-License-Identifier: BSD-3-Clause
"""A new folder of exported files: all of them are written, or none is left."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from tilth.errors import BadInput
from tilth.output.disk import writing
from tilth.output.folder import make_folder


class NewFolder:
    """The folder of an export, and the files in it so far."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.files: list[Path] = []
        """The files that were begun, in order."""
        self._folders: list[Path] = []

    @contextmanager
    def file(self, name: str) -> Iterator[Path]:
        """Gives the path of a new file to write within this context; folders are made for it.

        Raises ``AnalysisFailed`` if it cannot be written.
        """
        path = self.path / name
        with writing(path, "make room on the disk or choose another folder with --out"):
            if not path.parent.exists():
                path.parent.mkdir()
                self._folders.append(path.parent)
            self.files.append(path)
            yield path

    def remove(self) -> None:
        """Removes what was written, and so frees its space."""
        for path in self.files:
            with suppress(OSError):
                path.unlink(missing_ok=True)
        for path in self._folders:
            with suppress(OSError):
                path.rmdir()


@contextmanager
def new_folder(path: Path) -> Iterator[NewFolder]:
    """Makes the folder of an export; if the export fails, its files are removed, and the folder.

    Raises ``BadInput`` if there is a folder at ``path`` that is not empty, or if none can be made.
    """
    existed = path.exists()
    folder = NewFolder(make_folder(path))
    try:
        if existed and any(path.iterdir()):
            remedy = "choose another with --out (in Python out), or remove what is in it"
            raise BadInput(f"the folder {path} is not empty", remedy)
        yield folder
    except BaseException:
        folder.remove()
        if not existed:
            with suppress(OSError):
                path.rmdir()
        raise


class FileNames:
    """A file name, without ending, for each body and surface, different from all others."""

    def __init__(self, reserved: Sequence[str] = ()) -> None:
        """``reserved`` has names of other files."""
        self._found: dict[tuple[str, str], str] = {}
        self._reserved = {name.lower() for name in reserved}

    def of(self, family: str, name: str) -> str:
        """Returns the name for a body or surface; always the same one.

        Characters other than letters, digits, ``_``, ``-`` and ``.`` become underscores, and a
        number is appended where that, or the case of letters, is all that two names differ in.
        """
        if (family, name) not in self._found:
            safe = re.sub(r"[^A-Za-z0-9_.-]", "_", f"{family}{name}").lstrip(".") or "_"
            taken = self._reserved | {each.lower() for each in self._found.values()}
            each, count = safe, 1
            while each.lower() in taken:
                count += 1
                each = f"{safe}_{count}"
            self._found[family, name] = each
        return self._found[family, name]
