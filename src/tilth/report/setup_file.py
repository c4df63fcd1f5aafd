# SPDX-License-Identifier: BSD-3-Clause
"""``setup.npz``: what the picture of the set-up shows besides the first output of the results.

Of an analysis with stages it also has the undeformed soil of all stages, and what acts in each.
It is written at the start of a run, so that a report needs no computation, and does not run the
user's functions that the model may name.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tilth.output.checkpoint import read_checkpoint, write_checkpoint
from tilth.output.snapshot import Snapshot, SurfaceShape
from tilth.report.setup_data import Condition, Load, Setup, Soil, Surface
from tilth.report.stage_setups import StagedSetup, StageSetup

_PARTS: dict[str, type] = {"conditions": Condition, "surfaces": Surface, "loads": Load}
_IN_RESULTS = ("position", "half_lengths", "corners", "body_id", "tracked")
_IN_LOG = ("warnings",)
_OF_FIGURES = ("is_new", "removed")
_LEFT_OUT = (*_PARTS, *_IN_RESULTS, *_IN_LOG, *_OF_FIGURES)
_STAGES = "stages"
_BEFORE = "present in the initial state"
_FACTS = ("name", "number", "start", "end", "changes")


def write_setup(path: Path, setup: Setup | StagedSetup) -> None:
    """Writes a set-up, replacing any file at ``path``.

    That of an analysis without stages is written without its points and tracked surfaces.
    """
    if isinstance(setup, Setup):
        arrays, meta = _plain(setup, "")
    else:
        arrays, meta = _plain(setup.stages[0].setup, "")
        own, meta[_STAGES] = _of_stages(setup)
        arrays |= own
    write_checkpoint(path, arrays, meta)


def read_setup(path: Path, initial: Snapshot) -> Setup:
    """Returns the set-up of a run; ``initial`` is the first output of its results.

    Raises ``BadInput`` if there is no file at ``path`` or it is damaged.
    """
    arrays, meta = read_checkpoint(path)
    meta.pop(_STAGES, None)
    soil = Soil(
        position=initial.position,
        half_lengths=initial.point_fields["domain"],
        corners=initial.point_fields.get("domain_corners"),
        body_id=initial.body_id,
    )
    return _setup("", arrays, meta, soil, tracked=initial.surfaces)


def read_staged_setup(path: Path) -> StagedSetup | None:
    """Returns the set-up of a run with stages; None if there is none in the file.

    Raises ``BadInput`` if there is no file at ``path`` or it is damaged.
    """
    arrays, meta = read_checkpoint(path)
    if (declared := meta.get(_STAGES)) is None:
        return None
    own = _joined("soil", arrays, {})
    soil = Soil(**{"corners": None, **own})
    nothing = soil.selected(np.zeros(len(soil.position), dtype=bool))
    surfaces = []
    for number, name in enumerate(declared["surfaces"]):
        parts = _joined(f"tracked.{number}", arrays, {})
        fields = _joined("fields", parts, {})
        surfaces.append(SurfaceShape(name, parts["position"], parts["cells"], fields))
    stages = []
    for number, entry in enumerate(declared["entries"]):
        prefix = f"stage.{number}."
        setup = _setup(prefix, arrays, entry.pop("setup"), nothing)
        present = np.unpackbits(arrays[f"{prefix}present"], count=len(soil.position)).astype(bool)
        stages.append(StageSetup(**entry, present=present, setup=setup))
    before = arrays.get(_BEFORE)
    if before is not None:
        before = np.unpackbits(before, count=len(soil.position)).astype(bool)
    return StagedSetup(soil, surfaces, stages, before)


def _plain(setup: Setup, prefix: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns the arrays of a set-up, their names with the prefix, and the plain data."""
    whole = {k: v for k, v in vars(setup).items() if k not in _LEFT_OUT}
    arrays, meta = _split(f"{prefix}setup", whole)
    for name in _PARTS:
        meta[name] = []
        for number, part in enumerate(getattr(setup, name)):
            own, plain = _split(f"{prefix}{name}.{number}", vars(part))
            arrays |= own
            meta[name].append(plain)
    return arrays, meta


def _setup(
    prefix: str, arrays: dict[str, Any], meta: dict[str, Any], soil: Soil, **more: Any
) -> Setup:
    """Returns the inverse of :func:`_plain`, with soil."""
    parts: dict[str, Any] = {
        name: [
            cls(**_joined(f"{prefix}{name}.{number}", arrays, plain))
            for number, plain in enumerate(meta.pop(name))
        ]
        for name, cls in _PARTS.items()
    }
    return Setup(**_joined(f"{prefix}setup", arrays, meta), **parts, **vars(soil), **more)


def _of_stages(staged: StagedSetup) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns the arrays of all stages, of their soil and its surfaces, and the plain data."""
    arrays, _ = _split("soil", vars(staged.soil))
    for number, shape in enumerate(staged.surfaces):
        prefix = f"tracked.{number}"
        arrays |= {f"{prefix}.position": shape.position, f"{prefix}.cells": shape.cells}
        arrays |= {f"{prefix}.fields.{name}": values for name, values in shape.fields.items()}
    entries = []
    for number, stage in enumerate(staged.stages):
        own, plain = _plain(stage.setup, f"stage.{number}.")
        arrays |= own | {f"stage.{number}.present": np.packbits(stage.present)}
        facts = {name: getattr(stage, name) for name in _FACTS}
        entries.append({**facts, "setup": plain})
    if staged.before is not None:
        arrays[_BEFORE] = np.packbits(staged.before)
    return arrays, {"surfaces": [shape.name for shape in staged.surfaces], "entries": entries}


def _split(prefix: str, entries: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns the arrays among ``entries``, their names with the prefix, and the plain data."""
    arrays = {f"{prefix}.{k}": v for k, v in entries.items() if isinstance(v, np.ndarray)}
    return arrays, {k: v for k, v in entries.items() if f"{prefix}.{k}" not in arrays}


def _joined(prefix: str, arrays: dict[str, Any], plain: dict[str, Any]) -> dict[str, Any]:
    """Returns the inverse of :func:`_split`."""
    start = f"{prefix}."
    own = {k.removeprefix(start): v for k, v in arrays.items() if k.startswith(start)}
    return plain | own
