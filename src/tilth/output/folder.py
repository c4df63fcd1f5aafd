# SPDX-License-Identifier: BSD-3-Clause
"""The folder of a run, and the names of the files that tilth writes there."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tilth.errors import BadInput
from tilth.model import Model

RESULTS = "results.vtkhdf"
HISTORY = "history.csv"
SURFACE = "surface.csv"
REPORT = "report.html"
LOG = "log.txt"
CHECKPOINT = "checkpoint.npz"
MODEL = "model.json"
SETUP = "setup.npz"

OWN_FILES = (
    RESULTS,
    f".{Path(RESULTS).stem}.shadow*",
    HISTORY,
    f".{HISTORY}.new",
    SURFACE,
    f".{SURFACE}.new",
    REPORT,
    LOG,
    "checkpoint*",
    MODEL,
    SETUP,
    f"{SETUP}.new",
)
"""Patterns of the files that tilth itself writes into the folder of a run."""


def prepare_output_folder(
    path: Path | str, overwrite: bool, protect: Sequence[Path | str] = ()
) -> Path:
    """Creates the folder of a run, or removes an earlier run's files from it; returns it.

    Raises ``BadInput`` if it is not empty and ``overwrite`` is false, or if it cannot be created.
    With ``overwrite`` only tilth's own files are removed, and never those in ``protect`` (the case
    file of the new run).
    """
    protected = {Path(file).resolve() for file in protect}
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise BadInput(f"{folder} is a file, not a folder", "choose another with --out") from None
    except OSError as error:
        raise BadInput(
            f"the output folder {folder} cannot be made: {error.strerror}",
            "choose another with --out",
        ) from error
    if not overwrite and any(folder.iterdir()):
        raise BadInput(
            f"the output folder {folder} is not empty",
            "use --overwrite to replace an earlier run, or choose another with --out",
        )
    for pattern in OWN_FILES:
        for file in folder.glob(pattern):
            if (file.is_file() or file.is_symlink()) and file.resolve() not in protected:
                file.unlink()
    return folder


def read_declared(folder: Path | str) -> dict[str, Any]:
    """Returns the declared model of a run, as nested mappings and lists, from its folder.

    Raises ``BadInput`` if the folder is not that of a run.
    """
    file = Path(folder) / MODEL
    try:
        return dict(json.loads(file.read_text(encoding="utf-8")))
    except (OSError, ValueError) as error:
        raise BadInput(f"{file} cannot be read: {error}", "name the folder of a tilth run") from (
            error
        )


def load_model(folder: Path) -> Model:
    """Returns the model of the run in `folder`.

    Raises:
        BadInput: `folder` is not that of a run.
    """
    return Model.from_dict(read_declared(folder))
