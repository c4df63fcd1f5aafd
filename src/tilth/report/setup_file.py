# SPDX-License-Identifier: BSD-3-Clause
"""``setup.npz``: what the picture of the set-up shows besides the first output of the results.

It is written at the start of a run, so that a report needs no computation, and does not run the
user's functions that the model may name.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tilth.output.checkpoint import read_checkpoint, write_checkpoint
from tilth.output.snapshot import Snapshot
from tilth.report.setup_data import Condition, Load, Setup, Surface

_PARTS: dict[str, type] = {"conditions": Condition, "surfaces": Surface, "loads": Load}
_IN_RESULTS = ("position", "half_lengths", "corners", "body_id", "tracked")
_IN_LOG = ("warnings",)


def write_setup(path: Path, setup: Setup) -> None:
    """Writes ``setup``, without its points and tracked surfaces, replacing any file at ``path``."""
    whole = {k: v for k, v in vars(setup).items() if k not in (*_PARTS, *_IN_RESULTS, *_IN_LOG)}
    arrays, meta = _split("setup", whole)
    for name in _PARTS:
        meta[name] = []
        for number, part in enumerate(getattr(setup, name)):
            own, plain = _split(f"{name}.{number}", vars(part))
            arrays |= own
            meta[name].append(plain)
    write_checkpoint(path, arrays, meta)


def read_setup(path: Path, initial: Snapshot) -> Setup:
    """Returns the set-up of a run; ``initial`` is the first output of its results.

    Raises ``BadInput`` if there is no file at ``path`` or it is damaged.
    """
    arrays, meta = read_checkpoint(path)
    parts: dict[str, Any] = {
        name: [
            cls(**_joined(f"{name}.{number}", arrays, plain))
            for number, plain in enumerate(meta.pop(name))
        ]
        for name, cls in _PARTS.items()
    }
    return Setup(
        **_joined("setup", arrays, meta),
        **parts,
        position=initial.position,
        half_lengths=initial.point_fields["domain"],
        corners=initial.point_fields.get("domain_corners"),
        body_id=initial.body_id,
        tracked=initial.surfaces,
    )


def _split(prefix: str, entries: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns the arrays among ``entries``, their names with the prefix, and the plain data."""
    arrays = {f"{prefix}.{k}": v for k, v in entries.items() if isinstance(v, np.ndarray)}
    return arrays, {k: v for k, v in entries.items() if f"{prefix}.{k}" not in arrays}


def _joined(prefix: str, arrays: dict[str, Any], plain: dict[str, Any]) -> dict[str, Any]:
    """Returns the inverse of :func:`_split`."""
    start = f"{prefix}."
    own = {k.removeprefix(start): v for k, v in arrays.items() if k.startswith(start)}
    return plain | own
