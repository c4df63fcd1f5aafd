# SPDX-License-Identifier: BSD-3-Clause
"""The sections of the report of a run: what each one has to show."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.output.folder import BOUNDARIES, ENERGIES, SETUP, safety_files
from tilth.output.history import read_history
from tilth.output.log import LogContents
from tilth.output.safety_files import read_safety
from tilth.output.vtkhdf import Results, read_results
from tilth.report.blocks import Block, Items, Paragraph, Table, Template
from tilth.report.charts import Chart, number, numbers_table
from tilth.report.colour_scale import ColourScale
from tilth.report.contact_plots import contact_chart, contact_note, contact_view
from tilth.report.energies import energy_charts, energy_table
from tilth.report.fields import field_values, parameter_fields, with_unit
from tilth.report.figures import Figures
from tilth.report.history_plots import history_charts, newton_charts, tracked_columns
from tilth.report.motion_plots import caption, ends_of_stages, force_charts, motion_curves
from tilth.report.relaxations import Relaxed, after
from tilth.report.safety import (
    FIELDS,
    MECHANISM_NOTE,
    mechanism,
    safety_chart,
    text_of,
    trials_table,
)
from tilth.report.setup import Setup
from tilth.report.setup_page import setup_view
from tilth.report.stage_marks import (
    Span,
    first_outputs,
    outputs_of_stages,
    spans_of_steps,
    stage_of,
)
from tilth.report.stage_setups import StagedSetup
from tilth.report.tables import facts_table
from tilth.report.views import Cloud, OutputsOnPaper, Panel, View

MAXIMUM_FRAMES = 6
"""Outputs on paper, unless a run has more stages."""
_NUMBERS = "Numbers: some of the rows"


@dataclass(frozen=True, eq=False)
class Run:
    """All that the folder of a run has."""

    folder: Path
    summary: Mapping[str, Any]
    """The declared model as nested mappings and lists."""
    results: Results
    history: Mapping[str, Floats]
    log: LogContents
    stages: Sequence[Span]
    """Those that it has begun, by total times."""
    relaxed: Sequence[Relaxed]
    setup: Setup | StagedSetup | None

    @property
    def kind(self) -> str:
        """Of the analysis."""
        return str(self.summary.get("analysis", {}).get("kind", ""))

    @property
    def colour_by(self) -> str:
        """Field that the page shows first."""
        return str(self.summary.get("output", {}).get("colour_by", "displacement"))

    @property
    def time_unit(self) -> str:
        """Label of the unit of time."""
        return self.results.units.get("time", "")

    @property
    def length_unit(self) -> str:
        """Label of the unit of lengths."""
        return self.results.units.get("length", "")

    @property
    def axes(self) -> tuple[str, str, str]:
        """Names of the axes."""
        return ("r" if self.kind == "axisymmetric" else "x", "y", "z")


def header(run: Run) -> list[Block]:
    """Returns the state of the run and a table of its main data."""
    results, log = run.results, run.log
    labels = (unit for name, unit in results.units.items() if unit and name != "volume")
    units = ", ".join(dict.fromkeys(labels))
    seconds = "unknown" if log.seconds is None else f"{log.seconds:,.1f} s"
    kinds = {"plane_strain": "plane strain", "axisymmetric": "axisymmetric", "3d": "3D"}
    facts = {
        "analysis": kinds.get(run.kind, run.kind),
        "points": log.facts.get("points", ""),
        "initial state": log.start,
        "active cells at the start": log.facts.get("active cells", ""),
        "last step": f"{log.last_step}, time {results.times[-1]:.4g} at the last output",
        "outputs": str(len(results)),
        "units": units,
        "threads": log.facts.get("threads", ""),
        "time taken": seconds,
        "date": log.facts.get("date", ""),
    }
    if log.finished:
        state = Paragraph("The run reached the end of its schedule.", "state good")
    else:
        reason = f": {log.failure}" if log.failure else ", for example by an interrupt"
        stopped = f" It stopped before the end of its schedule{reason}."
        text = f"{stopped} What follows is the state reached."
        state = Paragraph(text, "state bad", "This run is incomplete.")
    return [state, facts_table({name: value for name, value in facts.items() if value})]


def forces(run: Run, figures: Figures) -> list[Block]:
    """Returns the reactions of all that moves against its motion; nothing if nothing moves."""
    if not (run.folder / BOUNDARIES).exists():
        return []
    table = read_history(run.folder / BOUNDARIES)
    curves = motion_curves(table, run.summary)
    if not curves:
        return []
    charts = force_charts(curves, ends_of_stages(table["time"], run.stages))
    tables: list[Block] = [
        numbers_table({c.motion_label: c.motion, c.reaction_label: c.reaction}, _NUMBERS)
        for c in curves
    ]
    return [*figures.draw(charts), *tables, Paragraph(caption(curves, run.kind))]


def setup(run: Run, figures: Figures) -> list[Block]:
    """Returns the pictures of the set-up, or why there are none."""
    if run.setup is None:
        return [Template("no_setup.html", {"file": SETUP})]
    note = [Paragraph(_ABOUT_STAGES)] if isinstance(run.setup, StagedSetup) else []
    view = setup_view(run.setup)
    words = [[text.partition("\n")[0], text.partition("\n")[2]] for _, _, text in view.keys]
    return [*figures.draw([view]), *note, Table(words, summary="What the picture shows, in words")]


_ABOUT_STAGES = """The soil is drawn undeformed, as each stage begins: what is new in it is darker,
what was removed is hatched. Loads are those at the end of the stage."""


def parameters(run: Run, figures: Figures) -> list[Block]:
    """Returns each parameter that varies from place to place, and the layers.

    Of stages that bring soil or exchange materials the first outputs are drawn too. The body at
    all outputs shows them on a screen.
    """
    results, stages = run.results, run.stages
    frames = [results.snapshot(0)]
    titles = ["start"]
    names = parameter_fields(frames[0])
    if names and stages:
        first = first_outputs(np.asarray(results.times), stages, run.summary)
        frames += [results.snapshot(index) for index in first.values()]
        titles = [f"{stages[0][0]}: start", *(f"{name}: first output" for name in first)]
    found: list[Block] = []
    for name in names:
        text = f"{name.replace('_', ' ')} at the start"
        steps = [frame.step for frame in frames]
        found += figures.draw([OutputsOnPaper(text, name, steps, titles, "domains")])
        rows = []
        for frame, title in zip(frames, titles, strict=True):
            values, label = field_values(frame, name, results.units)
            rows.append([title, *_range(values)])
        found.append(Table(rows, [label, "smallest", "largest"], f"Numbers: {text}"))
    return found


def _range(values: Floats) -> list[str]:
    known = values[np.isfinite(values)]
    return [number(float(known.min())), number(float(known.max()))] if len(known) else ["", ""]


def outputs(run: Run, figures: Figures) -> list[Block]:
    """Returns up to six outputs at even intervals for paper, and a table of all that are chosen.

    Of a run with stages those at their ends are among them, as far as there are not too many.
    """
    results, stages = run.results, run.stages
    count = min(len(results), MAXIMUM_FRAMES)
    chosen = np.unique(np.round(np.linspace(0, len(results) - 1, count)).astype(int)).tolist()
    if stages:
        chosen = outputs_of_stages(np.asarray(results.times), stages, MAXIMUM_FRAMES)
        titles = [_title_in_stage(results, index, stages) for index in chosen]
    else:
        titles = [f"step {results.steps[k]}, time {results.times[k]:.4g}" for k in chosen]
    if run.relaxed:
        told = [after(run.relaxed, int(results.steps[index])) for index in chosen]
        titles = [f"{title}; {text}" if text else title
                  for title, text in zip(titles, told, strict=True)]  # fmt: skip
    steps = [int(results.steps[index]) for index in chosen]
    drawn = "field" if results.dim == 2 else "domains"
    if run.colour_by in parameter_fields(results.snapshot(0)):
        drawn = "domains"  # the values of neighbours may have nothing between them
    name = f"Deformed points coloured by {run.colour_by}"
    rows = []
    for index, title in zip(chosen, titles, strict=True):
        snapshot = results.snapshot(index)
        values, label = field_values(snapshot, run.colour_by, results.units)
        moved = np.linalg.norm(snapshot.point_fields["displacement"], axis=1).max(initial=0.0)
        points = f"{len(snapshot.position):,}"
        rows.append([title, points, number(float(moved)), *_range(values)])
    heads = ["output", "points", with_unit("largest displacement", run.length_unit)]
    heads += [f"smallest {label}", f"largest {label}"]
    note = "Displacements are not magnified."
    if len(chosen) < len(results):
        note = f"{len(chosen)} of {len(results)} outputs. {note}"
    return [
        Paragraph("They are above, under “The body at all outputs”; on paper here.", "on-screen"),
        *figures.draw([OutputsOnPaper(name, run.colour_by, steps, titles, drawn)]),
        Table(rows, heads, "Numbers of these outputs"),
        Paragraph(note),
    ]


def _title_in_stage(results: Results, index: int, stages: Sequence[Span]) -> str:
    time, step = float(results.times[index]), results.steps[index]
    name, begin, _ = stage_of(stages, time)
    return f"{name}: stage time {time - begin:.4g}; step {step}, total time {time:.4g}"


def contact(run: Run, figures: Figures) -> list[Block]:
    """Returns pictures of each contact surface that has points at the last output."""
    if not run.results.names["contacts"]:
        return []
    last = run.results.snapshot(-1)
    units = run.results.units
    found: list[Chart | View] = []
    rows: list[list[str]] = []
    for shape in last.contacts:
        if len(shape.position) == 0:
            continue
        found.append(contact_view(last, shape, units, run.kind == "axisymmetric"))
        if last.dim == 2:
            found.append(contact_chart(shape, units))
        pressure = -np.asarray(shape.fields["normal_stress"]) + 0.0
        touching = int(np.count_nonzero(shape.fields["in_contact"]))
        rows.append([shape.name, f"{touching:,} of {len(pressure):,}", *_range(pressure)])
    if not found:
        return []
    unit = units.get("stress", "")
    heads = ["surface", "points in contact", with_unit("smallest pressure", unit)]
    heads.append(with_unit("largest pressure", unit))
    when = f"Step {last.step}, time {last.time:.4g}. "
    return [
        *figures.draw(found),
        Table(rows, heads, "Numbers of each surface"),
        Paragraph(when + contact_note(last.dim)),
    ]


def tracked(run: Run, figures: Figures) -> list[Block]:
    """Returns the tracked quantities over time."""
    charts = history_charts(run.history, run.time_unit, run.stages, run.relaxed)
    if not charts:
        return [Paragraph("Nothing was tracked.")]
    columns = {with_unit("time", run.time_unit): run.history["time"]}
    columns |= tracked_columns(run.history)
    return [*figures.draw(charts), numbers_table(columns, _NUMBERS)]


def energies(run: Run, figures: Figures) -> list[Block]:
    """Returns the balance of the energies of a run with inertia; nothing without."""
    if not (run.folder / ENERGIES).exists():
        return []
    table = read_history(run.folder / ENERGIES)
    charts = energy_charts(table, run.time_unit, run.stages)
    if not charts:
        return [Paragraph("There is no energy.")]
    return [*figures.draw(charts), energy_table(table), Paragraph(_ABOUT_ENERGIES)]


_ABOUT_ENERGIES = """The energy at the start and the work of loads and boundaries since then is the
sum of the other parts; what is numerical is what is in none of them: what the time integration,
ghost stabilisation and contact that closes or opens take, by their own formulas, and the error of
the balance. Where waves come in through an absorbing
boundary, less than nothing may have left. The numbers, one row per step, are in energies.csv."""


def convergence(run: Run, figures: Figures) -> list[Block]:
    """Returns charts of the iterations and residuals, with their statistics."""
    history, log = run.history, run.log
    computed = history["step"] > 0
    iterations = history["iterations"][computed]
    spans = spans_of_steps(history, run.stages)
    residuals = log.last_residuals
    charts = newton_charts(history["step"][computed], iterations, residuals, log.last_step, spans)
    found = figures.draw(charts)
    if len(iterations):
        text = (
            f"{len(iterations)} steps, {int(iterations.sum())} Newton iterations: on average "
            f"{iterations.mean():.1f}, at most {int(iterations.max())} a step."
        )
        found.append(Paragraph(text))
    if len(residuals):
        rows = [[str(k), f"{residual:.3g}"] for k, residual in enumerate(residuals)]
        heads = [f"Newton iteration of step {log.last_step}", "relative residual"]
        found.append(Table(rows, heads, "Numbers of the last step"))
    return found


def reductions(run: Run) -> Iterator[tuple[str, int | None]]:
    """Yields headings and indices of the strength reductions that were made."""
    for index, stage in enumerate(run.summary.get("stages", ())):
        if (run.folder / safety_files(index).summary).exists():
            yield f"Factor of safety: {stage.get('name', '')}", index
    if (run.folder / safety_files().summary).exists():
        yield "Factor of safety", None


def safety(run: Run, figures: Figures, index: int | None) -> list[Block]:
    """Returns factor, criterion, curve and mechanism of a strength reduction."""
    summary = read_safety(run.folder, index)
    results = read_results(run.folder / safety_files(index).mechanism)
    unit = results.units.get("length", "")
    drawn = mechanism(results)
    cloud = Cloud.of_snapshot(drawn)
    panels = []
    for name in FIELDS:
        values, label = field_values(drawn, name, results.units)
        shape = "field" if drawn.dim == 2 else "domains"
        panels.append(Panel("", 0, values, ColourScale.of([values]), label, shape))
    half = np.asarray(drawn.point_fields["domain"])
    view = View(
        "Mechanism",
        run.axes,
        unit,
        (drawn.position - half).min(axis=0),
        (drawn.position + half).max(axis=0),
        float(2.0 * np.median(half.prod(axis=1)) ** (1.0 / drawn.dim)),
        [cloud],
        panels,
    )
    return [
        Paragraph(text_of(summary)),
        *figures.draw([safety_chart(summary, unit)]),
        trials_table(summary, unit),
        *figures.draw([view]),
        Paragraph(MECHANISM_NOTE),
    ]


def warnings(log: LogContents) -> list[Block]:
    """Returns lists of the warnings and step cuts."""
    found: list[Block] = [
        Items(log.warnings, "warnings") if log.warnings else Paragraph("Warnings: none.")
    ]
    if log.cuts:
        return [*found, Paragraph(f"Step cuts: {len(log.cuts)}."), Items(log.cuts)]
    return [*found, Paragraph("Step cuts: none.")]


def how_to_open(results: Results) -> Template:
    """Returns the explanation of the files of the folder."""
    there = {"surfaces": bool(results.surfaces), "contact": bool(results.names["contacts"])}
    return Template("how_to_open.html", there)
