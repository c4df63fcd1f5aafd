# SPDX-License-Identifier: BSD-3-Clause
"""The folder of a run, and the names of the files that tilth writes there."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from tilth.errors import BadInput, shown
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


FILES = (
    CHECKPOINT,
    RESULTS,
    HISTORY,
    BOUNDARIES,
    ENERGIES,
    SURFACE,
    CONTACT,
    REPORT,
    LOG,
    MODEL,
    SETUP,
    *safety_files(),
)
"""The files that tilth writes into the folder of a run; the first is removed first, so that what
is left when a removal is interrupted cannot be resumed."""

_NAMES = "|".join([*map(re.escape, FILES), STAGE_CHECKPOINT.pattern, _SAFETY_OF_STAGE.pattern])
_TEMPORARY = re.compile(rf"\.({_NAMES})\.(new|shadow|old|{WRITTEN_ASIDE}[0-9]+)")
"""Names of the files that exist only while one of them is written."""


def prepare_output_folder(
    path: Path | str, overwrite: bool, protect: Sequence[Path | str] = ()
) -> Path:
    """Creates the folder of a run, or removes an earlier run's files from it; returns it.

    Raises ``BadInput`` if it is not empty and ``overwrite`` is false, or if it cannot be created.
    With ``overwrite`` only tilth's own files are removed, by their exact names, and never those in
    ``protect`` (the case file of the new run).
    """
    protected = {Path(file).resolve() for file in protect}
    folder = make_folder(path)
    require_empty(folder, overwrite)
    patterns = (_TEMPORARY, STAGE_CHECKPOINT, _SAFETY_OF_STAGE)
    own = [f for f in folder.iterdir() if any(each.fullmatch(f.name) for each in patterns)]
    for file in [*(folder / name for name in FILES), *own]:
        if (file.is_file() or file.is_symlink()) and file.resolve() not in protected:
            file.unlink()
    return folder


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
        raise BadInput(f"{folder} is a file, not a folder", other) from None
    except OSError as error:
        problem = f"the output folder {folder} cannot be made: {error.strerror}"
        raise BadInput(problem, other) from error
    return folder


def require_folder(path: Path | str) -> Path:
    """Returns the folder of an earlier run; raises ``BadInput`` if there is none at ``path``."""
    folder = Path(path)
    if not folder.is_dir():
        problem = "is a file, not a folder" if folder.exists() else "there is no such folder"
        raise BadInput(problem, "name the folder of a tilth run", file=folder)
    return folder


def read_declared(folder: Path | str) -> dict[str, Any]:
    """Returns the declared model of a run, as nested mappings and lists, from its folder.

    Raises ``BadInput`` if the folder is not that of a run, or the file is damaged.
    """
    file = Path(folder) / MODEL
    try:
        entries = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise BadInput(f"{file} cannot be read: {error}", "name the folder of a tilth run") from (
            error
        )
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
