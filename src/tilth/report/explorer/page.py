# SPDX-License-Identifier: BSD-3-Clause
"""HTML of the interactive part: its places in the page, its data and its scripts."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.output.folder import BOUNDARIES, ENERGIES
from tilth.output.history import read_history
from tilth.output.vtkhdf import Results
from tilth.report.colour_scale import ColourScale
from tilth.report.explorer.body import pack_body
from tilth.report.explorer.boundaries import boundaries_at
from tilth.report.explorer.curves import LARGEST_CURVES, pack_curves
from tilth.report.explorer.packing import Blobs
from tilth.report.motion_plots import motion_curves
from tilth.report.setup_data import Setup
from tilth.report.stage_marks import Span, stage_of
from tilth.report.stage_setups import StagedSetup

LARGEST_PAGE = 15_000_000
"""Size of a page, at most [bytes]."""
_MARGIN = 200_000
LARGEST_FRAME = LARGEST_CURVES + 1_000_000
"""Size of the interactive part without the body at all outputs, at most [bytes]."""
STYLES = ("vendor/uPlot.min.css", "explorer.css")
SCRIPTS = (
    "vendor/three.min.js",
    "vendor/uPlot.iife.min.js",
    "data.js",
    "shaders.js",
    "soil.js",
    "field.js",
    "triad.js",
    "scene.js",
    "curves.js",
    "body.js",
)


def explorer_parts(
    folder: Path,
    results: Results,
    history: Mapping[str, Floats],
    summary: Mapping[str, Any],
    colour_by: str,
    setup: Setup | StagedSetup | None,
    stages: Sequence[Span],
    room: int,
) -> tuple[str, str]:
    """Returns the sections of the page, and what follows at its end: data and scripts.

    ``room`` is the size that the rest of the page leaves [bytes].
    """
    scripts = "".join(f"<script>\n{_source(name)}\n</script>\n" for name in SCRIPTS)
    curve_blobs = Blobs()
    tables = [history]
    tables += [read_history(folder / n) for n in (BOUNDARIES, ENERGIES) if (folder / n).exists()]
    moving = tables[1] if (folder / BOUNDARIES).exists() else {}
    curves = motion_curves(moving, summary) if moving else []
    unit = results.units.get("time", "")
    curve_data = pack_curves(tables, curves, stages, unit, curve_blobs)
    time_of = dict(zip(results.steps, results.times, strict=True))
    kind = str(summary.get("analysis", {}).get("kind", ""))
    fixed = len(scripts.encode()) + curve_blobs.size + _MARGIN
    packed = pack_body(
        results,
        colour_by,
        room - fixed,
        axis_names=("r" if kind == "axisymmetric" else "x", "y", "z"),
        stage_at=lambda time: stage_of(stages, time)[0] if stages else "",
        boundaries=lambda step: boundaries_at(setup, moving, step, time_of[step]),
    )
    body, blobs = packed or (None, Blobs())
    content = {"curves": curve_data, "body": body, "maps": {n: _map(n) for n in _MAPS}}
    text = json.dumps(content, separators=(",", ":"), default=float).replace("<", "\\u003c")
    data = curve_blobs.elements("curves") + blobs.elements("body")
    end = f'<script type="application/json" id="tilth-data">{text}</script>\n{data}{scripts}'
    sections = str(_source("sections.html"))
    return sections if packed else sections + f"<p>{_NO_ROOM}</p>\n", end


_NO_ROOM = f"""The body at all outputs is not in this page: beside the rest it would be larger than
{LARGEST_PAGE / 1e6:.0f} MB. All of it is in results.vtkhdf."""


def styles() -> str:
    """Returns the style sheets of the interactive part."""
    return "\n".join(_source(name) for name in STYLES)


_MAPS = ("viridis", "coolwarm")


def _map(name: str) -> list[int]:
    """Returns 256 colours, red, green and blue of each in turn, 0 to 255."""
    colours = ColourScale(0.0, 1.0, name).colours(np.linspace(0.0, 1.0, 256))
    return [round(255.0 * value) for value in colours.ravel()]


def _source(name: str) -> str:
    """Returns a file of this folder; no script may end its element."""
    text = files(__package__).joinpath(name).read_text(encoding="utf-8")
    return text.replace("</script", "<\\/script") if name.endswith(".js") else text
