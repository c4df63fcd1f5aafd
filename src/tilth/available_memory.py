# SPDX-License-Identifier: BSD-3-Clause
"""Memory that a process may use: that of the machine, of its control group, and its own limits."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tilth.environment import available_cores
from tilth.errors import BadInput

UNITS = {
    "B": 1,
    **{f"{prefix}B": 1000**i for i, prefix in enumerate("KMGTP", 1)},
    **{f"{prefix}iB": 1024**i for i, prefix in enumerate("KMGTP", 1)},
}
"""Bytes of each unit of a size."""

PROGRAM = 95e6
"""Memory of interpreter and libraries in use [byte]; measured."""

RESERVED = {"RLIMIT_AS": 200e6, "RLIMIT_DATA": 90e6}
"""Addresses that a small run on one thread reserves beyond the memory in use [byte]; measured."""

RESERVED_PER_THREAD = 80e6
"""Further addresses for each thread of the linear algebra libraries [byte]; measured."""

UNLIMITED = 2**60
"""A limit of so many bytes or more is none."""


@dataclass(frozen=True)
class AvailableMemory:
    """Memory that this process may use, including what it uses already.

    Attributes:
        available: [byte].
        total: the machine's memory, or the limit [byte].
        source: what limits it.
    """

    available: float
    total: float
    source: str

    def __str__(self) -> str:
        whole = "in all" if self.source == "memory of the machine" else "allowed"
        left = size_text(max(self.available, 0.0))
        return f"{left} ({self.source}, {size_text(self.total)} {whole})"


def available_memory(root: Path = Path("/")) -> AvailableMemory | None:
    """Returns the tightest bound of the memory that this process may use; None if none is known.

    Swap space does not count. `root`: where the system's files are.
    """
    bounds = [*_of_machine(root), *_of_control_groups(root), *limits_of_process(root)]
    return min(bounds, key=lambda bound: bound.available, default=None)


def require_memory_of_program() -> None:
    """Refuses to start under a limit of the process that is too low for the libraries alone.

    Some of them end the program without a message where they cannot allocate memory.

    Raises:
        BadInput: it names the limit.
    """
    for limit in limits_of_process():
        if limit.available < PROGRAM:
            needed = limit.total - limit.available + PROGRAM
            raise BadInput(
                f"the {limit.source} is {size_text(limit.total)}, but tilth and its libraries "
                f"alone need about {size_text(needed)} of memory",
                "raise the limit, or set OPENBLAS_NUM_THREADS=1: each thread reserves addresses",
            )


def parse_size(text: str | float, key: str = "memory_limit") -> float:
    """Returns the bytes of a size such as "64GB", "500MiB" or a plain number of bytes.

    Raises:
        BadInput: it is not a size above zero; `key` names the entry.
    """
    found = re.fullmatch(r"\s*([0-9]+\.?[0-9]*|\.[0-9]+)\s*([a-z]*)\s*", str(text), re.IGNORECASE)
    units = {name.lower(): size for name, size in UNITS.items()}
    units |= {name[0].lower(): size for name, size in UNITS.items() if len(name) == 2}
    size = 0.0
    if found is not None:
        size = float(found.group(1)) * units.get(found.group(2).lower() or "b", 0)
    if size > 0.0:
        return size
    raise BadInput(
        "is not a size of memory", 'give a number with its unit, such as "64GB" or "500MiB"',
        key=key, value=text,
    )  # fmt: skip


def size_text(size: float) -> str:
    """Returns a size [byte] with the decimal unit that suits it, such as "3.2 GB"."""
    for unit in ("PB", "TB", "GB"):
        if size >= UNITS[unit]:
            return f"{size / UNITS[unit]:.3g} {unit}"
    return f"{size / UNITS['MB']:.0f} MB"


def _of_machine(root: Path) -> Iterator[AvailableMemory]:
    entries = _table(root / "proc/meminfo", factor=1024)
    total, free = entries.get("MemTotal"), entries.get("MemAvailable")
    if total is None and "SC_PHYS_PAGES" in os.sysconf_names:
        total = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if total is not None:
        used = _own(root, "VmRSS")
        available = total if free is None else min(free + used, total)
        yield AvailableMemory(available, total, "memory of the machine")


def _of_control_groups(root: Path) -> Iterator[AvailableMemory]:
    """Limits of the control groups (cgroups, versions 1 and 2) that the process belongs to.

    Each group from its own to the topmost can have a limit. In a container the path of the group
    may be that outside; the topmost group is then the container's.
    """
    for line in _lines(root / "proc/self/cgroup"):
        number, controllers, path = ([*line.split(":", 2), "", ""])[:3]
        if number == "0" and not controllers:
            mount, limit, usage = "sys/fs/cgroup", "memory.max", "memory.current"
            cached = "inactive_file"
        elif "memory" in controllers.split(","):
            mount, limit, usage = (
                "sys/fs/cgroup/memory",
                "memory.limit_in_bytes",
                "memory.usage_in_bytes",
            )
            cached = "total_inactive_file"
        else:
            continue
        top = root / mount
        own = top / path.strip("/")
        for group in [own, *own.parents]:
            most, used = _number(group / limit), _number(group / usage)
            if most is not None and used is not None and most < UNLIMITED:
                released = _table(group / "memory.stat").get(cached, 0.0)
                free = most - max(used - released, 0.0) + _own(root, "VmRSS")
                yield AvailableMemory(
                    max(min(free, most), 0.0), most, "limit of the container or control group"
                )
            if group == top:
                break


def limits_of_process(root: Path = Path("/")) -> Iterator[AvailableMemory]:
    """Yields the limits set on the process itself, by `ulimit` or by the queue of a cluster.

    The limits count addresses, not memory in use: what is reserved but not used is lost. The
    libraries that are loaded during a run, and their threads, reserve more.
    """
    try:
        import resource
    except ModuleNotFoundError:  # not on this system
        return
    threads = os.environ.get("OPENBLAS_NUM_THREADS", "")
    of_threads = RESERVED_PER_THREAD * (
        (int(threads) if threads.isdigit() else available_cores()) - 1
    )
    for name, command, used in (
        ("RLIMIT_AS", "ulimit -v", "VmSize"),
        ("RLIMIT_DATA", "ulimit -d", "VmData"),
    ):
        most, _ = resource.getrlimit(getattr(resource, name))
        if most == resource.RLIM_INFINITY or most >= UNLIMITED:
            continue
        unused = max(_own(root, used) - _own(root, "VmRSS"), RESERVED[name] + of_threads)
        source = f"limit {name} of the process (`{command}`)"
        yield AvailableMemory(most - unused, most, source)


def _own(root: Path, name: str) -> float:
    """Returns an entry of the process's own list [byte], 0 if there is none."""
    return _table(root / "proc/self/status", factor=1024).get(name, 0.0)


def _table(file: Path, factor: int = 1) -> dict[str, float]:
    """Returns the numbers of a file with a name and a number on each line."""
    found = {}
    for line in _lines(file):
        words = line.replace(":", " ").split()
        if len(words) >= 2 and words[1].isdigit():
            found[words[0]] = float(words[1]) * factor
    return found


def _number(file: Path) -> float | None:
    """Returns the number in a file; None if there is no such file, or no number in it."""
    words = _lines(file)
    return float(words[0]) if words and words[0].strip().isdigit() else None


def _lines(file: Path) -> list[str]:
    try:
        return file.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return []
