# SPDX-License-Identifier: BSD-3-Clause
"""The report of a study, one page that opens offline, and its picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from tilth.errors import visible
from tilth.model import Study, Vary
from tilth.output.disk import writing
from tilth.output.files import write_durably
from tilth.output.folder import REPORT
from tilth.report.blocks import Block, Link, Paragraph, Section, Table, render
from tilth.report.figures import CHART_SCRIPTS, Figures, source, styles
from tilth.report.style import CSS
from tilth.report.texts import save
from tilth.studies.charts import dependence_charts, outcome_charts
from tilth.studies.folder import RUN, SAMPLES, text_of
from tilth.studies.pictures import draw_outcomes
from tilth.studies.result import StudyResult
from tilth.studies.samples import folder_of
from tilth.studies.statistics import QUANTILES

MOST_ROWS = 2000
"""Samples in the table of the page, at most; all are in study.csv."""

MOST_VALUES = 8
"""Values of a list that the page names, at most."""

STUDY_CSS = """
.wide table td { overflow-wrap: normal; white-space: nowrap; }
@media print { .wide { overflow-x: visible; } tr { break-inside: avoid; } }
"""


def write_page(page: Path, picture: Path, asked: Study, result: StudyResult) -> None:
    """Writes the page, and the picture of the distributions of all outcomes."""
    from markupsafe import Markup

    figures = Figures()
    sections = [
        Section("What differs", _entries(asked)),
        Section("Statistics", [_statistics(result), *figures.draw(outcome_charts(result))]),
        Section("Outcomes against parameters", figures.draw(dependence_charts(asked, result))),
        Section("Samples that failed", _failures(result), name="failed"),
        Section("Samples", _samples(result)),
    ]
    data, elements = figures.data()
    text = render(
        "page.html",
        title=visible(asked.title or "Study"),
        head=[_state(result)],
        sections=[section for section in sections if section.blocks],
        footer="",
        style=Markup(CSS + styles() + STUDY_CSS),
        data=Markup(data),
        blobs=Markup(elements),
        scripts=[Markup(source(name)) for name in (*CHART_SCRIPTS, "start.js")],
    )
    with writing(page):
        write_durably(page, text.encode())
    with writing(picture):
        save(draw_outcomes(result), picture, dpi=130)


def _state(result: StudyResult) -> Paragraph:
    count, failed = len(result.numbers), len(result.reasons)
    if not failed:
        return Paragraph(f"All {count} samples are done.", "state good")
    share = failed / count
    error = math.sqrt(share * (1.0 - share) / count)
    return Paragraph(
        f", a share of {share:.3g} with a standard error of {error:.2g}. The statistics are those "
        "of the samples that have the outcome.",
        "state bad",
        f"{failed} of {count} samples failed",
        ("#failed", "The reasons are below."),
    )


def _entries(asked: Study) -> list[Block]:
    """Returns a table of what differs between the samples."""
    rows = [
        [entry.key if entry.name is None else f"{entry.name} ({entry.key})", _values(entry)]
        for entry in asked.vary
    ]
    found: list[Block] = [_table(rows, ["entry of the case", "values"])]
    if any(entry.is_random for entry in asked.vary):
        found.append(Paragraph(f"Random draws with the seed {asked.seed} of the study."))
    return found


def _values(entry: Vary) -> str:
    """Returns the values of an entry in words."""
    if entry.new_seed:
        return "a seed of its own for each sample"
    if entry.range is not None:
        between = entry.range
        spacing = "equal distances" + (" of the logarithms" if between.spacing == "log" else "")
        return f"{between.count} from {between.start:g} to {between.stop:g} at {spacing}"
    if entry.distribution is not None:
        numbers = entry.distribution.model_dump(exclude={"type"}).items()
        named = ", ".join(f"{key.replace('_', ' ')} {value:g}" for key, value in numbers)
        return f"{entry.distribution.type} distribution, {named}"
    values = entry.values or ()
    named = ", ".join(text_of(value) for value in values[:MOST_VALUES])
    more = len(values) - MOST_VALUES
    return f"{named} and {more} others" if more > 0 else named


def _statistics(result: StudyResult) -> Table:
    """Returns a table with a column for each outcome."""
    rows = result.statistics
    lines: list[tuple[str, list[str]]] = [
        ("samples", [f"{s.count}" for s in rows]),
        ("without it", [f"{s.without}" for s in rows]),
    ]
    for key in ("mean", "standard_error", "standard_deviation", "smallest"):
        name = "standard error of the mean" if key == "standard_error" else key.replace("_", " ")
        lines.append((name, [_number(getattr(s, key)) for s in rows]))
    for i, quantile in enumerate(QUANTILES):
        name = "median" if quantile == 0.5 else f"{100 * quantile:g} % are below"
        lines.append((name, [_number(s.quantiles[i]) for s in rows]))
    lines.append(("largest", [_number(s.largest) for s in rows]))
    worst = [
        _link(result, s.worst_sample, f"{_number(s.worst)} (sample {s.worst_sample})")
        if s.worst_sample
        else "-"
        for s in rows
    ]
    cells = [[name, *values] for name, values in lines]
    return _table([*cells, ["worst case", *worst]], ["", *(s.heading for s in rows)])


def _failures(result: StudyResult) -> list[Block]:
    if not result.reasons:
        return []
    rows: list[list[str | Link]] = [
        [_link(result, number, f"sample {number}"), reason]
        for number, reason in result.reasons.items()
    ]
    return [Table(_visible(rows), ["sample", "reason"])]


def _samples(result: StudyResult) -> list[Block]:
    heads = ["sample", *result.values, *result.outcomes, "status"]
    rows: list[list[str | Link]] = []
    for i, number in enumerate(result.numbers[:MOST_ROWS]):
        cells = [text_of(column[i]) for column in result.values.values()]
        cells += [_number(float(column[i])) for column in result.outcomes.values()]
        cells.append("failed" if number in result.reasons else "done")
        rows.append([_link(result, number, f"sample {number}"), *cells])
    found: list[Block] = [Paragraph("All digits are in study.csv."), _table(rows, heads)]
    if (more := len(result.numbers) - MOST_ROWS) > 0:
        found.append(Paragraph(f"{more:,} further samples are in study.csv."))
    return found


def _link(result: StudyResult, number: int, text: str) -> Link:
    """Returns a link to the report of a sample's run, or to its folder where there is none."""
    place = f"{SAMPLES}/{folder_of(number)}/{RUN}"
    report = f"{place}/{REPORT}"
    there = report if (result.folder / report).exists() else place
    return Link(text, there)


def _table(rows: Sequence[Sequence[str | Link]], heads: Sequence[str]) -> Table:
    return Table(_visible(rows), [visible(head) for head in heads], wide=True)


def _visible(rows: Sequence[Sequence[str | Link]]) -> list[list[str | Link]]:
    return [[visible(cell) if isinstance(cell, str) else cell for cell in row] for row in rows]


def _number(value: float) -> str:
    return f"{value:.5g}" if math.isfinite(value) else "-"
