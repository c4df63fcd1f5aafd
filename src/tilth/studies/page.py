# SPDX-License-Identifier: BSD-3-Clause
"""The report of a study, one page that opens offline, and its picture."""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from tilth.errors import visible
from tilth.model import Study, Vary
from tilth.output.disk import writing
from tilth.output.files import write_durably
from tilth.output.folder import REPORT
from tilth.report.style import CSS
from tilth.report.texts import png
from tilth.studies.folder import RUN, SAMPLES, text_of
from tilth.studies.pictures import draw_dependence, draw_outcomes
from tilth.studies.samples import folder_of
from tilth.studies.statistics import QUANTILES

if TYPE_CHECKING:
    from tilth.studies.run import StudyResult

MOST_ROWS = 2000
"""Samples in the table of the page, at most; all are in study.csv."""

MOST_VALUES = 8
"""Values of a list that the page names, at most."""

STUDY_CSS = """
.wide { overflow-x: auto; }
.wide table td { overflow-wrap: normal; white-space: nowrap; }
.wide img { min-width: 42rem; }
@media print {
  .wide { overflow-x: visible; }
  .wide img { min-width: 0; break-inside: avoid; }
  tr { break-inside: avoid; }
}
"""


def write_page(page: Path, picture: Path, asked: Study, result: StudyResult) -> None:
    """Writes the page, and the picture of the distributions of all outcomes."""
    outcomes = png(draw_outcomes(result))
    parts = [_state(result), _table_of_entries(asked)]
    parts += [_table_of_statistics(result), _image(outcomes)]
    dependence = draw_dependence(asked, result)
    if dependence is not None:
        parts += ["<h2>Outcomes against parameters</h2>", _image(png(dependence))]
    parts += [_failures(result), _table_of_samples(result)]
    title = escape(visible(asked.title or "Study"))
    text = (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{CSS}{STUDY_CSS}</style></head><body><main><h1>{title}</h1>"
        f"{''.join(parts)}</main></body></html>\n"
    )
    with writing(page):
        write_durably(page, text.encode())
    with writing(picture):
        write_durably(picture, outcomes)


def _state(result: StudyResult) -> str:
    count, failed = len(result.numbers), len(result.reasons)
    if not failed:
        return f'<p class="state good">All {count} samples are done.</p>'
    share = failed / count
    error = math.sqrt(share * (1.0 - share) / count)
    return (
        f'<p class="state bad"><strong>{failed} of {count} samples failed</strong>, a share of '
        f"{share:.3g} with a standard error of {error:.2g}. The statistics are those of the "
        'samples that have the outcome; <a href="#failed">the reasons</a> are below.</p>'
    )


def _table_of_entries(asked: Study) -> str:
    """Returns a table of what differs between the samples."""
    rows = [_row(["entry of the case", "values"], "th")]
    for entry in asked.vary:
        name = entry.key if entry.name is None else f"{entry.name} ({entry.key})"
        rows.append(_row([name, _values(entry)], "td"))
    drawn = any(entry.is_random for entry in asked.vary)
    seed = f"<p>Random draws with the seed {asked.seed} of the study.</p>" if drawn else ""
    return f'<h2>What differs</h2><div class="wide"><table>{"".join(rows)}</table></div>{seed}'


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


def _table_of_statistics(result: StudyResult) -> str:
    """Returns a table with a column for each outcome."""
    rows = result.statistics
    lines = [("", [s.heading for s in rows])]
    lines += [
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
    body = "".join(_row([name, *cells], "th" if not name else "td") for name, cells in lines)
    worst = [
        f"{_number(s.worst)} ({_link(result, s.worst_sample)})" if s.worst_sample else "-"
        for s in rows
    ]
    cells = "".join(f"<td>{cell}</td>" for cell in worst)
    last = f"<tr><td>worst case</td>{cells}</tr>"
    return f'<h2>Statistics</h2><div class="wide"><table>{body}{last}</table></div>'


def _failures(result: StudyResult) -> str:
    if not result.reasons:
        return ""
    items = "".join(
        f"<li>{_link(result, number)}: {escape(visible(reason))}</li>"
        for number, reason in result.reasons.items()
    )
    return f'<h2 id="failed">Samples that failed</h2><ul class="warnings">{items}</ul>'


def _table_of_samples(result: StudyResult) -> str:
    heads = ["sample", *result.values, *result.outcomes, "status"]
    rows = [_row(heads, "th")]
    for i, number in enumerate(result.numbers[:MOST_ROWS]):
        cells = [text_of(column[i]) for column in result.values.values()]
        cells += [_number(float(column[i])) for column in result.outcomes.values()]
        cells.append("failed" if number in result.reasons else "done")
        others = "".join(f"<td>{escape(visible(cell))}</td>" for cell in cells)
        rows.append(f"<tr><td>{_link(result, number)}</td>{others}</tr>")
    more = len(result.numbers) - MOST_ROWS
    note = f"<p>{more:,} further samples are in study.csv.</p>" if more > 0 else ""
    table = f'<div class="wide"><table>{"".join(rows)}</table></div>'
    return f"<h2>Samples</h2><p>All digits are in study.csv.</p>{table}{note}"


def _link(result: StudyResult, number: int) -> str:
    """Returns a link to the report of a sample's run, or to its folder where there is none."""
    place = f"{SAMPLES}/{folder_of(number)}/{RUN}"
    report = f"{place}/{REPORT}"
    there = report if (result.folder / report).exists() else place
    return f'<a href="{there}">sample {number}</a>'


def _row(cells: Sequence[str], kind: str) -> str:
    return f"<tr>{''.join(f'<{kind}>{escape(visible(c))}</{kind}>' for c in cells)}</tr>"


def _number(value: float) -> str:
    return f"{value:.5g}" if math.isfinite(value) else "-"


def _image(content: bytes) -> str:
    data = base64.b64encode(content).decode()
    return f'<p class="wide"><img alt="" src="data:image/png;base64,{data}"></p>'
