# SPDX-License-Identifier: BSD-3-Clause
"""The checkpoint: arrays and plain data in one file, bit-exact and never incomplete."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from tilth.errors import BadInput
from tilth.input_files import require_plain_files
from tilth.output.disk import writing
from tilth.output.files import RESTORE, removed_on_failure, replace_durably, temporary

META = "meta.json"


def write_checkpoint(
    path: Path | str, arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any]
) -> None:
    """Writes named arrays and JSON data to ``path``, replacing an older checkpoint atomically.

    A kill at any moment leaves the old or the new one, complete. The file is a zip archive of
    ``.npy`` members (as NumPy's ``.npz``, uncompressed, with check sums) and ``meta.json``. Floats
    in ``meta`` are bit-exact. Object arrays are refused with ``ValueError``. Raises
    ``AnalysisFailed`` if it cannot be written; the old one remains.
    """
    path = Path(path)
    new = temporary(path)
    with writing(path), removed_on_failure(new):
        with zipfile.ZipFile(new, "w", zipfile.ZIP_STORED) as archive:
            archive.writestr(META, json.dumps(meta))
            for name, values in arrays.items():
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    npy.write_array(member, np.asarray(values), allow_pickle=False)
        replace_durably(new, path)


def read_checkpoint(path: Path | str) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Returns the arrays and the plain data of a checkpoint.

    The arrays are C-contiguous. Raises ``BadInput`` if there is none, or if it is damaged (its
    check sums are tested).
    """
    path = Path(path)
    require_plain_files([path])
    arrays: dict[str, NDArray[Any]] = {}
    try:
        with zipfile.ZipFile(path) as archive:
            meta = json.loads(archive.read(META))
            for name in archive.namelist():
                if name != META:
                    with archive.open(name) as member:
                        values = npy.read_array(member, allow_pickle=False)
                        if member.read(1):
                            raise ValueError(f"{name} is longer than its header states")
                        arrays[name.removesuffix(".npy")] = np.asarray(values, order="C")
    except FileNotFoundError:
        raise BadInput(
            f"{path} does not exist: there is nothing to resume", "run the case again"
        ) from None
    except Exception as error:  # the modules for zip archives and arrays raise all kinds
        raise BadInput(f"{path} is damaged ({error})", RESTORE) from error
    if not isinstance(meta, dict):
        raise BadInput(f"{path} is damaged ({META} is no table)", RESTORE)
    return arrays, meta
