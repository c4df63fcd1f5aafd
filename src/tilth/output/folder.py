# SPDX-License-Identifier: BSD-3-Clause
"""The folder of a run, and the names of the files that tilth writes there."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from tilth.errors import BadInput, shown
from tilth.input_files import absolute, require_plain_files, why_failed, why_no_folder
from tilth.model import Model
from tilth.output.files import RESTORE, WRITTEN_ASIDE
from tilth.output.lock import LOCK

RESULTS = "results.vtkhdf"
HISTORY = "history.csv"
BOUNDARIES = "boundaries.csv"
ENERGIES = "energies.csv"
SURFACE = "surface.csv"
CONTACT = "contact.csv"
REPORT = "report.html"
LOG = "log.txt"
CHECKPOINT = "checkpoint.npz"
MODEL = "model.json"
SETUP = "setup.npz"


class ExplanationFiles(NamedTuple):
    """Names of the files of an explained step."""

    whole: str
    table: str
    picture: str


def explanation_files(step: int) -> ExplanationFiles:
    """Returns the names of the files that explain a step, by its number."""
    return ExplanationFiles(*(f"explain_{step}.{ending}" for ending in ("json", "csv", "png")))


_EXPLANATION = re.compile(r"explain_[0-9]+\.(json|csv|png)")


class SafetyFiles(NamedTuple):
    """Names of the files of a strength reduction; the summary tells that there are the others."""

    summary: str
    table: str
    mechanism: str
    picture: str


def safety_files(index: int | None = None) -> SafetyFiles:
    """Returns the names of the files of a strength reduction.

    ``index`` is that of its stage among all stages, from 0; None without one, at the end of a run.
    """
    stem = "safety" if index is None else f"safety_stage_{index + 1:02d}"
    return SafetyFiles(*(f"{stem}.{ending}" for ending in ("json", "csv", "vtkhdf", "png")))


_SAFETY_OF_STAGE = re.compile(r"safety_stage_[0-9]{2,}\.(json|csv|vtkhdf|png)")


STAGE_CHECKPOINT = re.compile(r"checkpoint_stage_[0-9]{2,}\.npz")
"""Names of the checkpoints at the ends of stages."""


def stage_checkpoint(index: int) -> str:
    """Returns the name of the checkpoint at the end of a stage, see ``safety_files``."""
    return f"checkpoint_stage_{index + 1:02d}.npz"


ONLY_OF_RUNS = (CHECKPOINT, SETUP, RESULTS)
"""Files whose names say that a run has written them; log.txt or report.html can be anybody's."""


FILES = (
    CHECKPOINT,
    HISTORY,
    BOUNDARIES,
    ENERGIES,
    SURFACE,
    CONTACT,
    REPORT,
    LOG,
    *safety_files(),
    MODEL,
    SETUP,
    RESULTS,
)
"""The files that tilth writes into the folder of a run; the first is removed first, so that what
is left when a removal is interrupted cannot be resumed, and is known as that of a run."""

_PATTERNS = (STAGE_CHECKPOINT, _SAFETY_OF_STAGE, _EXPLANATION)
_NAMES = "|".join([*map(re.escape, FILES), *(each.pattern for each in _PATTERNS)])
_OF_RUN = re.compile(rf"\..*|{STAGE_CHECKPOINT.pattern}|{_SAFETY_OF_STAGE.pattern}")
_TEMPORARY = re.compile(rf"\.({_NAMES})\.(new|shadow|old|{WRITTEN_ASIDE}[0-9]+)")
"""Names of the files that exist only while one of them is written."""


def prepare_output_folder(
    path: Path | str, overwrite: bool, protect: Sequence[Path | str] = ()
) -> Path:
    """Creates the folder of a run, or removes an earlier run's files from it; returns it.

    With ``overwrite`` only tilth's own files are removed, by their exact names, and never those in
    ``protect`` (the case file of the new run).

    Raises:
        BadInput: it is not empty and ``overwrite`` is false, it cannot be created, or it has files
            of such names but is not the folder of a run.
    """
    protected = {absolute(file) for file in protect}
    folder = make_folder(path)
    require_empty(folder, overwrite)
    require_own_files(folder)
    own = [folder / name for name in _own_files(folder)]
    own = [file for file in own if absolute(file) not in protected]
    if own and not _is_run(folder):
        raise BadInput(
            f"the folder {folder} has a file {own[0].name}, but is not that of a run",
            "nothing is replaced there: choose another folder with --out (in Python out), or move "
            "what is in it away",
        )
    for file in own:
        file.unlink()
    return folder


def remove_run(folder: Path) -> None:
    """Removes the files of a run from its folder, and the folder if nothing else is in it."""
    for name in (*_own_files(folder), LOCK):
        (folder / name).unlink(missing_ok=True)
    with suppress(OSError):  # it has other files
        folder.rmdir()


def _own_files(folder: Path) -> list[str]:
    """Returns the names of tilth's files in a folder, in the order in which to remove them."""
    patterns = (_TEMPORARY, *_PATTERNS)

    def is_own(name: str) -> bool:
        return name in FILES or any(each.fullmatch(name) for each in patterns)

    def order(name: str) -> int:
        return FILES.index(name) if name in FILES else 1

    return sorted(filter(is_own, os.listdir(folder)), key=order)


def _is_run(folder: Path) -> bool:
    """Returns whether a folder has a file that no other program writes."""
    names = _own_files(folder)
    if any(name in ONLY_OF_RUNS or _OF_RUN.fullmatch(name) for name in names):
        return True
    try:
        entries = json.loads((folder / MODEL).read_text(encoding="utf-8"))
        return "format" in entries and "bodies" in entries
    except (OSError, ValueError, TypeError, RecursionError):
        return False


def require_own_files(folder: Path) -> None:
    """Passes if what has the name of a file of a run is a file: who opens a pipe waits.

    Raises:
        BadInput: it is something else.
    """
    require_plain_files(folder / name for name in _own_files(folder))


def require_empty(folder: Path, overwrite: bool) -> None:
    """Raises ``BadInput`` if the folder is not empty and ``overwrite`` is false."""
    if not overwrite and any(file.name != LOCK for file in folder.iterdir()):
        raise BadInput(
            f"the output folder {folder} is not empty",
            "to replace an earlier run use --overwrite (in Python overwrite=True), or choose "
            "another folder with --out (in Python out)",
        )


def make_folder(path: Path | str) -> Path:
    """Creates the folder of a run unless it exists; returns it.

    Raises ``BadInput`` if it cannot be created.
    """
    folder = Path(path)
    other = "choose another with --out (in Python out)"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        reason = why_no_folder(folder)
        raise BadInput(f"{folder} cannot be the output folder: {reason}", other) from None
    except OSError as error:
        problem = f"the output folder {folder} cannot be made: {error.strerror}"
        raise BadInput(problem, other) from error
    return folder


def require_folder(path: Path | str) -> Path:
    """Returns the folder of an earlier run.

    Raises:
        BadInput: there is none at ``path``, or as ``require_own_files``.
    """
    folder = Path(path)
    if problem := why_no_folder(folder):
        raise BadInput(problem, "name the folder of a tilth run", file=folder)
    require_own_files(folder)
    return folder


def read_declared(folder: Path | str) -> dict[str, Any]:
    """Returns the declared model of a run, as nested mappings and lists, from its folder.

    Raises ``BadInput`` if the folder is not that of a run, or the file is damaged, and as
    ``require_own_files``.
    """
    file = Path(folder) / MODEL
    if Path(folder).is_dir():
        require_own_files(Path(folder))
    try:
        entries = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise BadInput(
            f"{file} cannot be read: {why_failed(error)}", "name the folder of a tilth run"
        ) from (error)
    if not isinstance(entries, dict):
        raise BadInput(
            f"{file} is no model but {shown(entries)}",
            "name the folder of a tilth run, or restore the file from a copy",
        )
    return entries


def load_model(folder: Path) -> Model:
    """Returns the model of the run in `folder`.

    Raises:
        BadInput: `folder` is not that of a run, or its model cannot be computed.
    """
    entries, file = read_declared(folder), folder / MODEL
    try:
        return Model.from_dict(entries)
    except BadInput as error:
        problems = [replace(each, remedy=each.remedy or RESTORE) for each in error.problems]
        raise BadInput.of(problems, file) from None
    except RecursionError:
        raise BadInput(f"{file} is nested too deeply to be a model", RESTORE) from None
