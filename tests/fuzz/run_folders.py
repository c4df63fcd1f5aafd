# SPDX-License-Identifier: BSD-3-Clause
"""Damaged folders of finished and interrupted runs: `tilth resume` and `tilth report` of them."""

from __future__ import annotations

import io
import json
import shutil
import zipfile
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from implicit_problems import implicit, line
from resumed_runs import datasets, entries_of
from small_problems import BASES, plane

from fuzz.mutations import Tree, changed_bytes
from fuzz.sandbox import Job
from fuzz.special_files import no_file

SECONDS = 30.0
STOP = 0.5
"""Time at which the interrupted runs stop; the schedules end at 1."""
OTHER_NUMBERS = ("model.json", "checkpoint.npz: meta.json")
"""Where a changed number that is right by itself gives another, complete analysis."""
EXTREMES = (float("nan"), float("inf"), -1, 0, 1e308, 2**40, 3.5, None, "x", [], {}, True)


def _problems() -> dict[str, Tree]:
    """Small runs of all bases and kinds of analysis, with an implicit boundary, with a surface."""
    found = {basis: entries_of("plane_strain", basis) for basis in BASES}
    found["axisymmetric"] = entries_of("axisymmetric")
    found["3d"] = entries_of("3d", "linear")
    found["implicit"] = entries_of()
    wall = implicit("wall", line([0, 0.05], [0, 1]), condition="fixed")
    top = found["implicit"]["boundaries"][-1]
    found["implicit"]["boundaries"] = [wall, plane("side", "x", 0.0), top]
    found["surface"] = entries_of()
    found["surface"]["bodies"][0]["surface"] = {}
    found["surface"]["loads"].append({"type": "surface", "body": "block", "pressure": 1.0})
    return found


def make_runs(folder: Path) -> None:
    """Computes each small run as a whole, and up to the middle of its schedule."""
    from tilth import Model, run

    for name, entries in _problems().items():
        model = Model.from_dict(entries)
        run(model, folder / name / "whole", threads=1, quiet=True)
        run(model, folder / name / "part", threads=1, quiet=True, until=STOP)


def folder_jobs(seed: int, numbers: Iterable[int], runs: Path, work: Path) -> Iterator[Job]:
    """Yields `resume` or `report` of damaged copies of the small runs, one for each number."""
    for number in numbers:
        name = f"folder-{seed}-{number}"
        random = Random(name)
        problem = random.choice(sorted(path.name for path in runs.iterdir()))
        state = random.choice(("part", "part", "part", "whole"))
        out = work / name / "out"
        shutil.rmtree(out.parent, ignore_errors=True)
        shutil.copytree(runs / problem / state, out)
        damaged = _damage(out, random)
        command = random.choice(("resume", "resume", "resume", "report"))
        yield folder_job(name, out, command, damaged, runs / problem / "whole")


def folder_job(name: str, out: Path, command: str, damaged: str, whole: Path) -> Job:
    """Returns the job that resumes or reports a damaged run.

    damaged: the file that was damaged, and the array in it. whole: folder of the uninterrupted run.
    """
    before = _contents(out)
    quiet = ["--threads", "1", "--quiet"] if command == "resume" else []

    def inspect(code: int) -> list[str]:
        after = _contents(out)
        if command == "report" or code == 2:
            after.pop("report.html", None)
            changed = sorted(
                name for name in before | after
                if name != "report.html" and before.get(name) != after.get(name)
            )  # fmt: skip
            return [f"{command} with exit code {code} changes {name}" for name in changed]
        if code != 0 or damaged in OTHER_NUMBERS:
            return []
        return [f"resume {text}" for text in _differences(out, whole)]

    return Job(name, out.parent, [command, str(out), *quiet], SECONDS, inspect, damaged)


def _contents(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir() if file.is_file()}


def _differences(out: Path, whole: Path) -> list[str]:
    """How the results of a resumed run differ from those of the uninterrupted one."""
    found = []
    if (out / "history.csv").read_bytes() != (whole / "history.csv").read_bytes():
        found.append("gives another history.csv")
    results, expected = (datasets(folder / "results.vtkhdf") for folder in (out, whole))
    if results.keys() != expected.keys():
        found.append("gives other data sets in results.vtkhdf")
    elif any(results[name] != content for name, content in expected.items()):
        found.append("gives other values in results.vtkhdf")
    return found


def _damage(folder: Path, random: Random) -> str:
    """Damages one file of a run; returns its name, and that of the array in it."""
    name = random.choice((
        "results.vtkhdf", "history.csv", "checkpoint.npz", "checkpoint.npz", "checkpoint.npz",
        "model.json", "log.txt",
    ))  # fmt: skip
    file = folder / name
    kind = random.randrange(8)
    if kind == 0:
        file.unlink()
        if random.random() < 0.6:
            no_file(file, random)
    elif kind == 1:
        file.write_bytes(random.choice((b"", b"\n", b"3", b"[]", b"null", b"{}", b"[" * 100_000)))
    elif kind == 2:
        content = file.read_bytes()
        file.write_bytes(content[: random.randrange(len(content))])
    elif name == "checkpoint.npz" and kind < 7:
        return f"{name}: {_rewrite_checkpoint(file, random)}"
    elif name == "model.json" and kind < 6:
        _rewrite_model(file, random)
    elif name == "history.csv" and kind < 5:
        lines = file.read_bytes().splitlines(keepends=True)
        at = random.randrange(len(lines))
        lines[at : at + 1] = random.choice(([], lines[at : at + 1] * 2, [b"x,y\n"], [b"\n"]))
        file.write_bytes(b"".join(lines))
    else:
        file.write_bytes(changed_bytes(file.read_bytes(), random))
    return name


def _rewrite_model(file: Path, random: Random) -> None:
    tree = json.loads(file.read_text(encoding="utf-8"))
    table = tree
    while True:
        key = random.choice(list(table) if isinstance(table, dict) else range(len(table)))
        if isinstance(table[key], dict | list) and table[key] and random.random() < 0.8:
            table = table[key]
            continue
        break
    if random.random() < 0.3:
        del table[key]
    else:
        table[key] = random.choice(EXTREMES)
    file.write_text(json.dumps(tree), encoding="utf-8")


def _rewrite_checkpoint(file: Path, random: Random) -> str:
    """Writes the archive anew, its check sums right, with one member changed; returns its name."""
    with zipfile.ZipFile(file) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name = random.choice(sorted(members))
    if random.random() < 0.25:
        name = "meta.json"
    if random.random() < 0.1:
        del members[name]
    elif name == "meta.json":
        meta = json.loads(members[name])
        table = random.choice((meta, meta["clock"]))
        key = random.choice(list(table))
        if random.random() < 0.3:
            del table[key]
        else:
            table[key] = random.choice(EXTREMES)
        members[name] = json.dumps(meta).encode()
    else:
        members[name] = _npy(_other_array(np.load(io.BytesIO(members[name])), random))
    if random.random() < 0.05:
        members["more.npy"] = _npy(np.zeros(3))
    with zipfile.ZipFile(file, "w") as archive:
        for key, content in members.items():
            archive.writestr(key, content)
    return name


def _npy(array: Any) -> bytes:
    text = io.BytesIO()
    np.lib.format.write_array(text, array, allow_pickle=False)
    return text.getvalue()


def _other_array(array: Any, random: Random) -> Any:
    """Returns an array that no checkpoint should have, or the same one in another layout."""
    kind = random.randrange(9)
    if kind == 0:
        return np.asfortranarray(array)
    if kind == 1:
        return array.astype(random.choice(("f4", ">f8", "i4", "c16", "S8", "?")))
    if kind == 2:
        return array[:-1] if array.ndim else array
    if kind == 3:
        return array.reshape(-1)
    if kind == 4:
        return array[None]
    if kind == 5:
        return np.concatenate([array, array]) if array.ndim else array
    if kind == 6:
        return np.zeros((0,))
    other = array.copy()
    if other.size:
        extremes = (np.nan, np.inf) if array.dtype.kind == "f" else (-1, 2**31 - 1, 10**6)
        other.flat[random.randrange(other.size)] = random.choice(extremes)
    return other


@cache
def runs_in(folder: Path) -> Path:
    """Returns the folder of the small runs, computed once."""
    if not folder.exists():
        make_runs(folder)
    return folder
