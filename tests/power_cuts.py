# SPDX-License-Identifier: BSD-3-Clause
"""What a disk holds after a power cut: only what was synchronised, and perhaps some more.

`record` notes, in the process of a run, each call by which files become durable. `restore` makes
the folder that a disk could hold at one of those moments. Names are durable when the folder was
synchronised, contents when the file was. A journaling file system may have written more of both:
later names, and appended bytes up to any place.
"""

from __future__ import annotations

import hashlib
import json
import os
import stat
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

WAYS = ("only what was synchronised", "all names", "all names and parts of the contents")


class Recorder:
    """The state of the disk below one folder, written to `journal` after each change."""

    def __init__(self, folder: Path, journal: Path) -> None:
        self.folder, self.journal = folder, journal
        self.synchronised: dict[int, str] = {}
        self.durable: dict[str, int] = {}
        self.link = os.link
        self.lock = threading.Lock()
        (journal / "kept").mkdir(parents=True)

    def wrap(self, name: str) -> None:
        """Makes a function of `os` tell this object of each call, before and after it."""
        function = getattr(os, name)

        def synchronised(descriptor: int) -> None:
            with self.lock:
                self.note()
                known = self.present(descriptor)
            function(descriptor)  # beside the other thread, which may write to the same file
            with self.lock:
                self.durable = known.get("names", self.durable)
                self.synchronised |= known.get("contents", {})
                self.note()

        def renamed(*arguments: Any, **options: Any) -> Any:
            with self.lock:
                self.note()
                found = function(*arguments, **options)
                self.note()
            return found

        setattr(os, name, synchronised if name == "fsync" else renamed)

    def present(self, descriptor: int) -> dict[str, Any]:
        """What is there at the call that synchronises a file or the folder."""
        status = os.fstat(descriptor)
        if not stat.S_ISDIR(status.st_mode):
            content = (self.journal / "kept" / str(status.st_ino)).read_bytes()
            return {"contents": {status.st_ino: self.keep(content)}}
        if self.folder.exists() and status.st_ino == self.folder.stat().st_ino:
            return {"names": self.names()}
        return {}

    def names(self) -> dict[str, int]:
        """The names in the folder; a further link keeps each number from being used again."""
        found = {}
        for file in self.folder.iterdir():
            number = file.stat().st_ino
            found[file.name] = number
            if not (self.journal / "kept" / str(number)).exists():
                self.link(file, self.journal / "kept" / str(number))
        return found

    def keep(self, content: bytes) -> str:
        """Keeps a content in the journal; returns its name there."""
        name = hashlib.sha256(content).hexdigest()
        if not (self.journal / name).exists():
            (self.journal / name).write_bytes(content)
        return name

    def note(self) -> None:
        if not self.folder.exists():
            return
        names = self.names()
        present = {
            number: self.keep((self.journal / "kept" / str(number)).read_bytes())
            for number in names.values()
        }
        state = [self.durable, names, self.synchronised, present]
        with (self.journal / "states").open("a") as file:
            file.write(json.dumps(state) + "\n")


def record(folder: Path, journal: Path) -> None:
    """Begins to record the changes of `folder`, for the rest of this process."""
    recorder = Recorder(folder, journal)
    for name in ("fsync", "replace", "link", "unlink"):
        recorder.wrap(name)


def states(journal: Path) -> list[Any]:
    """The states of the disk, in order."""
    return [json.loads(line) for line in (journal / "states").read_text().splitlines()]


def restore(journal: Path, state: Any, way: str, random: np.random.Generator, folder: Path) -> None:
    """Makes the folder as a disk could hold it in that state, in one of the `WAYS`."""
    durable, names, synchronised, present = state
    folder.mkdir()
    read: Callable[[str], bytes] = lambda name: (journal / name).read_bytes()  # noqa: E731
    for name, number in (durable if way == WAYS[0] else names).items():
        safe = read(synchronised[str(number)]) if str(number) in synchronised else b""
        if way == WAYS[2] and str(number) in present:
            now = read(present[str(number)])
            if now.startswith(safe):
                safe = now[: int(random.integers(len(safe), len(now) + 1))]
            elif random.random() < 0.5:
                safe = now
        (folder / name).write_bytes(safe)
