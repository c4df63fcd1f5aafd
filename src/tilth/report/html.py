# SPDX-License-Identifier: BSD-3-Clause
"""``report.html``: one self-contained page with the model and the results of a run."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from tilth.errors import TilthError, visible
from tilth.input_files import absolute
from tilth.memory_errors import is_memory_error
from tilth.output.disk import writing
from tilth.output.files import WRITTEN_ASIDE, write_durably
from tilth.output.folder import HISTORY, LOG, REPORT, RESULTS, SETUP, read_declared
from tilth.output.history import read_history, read_stages
from tilth.output.log import read_log
from tilth.output.vtkhdf import read_results
from tilth.report import sections
from tilth.report.blocks import Block, Paragraph, Section, render
from tilth.report.explorer.page import LARGEST_PAGE, SCRIPTS, Explored, explore
from tilth.report.figures import Figures, source, styles
from tilth.report.relaxations import relaxation_table, relaxations
from tilth.report.sections import Run
from tilth.report.setup import Setup
from tilth.report.setup_file import read_setup, read_staged_setup
from tilth.report.stage_marks import stage_table
from tilth.report.stage_setups import StagedSetup
from tilth.report.style import CSS
from tilth.report.tables import model_tables


def write_report(
    folder: Path | str,
    summary: Mapping[str, Any] | None = None,
    *,
    setup: Setup | StagedSetup | None = None,
) -> Path:
    """Writes ``report.html`` into the folder of a run, finished or not; returns its path.

    ``summary`` is the declared model as nested mappings and lists, read from ``model.json`` of the
    folder if not given. The set-up is drawn from ``setup.npz`` of the folder, or else from
    ``setup``. No function of the user is run. Raises ``BadInput`` if the folder is not that of a
    run, ``AnalysisFailed`` if the report cannot be written.
    """
    if summary is None:
        summary = read_declared(folder)
    folder = Path(folder)
    results = read_results(folder / RESULTS)
    if (folder / SETUP).exists():
        staged = read_staged_setup(folder / SETUP)
        setup = staged or read_setup(folder / SETUP, results.snapshot(0))
    history = read_history(folder / HISTORY)
    run = Run(
        folder=folder,
        summary=summary,
        results=results,
        history=history,
        log=read_log(folder / LOG),
        stages=read_stages(folder / HISTORY) if summary.get("stages") else [],
        relaxed=relaxations(history),
        setup=setup,
    )
    title = results.title or visible(absolute(folder).name)
    figures = Figures()
    parts = _sections(run, figures)
    page: dict[str, Any] = {
        "title": title,
        "head": sections.header(run),
        "footer": f"tilth {run.log.facts.get('tilth', '')}",
    }
    text = _page(page, parts, figures, None)
    room = LARGEST_PAGE - len(text.encode())
    explored: Explored | None = None
    try:
        explored = explore(
            folder, results, history, summary, run.colour_by, setup, run.stages, room, figures.blobs
        )
    except MemoryError:
        raise
    except Exception as error:  # the page is of use without its interactive part
        page["head"] = [*page["head"], Paragraph(f"{_NOT_INTERACTIVE}: {error}")]
    else:
        parts = [*explored.sections, *parts]
    text = _page(page, parts, figures, explored)
    path = folder / REPORT
    with writing(path, f"put this right, then write it again with: tilth report {folder}"):
        write_durably(path, text.encode(), f"{WRITTEN_ASIDE}{os.getpid()}")
    return path


_NOT_INTERACTIVE = "The interactive curves and body could not be made"


def _page(
    page: Mapping[str, Any],
    parts: Sequence[Section],
    figures: Figures,
    explored: Explored | None,
) -> str:
    """Returns the whole page."""
    from markupsafe import Markup

    more = {"curves": None, "body": None} if explored is None else explored.data
    data, elements = figures.data(**more)
    return render(
        "page.html",
        **page,
        sections=parts,
        style=Markup(CSS + styles()),
        data=Markup(data),
        blobs=Markup(elements + ("" if explored is None else explored.elements)),
        scripts=[Markup(source(name)) for name in SCRIPTS],
    )


def _sections(run: Run, figures: Figures) -> list[Section]:
    """Returns all sections that the run has something for."""
    found = [Section("Force and displacement", _drawn(sections.forces, run, figures))]
    pictures = _drawn(sections.setup, run, figures) + _drawn(sections.parameters, run, figures)
    found.append(Section("Set-up", pictures))
    if run.stages:
        table = stage_table(run.summary["stages"], run.history, run.stages, run.log)
        found.append(Section("Stages", [table]))
    if run.relaxed:
        found.append(Section("Beyond the limit load", relaxation_table(run.relaxed)))
    found.append(Section("Deformed states", _drawn(sections.outputs, run, figures)))
    found.append(Section("Contact", _drawn(sections.contact, run, figures)))
    found.append(Section("Tracked quantities", _drawn(sections.tracked, run, figures)))
    found.append(Section("Energies", _drawn(sections.energies, run, figures)))
    found.append(Section("Convergence", _drawn(sections.convergence, run, figures)))
    for heading, index in sections.reductions(run):
        own = _drawn(partial(sections.safety, index=index), run, figures)
        found.append(Section(heading, own))
    found.append(Section("Warnings and step cuts", sections.warnings(run.log)))
    found.append(Section("The model", model_tables(run.summary)))
    found.append(Section("Looking at the results", [sections.how_to_open(run.results)]))
    return [section for section in found if section.blocks]


def _drawn(
    section: Callable[[Run, Figures], list[Block]], run: Run, figures: Figures
) -> list[Block]:
    """Returns the content of a section, or a sentence if it cannot be drawn: the rest is of use."""
    try:
        return section(run, figures)
    except (TilthError, OSError):  # damaged results, a full disk: no matter of drawing
        raise
    except Exception as error:
        if is_memory_error(error):
            raise
        reason = f"{type(error).__name__}: {error}"
        return [Paragraph(f"This part of the report could not be drawn ({reason}).")]
