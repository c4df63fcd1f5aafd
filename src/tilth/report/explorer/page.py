# SPDX-License-Identifier: BSD-3-Clause
"""The interactive part of a page: all curves, and the body at all outputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tilth.arrays import Floats
from tilth.output.folder import BOUNDARIES, ENERGIES
from tilth.output.history import read_history
from tilth.output.vtkhdf import Results
from tilth.report.blocks import Block, Paragraph, Section, Template
from tilth.report.explorer.body import pack_body
from tilth.report.explorer.boundaries import boundaries_at
from tilth.report.explorer.curves import pack_curves
from tilth.report.explorer.packing import Blobs
from tilth.report.figures import CHART_SCRIPTS, SCENE_SCRIPTS
from tilth.report.motion_plots import motion_curves
from tilth.report.setup_data import Setup
from tilth.report.stage_marks import Span, stage_of
from tilth.report.stage_setups import StagedSetup

LARGEST_PAGE = 15_000_000
"""Size of a page, at most [bytes]."""
_MARGIN = 200_000
SCRIPTS = (*CHART_SCRIPTS, *SCENE_SCRIPTS, "curves.js", "body.js", "start.js")


@dataclass(frozen=True)
class Explored:
    """The sections, and the data for the scripts of the page: ``curves`` and ``body``."""

    sections: Sequence[Section]
    data: Mapping[str, Any]
    elements: str
    """Those that hold the numbers of the body."""


def explore(
    folder: Path,
    results: Results,
    history: Mapping[str, Floats],
    summary: Mapping[str, Any],
    colour_by: str,
    setup: Setup | StagedSetup | None,
    stages: Sequence[Span],
    room: int,
    blobs: Blobs,
) -> Explored:
    """Returns the interactive part; the numbers of the curves are added to ``blobs``.

    ``room`` is the size that the rest of the page and its scripts leave [bytes].
    """
    tables = [history]
    tables += [read_history(folder / n) for n in (BOUNDARIES, ENERGIES) if (folder / n).exists()]
    moving = tables[1] if (folder / BOUNDARIES).exists() else {}
    curves = motion_curves(moving, summary) if moving else []
    before = blobs.size
    curve_data = pack_curves(tables, curves, stages, results.units.get("time", ""), blobs)
    time_of = dict(zip(results.steps, results.times, strict=True))
    kind = str(summary.get("analysis", {}).get("kind", ""))
    packed = pack_body(
        results,
        colour_by,
        room - (blobs.size - before) - _MARGIN,
        axis_names=("r" if kind == "axisymmetric" else "x", "y", "z"),
        stage_at=lambda time: stage_of(stages, time)[0] if stages else "",
        boundaries=lambda step: boundaries_at(setup, moving, step, time_of[step]),
    )
    body, own = packed or (None, Blobs())
    in_space: list[Block] = [Template("explore_body.html", {})] if packed else [Paragraph(_NO_ROOM)]
    heading, style = "The body at all outputs", "explorer" if packed else ""
    sections = [
        Section("Curves", [Template("explore_curves.html", {})], "explorer", "explore-curves"),
        Section(heading, in_space, style, "explore-body"),
    ]
    return Explored(sections, {"curves": curve_data, "body": body}, own.elements("body"))


_NO_ROOM = f"""The body at all outputs is not in this page: beside the rest it would be larger than
{LARGEST_PAGE / 1e6:.0f} MB. All of it is in results.vtkhdf."""
