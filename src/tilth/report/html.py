# SPDX-License-Identifier: BSD-3-Clause
"""``report.html``: one self-contained page with the model and the results of a run."""

from __future__ import annotations

import base64
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.errors import TilthError, visible
from tilth.input_files import absolute
from tilth.memory_errors import is_memory_error
from tilth.output.disk import writing
from tilth.output.files import WRITTEN_ASIDE, write_durably
from tilth.output.folder import (
    BOUNDARIES,
    ENERGIES,
    HISTORY,
    LOG,
    REPORT,
    RESULTS,
    SETUP,
    read_declared,
    safety_files,
)
from tilth.output.history import read_history, read_stages
from tilth.output.log import LogContents, read_log
from tilth.output.safety_files import read_safety
from tilth.output.vtkhdf import Results, read_results
from tilth.report.contact_plots import contact_note, draw_contact
from tilth.report.energies import draw_energies, energy_table
from tilth.report.explorer.page import LARGEST_FRAME, LARGEST_PAGE, explorer_parts, styles
from tilth.report.field_plots import draw_frames
from tilth.report.fields import parameter_fields
from tilth.report.history_plots import draw_curves, draw_newton
from tilth.report.motion_plots import caption, draw_forces, ends_of_stages, motion_curves
from tilth.report.page_size import within
from tilth.report.relaxations import Relaxed, after, relaxation_table, relaxations
from tilth.report.safety import MECHANISM_NOTE, draw_mechanism, draw_safety_curve, text_of
from tilth.report.setup import Setup, page_setup
from tilth.report.setup_file import read_setup, read_staged_setup
from tilth.report.stage_marks import (
    Span,
    first_outputs,
    outputs_of_stages,
    spans_of_steps,
    stage_of,
    stage_table,
)
from tilth.report.stage_pages import draw_stages
from tilth.report.stage_setups import StagedSetup
from tilth.report.style import CSS
from tilth.report.svg_figure import SvgFigure
from tilth.report.tables import facts_table, model_tables
from tilth.report.texts import png

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MAXIMUM_FRAMES = 6


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
    kind = str(summary.get("analysis", {}).get("kind", ""))
    colour_by = str(summary.get("output", {}).get("colour_by", "displacement"))
    folder = Path(folder)
    results = read_results(folder / RESULTS)
    history = read_history(folder / HISTORY)
    log = read_log(folder / LOG)
    stages = read_stages(folder / HISTORY) if summary.get("stages") else []
    title = results.title or visible(absolute(folder).name)
    parts = [_header(title, kind, results, log)]
    if (folder / SETUP).exists():
        staged = read_staged_setup(folder / SETUP)
        setup = staged or read_setup(folder / SETUP, results.snapshot(0))
    if forces := _drawn(_forces, folder, kind, summary, stages):
        parts.append(_section("Force and displacement", forces))
    pictures = _drawn(_setup_picture, setup) + _drawn(_parameters, results, kind, summary, stages)
    parts.append(_section("Set-up", pictures))
    if stages:
        table = stage_table(summary["stages"], history, stages, log)
        parts.append(_section("Stages", table))
    if relaxed := relaxations(history):
        parts.append(_section("Beyond the limit load", relaxation_table(relaxed)))
    frames = _drawn(_frames, results, kind, colour_by, stages, setup, relaxed)
    parts.append(_section("Deformed states", frames))
    if pressures := _drawn(_contact, results, kind):
        parts.append(_section("Contact", pressures))
    time_unit = results.units.get("time", "")
    content = _drawn(_tracked, history, time_unit, stages, relaxed)
    parts.append(_section("Tracked quantities", content))
    if balance := _drawn(_energies, folder, time_unit, stages):
        parts.append(_section("Energies", balance))
    parts.append(_section("Convergence", _drawn(_convergence, history, log, stages)))
    for heading, index in _reductions(folder, summary):
        parts.append(_section(heading, _drawn(_safety, folder, kind, index)))
    parts.append(_section("Warnings and step cuts", _warnings(log)))
    parts.append(_section("The model", model_tables(summary)))
    parts.append(_section("Looking at the results", _how_to_open(results)))
    parts = within(parts, LARGEST_PAGE - LARGEST_FRAME)
    used = sum(len(part.encode()) for part in parts)
    try:
        explored, scripts = explorer_parts(
            folder, results, history, summary, colour_by, setup, stages, LARGEST_PAGE - used
        )
    except MemoryError:
        raise
    except Exception as error:  # the page is of use without its interactive part
        explored, scripts = f"<p>{_NOT_INTERACTIVE}: {escape(str(error))}</p>", ""
    parts[1:1] = [_contents(parts, explored), explored]
    page = (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{CSS}{styles()}</style>\n</head>\n<body>\n<main>\n"
        + "\n".join(parts)
        + f"\n</main>\n<footer>tilth {escape(log.facts.get('tilth', ''))}</footer>\n"
        + f"{scripts}</body>\n</html>\n"
    )
    path = folder / REPORT
    with writing(path, f"put this right, then write it again with: tilth report {folder}"):
        write_durably(path, page.encode(), f"{WRITTEN_ASIDE}{os.getpid()}")
    return path


def _drawn(section: Callable[..., str], *arguments: Any) -> str:
    """Returns the content of a section, or a sentence if it cannot be drawn: the rest is of use."""
    try:
        return section(*arguments)
    except (TilthError, OSError):  # damaged results, a full disk: no matter of drawing
        raise
    except Exception as error:
        if is_memory_error(error):
            raise
        reason = escape(f"{type(error).__name__}: {error}")
        return f"<p>This part of the report could not be drawn ({reason}).</p>"


def _tracked(
    history: Mapping[str, Any], time_unit: str, stages: Sequence[Span], relaxed: Sequence[Relaxed]
) -> str:
    curves = draw_curves(history, time_unit, stages, relaxed)
    return _image(curves, "Tracked quantities") if curves else "<p>Nothing was tracked.</p>"


def _forces(folder: Path, kind: str, summary: Mapping[str, Any], stages: Sequence[Span]) -> str:
    """Returns the reactions of all that moves against its motion; nothing if nothing moves."""
    if not (folder / BOUNDARIES).exists():
        return ""
    table = read_history(folder / BOUNDARIES)
    curves = motion_curves(table, summary)
    if not curves:
        return ""
    figure = draw_forces(curves, ends_of_stages(table["time"], stages))
    return _image(figure, "Force against displacement") + f"<p>{escape(caption(curves, kind))}</p>"


def _energies(folder: Path, time_unit: str, stages: Sequence[Span]) -> str:
    """Returns the balance of the energies of a run with inertia; nothing without."""
    if not (folder / ENERGIES).exists():
        return ""
    table = read_history(folder / ENERGIES)
    figure = draw_energies(table, time_unit, stages)
    if figure is None:
        return "<p>There is no energy.</p>"
    return _image(figure, "Energies over time") + energy_table(table) + f"<p>{_ABOUT_ENERGIES}</p>"


_ABOUT_ENERGIES = """The energy at the start and the work of loads and boundaries since then is the
sum of the other parts; what is numerical is what is in none of them: what the time integration,
ghost stabilisation and contact that closes or opens take, by their own formulas, and the error of
the balance. Where waves come in through an absorbing
boundary, less than nothing may have left. The numbers, one row per step, are in energies.csv."""


def _how_to_open(results: Results) -> str:
    """Returns the section that explains the files of the folder."""
    surfaces = _ABOUT_SURFACES if results.surfaces else ""
    contact = _ABOUT_CONTACT if results.names["contacts"] else ""
    return f"<ul>\n{_HOW_TO_OPEN}{surfaces}{contact}</ul>"


_ABOUT_SURFACES = """<li><code>surface.csv</code> has the points of the tracked surfaces at the last
output with their normals; in the plane in order along each, with the arc length. In ParaView the
surfaces are the blocks <em>surface_...</em> of <code>results.vtkhdf</code>, at all times.</li>
"""

_ABOUT_CONTACT = """<li><code>contact.csv</code> has the points of the contact surfaces at the last
output with stresses, gap and state. In ParaView they are the blocks <em>contact_...</em> of
<code>results.vtkhdf</code>, rigid bodies the blocks <em>rigid_...</em>, at all times.</li>
"""

_HOW_TO_OPEN = """<li><code>results.vtkhdf</code> holds all outputs. Open it in ParaView (5.13 or
newer), press <em>Apply</em>, choose a block (<em>points</em> or <em>grid</em>) in the MultiBlock
Inspector and <em>Point Gaussian</em> as representation of the points. The play button steps through
the times.
It can also be read with h5py, or with <code>tilth.output.read_results</code>.</li>
<li><code>history.csv</code> has one row per step with all tracked quantities; any spreadsheet reads
it.</li>
<li><code>boundaries.csv</code>, where a boundary or body moves, has one row per step with its
displacement and rotation and with the force and moment that it exerts on the soil; of contact
between two soil bodies the force on the second one.</li>
<li><code>energies.csv</code>, with inertia, has one row per step with all energies.</li>
<li><code>log.txt</code> has the residuals of all Newton iterations.</li>
"""


def _header(title: str, kind: str, results: Results, log: LogContents) -> str:
    """Returns title, state of the run and a table of its main data."""
    labels = (unit for name, unit in results.units.items() if unit and name != "volume")
    units = ", ".join(dict.fromkeys(labels))
    seconds = "unknown" if log.seconds is None else f"{log.seconds:,.1f} s"
    kinds = {"plane_strain": "plane strain", "axisymmetric": "axisymmetric", "3d": "3D"}
    facts = {
        "analysis": kinds.get(kind, kind),
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
        state = '<p class="state good">The run reached the end of its schedule.</p>'
    else:
        reason = f": {escape(log.failure)}" if log.failure else ", for example by an interrupt"
        state = (
            '<p class="state bad"><strong>This run is incomplete.</strong> It stopped before the '
            f"end of its schedule{reason}. What follows is the state reached.</p>"
        )
    shown = {name: value for name, value in facts.items() if value}
    return f"<h1>{escape(title)}</h1>\n{state}\n{facts_table(shown)}"


def _setup_picture(setup: Setup | StagedSetup | None) -> str:
    """Returns the figure of the set-up, or why there is none."""
    if setup is None:
        return f"<p>{_NOT_DRAWN}</p>"
    if isinstance(setup, Setup):
        return _image(page_setup(setup), "Set-up: points, grid, conditions and loads")
    figures = draw_stages(setup)
    text = "Set-up of each stage: points, grid, conditions and loads"
    return "".join(_image(figure, text) for figure in figures) + f"<p>{_ABOUT_STAGES}</p>"


_ABOUT_STAGES = """The soil is drawn undeformed, as each stage begins: what is new in it is darker,
what was removed is hatched. Loads are those at the end of the stage."""


_NOT_DRAWN = f"""The set-up is not drawn: the folder has no <code>{SETUP}</code>. A report runs no
Python function of the model; <code>tilth check</code> draws the set-up of a case file."""


def _parameters(
    results: Results, kind: str, summary: Mapping[str, Any], stages: Sequence[Span]
) -> str:
    """Returns a figure of each parameter that varies from place to place, and of the layers.

    Of stages that bring soil or exchange materials the first outputs are drawn too.
    """
    frames, titles, figures = [results.snapshot(0)], [], []
    names = parameter_fields(frames[0])
    if names and stages:
        first = first_outputs(np.asarray(results.times), stages, summary)
        frames += [results.snapshot(index) for index in first.values()]
        titles = [f"{stages[0][0]}: start", *(f"{name}: first output" for name in first)]
    for name in names:
        figure = draw_frames(
            frames, name, results.units, axisymmetric=kind == "axisymmetric", titles=titles,
            page=True,
        )  # fmt: skip
        figures.append(_image(figure, f"{name.replace('_', ' ')} at the start"))
    return "".join(figures)


def _frames(
    results: Results,
    kind: str,
    colour_by: str,
    stages: Sequence[Span],
    setup: Setup | StagedSetup | None,
    relaxed: Sequence[Relaxed],
) -> str:
    """Returns a figure of up to six outputs at even intervals, including the first and last.

    Of a run with stages those at their ends are among them, as far as there are not too many.
    """
    count = min(len(results), MAXIMUM_FRAMES)
    chosen = np.unique(np.round(np.linspace(0, len(results) - 1, count)).astype(int)).tolist()
    titles: list[str] = []
    if stages:
        chosen = outputs_of_stages(np.asarray(results.times), stages, MAXIMUM_FRAMES)
        titles = [_title_in_stage(results, index, stages) for index in chosen]
    if relaxed:
        titles = titles or [
            f"step {results.steps[index]}, time {results.times[index]:.4g}" for index in chosen
        ]
        told = [after(relaxed, int(results.steps[index])) for index in chosen]
        titles = [f"{title}\n{text}" for title, text in zip(titles, told, strict=True)]
    figure = draw_frames(
        [results.snapshot(int(index)) for index in chosen],
        colour_by,
        results.units,
        axisymmetric=kind == "axisymmetric",
        initial=results.snapshot(0),
        titles=titles,
        water=lambda time: None if setup is None else setup.water_at(time),
        page=True,
    )
    note = "Displacements are not magnified."
    if len(chosen) < len(results):
        note = f"{len(chosen)} of {len(results)} outputs. " + note
    return _image(figure, f"Deformed points coloured by {colour_by}") + f"<p>{note}</p>"


def _contact(results: Results, kind: str) -> str:
    """Returns a figure of each contact surface that has points at the last output."""
    if not (names := results.names["contacts"]):
        return ""
    last, content = results.snapshot(-1), ""
    for name in names:
        figure = draw_contact(last, name, results.units, kind == "axisymmetric")
        if figure is not None:
            content += _image(figure, f"Pressure and shear on {name}")
    return content and content + f"<p>{contact_note(last.dim)}</p>"


def _title_in_stage(results: Results, index: int, stages: Sequence[Span]) -> str:
    time, step = float(results.times[index]), results.steps[index]
    name, begin, _ = stage_of(stages, time)
    return f"{name}: stage time {time - begin:.4g}\nstep {step}, total time {time:.4g}"


def _convergence(history: Mapping[str, Any], log: LogContents, stages: Sequence[Span]) -> str:
    """Returns a plot of the iterations and residuals, with their statistics."""
    computed = history["step"] > 0
    iterations = history["iterations"][computed]
    spans = spans_of_steps(history, stages)
    steps, residuals = history["step"][computed], log.last_residuals
    figure = draw_newton(steps, iterations, residuals, log.last_step, spans)
    text = ""
    if len(iterations):
        text = (
            f"<p>{len(iterations)} steps, {int(iterations.sum())} Newton iterations: on average "
            f"{iterations.mean():.1f}, at most {int(iterations.max())} a step.</p>"
        )
    return _image(figure, "Newton iterations per step and residuals of the last step") + text


def _reductions(folder: Path, summary: Mapping[str, Any]) -> Iterator[tuple[str, int | None]]:
    """Yields headings and indices of the strength reductions that were made."""
    for index, stage in enumerate(summary.get("stages", ())):
        if (folder / safety_files(index).summary).exists():
            yield f"Factor of safety: {stage.get('name', '')}", index
    if (folder / safety_files().summary).exists():
        yield "Factor of safety", None


def _safety(folder: Path, kind: str, index: int | None) -> str:
    """Returns factor, criterion, curve and mechanism of a strength reduction."""
    summary = read_safety(folder, index)
    results = read_results(folder / safety_files(index).mechanism)
    curve = draw_safety_curve(summary, results.units.get("length", ""))
    content = f"<p>{escape(text_of(summary))}</p>" + _image(curve, "Displacement over the factor")
    for name, figure in draw_mechanism(results, axisymmetric=kind == "axisymmetric").items():
        content += _image(figure, f"Mechanism: {name}")
    return content + f"<p>{MECHANISM_NOTE}</p>"


def _warnings(log: LogContents) -> str:
    """Returns lists of the warnings and step cuts."""
    warnings = "<p>Warnings: none.</p>"
    if log.warnings:
        items = "".join(f"<li>{escape(text)}</li>" for text in log.warnings)
        warnings = f'<ul class="warnings">{items}</ul>'
    cuts = "<p>Step cuts: none.</p>"
    if log.cuts:
        items = "".join(f"<li>{escape(text)}</li>" for text in log.cuts)
        cuts = f"<p>Step cuts: {len(log.cuts)}.</p><ul>{items}</ul>"
    return warnings + cuts


_NOT_INTERACTIVE = "The interactive curves and body could not be made"


def _section(heading: str, content: str) -> str:
    place = _SECTION_NAME.sub("-", heading.lower()).strip("-")
    return f'<section id="{place}">\n<h2>{escape(heading)}</h2>\n{content}\n</section>'


def _contents(parts: Sequence[str], explored: str) -> str:
    """Returns links to all sections, those that can be explored first."""
    found = _SECTION.findall(explored) + [each for part in parts for each in _SECTION.findall(part)]
    links = "".join(f'<a href="#{place}">{heading}</a>\n' for place, heading in found)
    return f'<nav class="contents" aria-label="Contents">\n{links}</nav>'


_SECTION_NAME = re.compile(r"[^a-z0-9]+")
_SECTION = re.compile(r'<section id="([^"]+)"[^>]*>\s*<h2>(.*?)</h2>')


def _image(figure: Figure | SvgFigure, text: str) -> str:
    """Returns the figure as an image inside the page; ``text`` is its alternative text."""
    if isinstance(figure, SvgFigure):
        kind, content = "svg+xml", figure.svg().encode()
    else:
        kind, content = "png", png(figure)
    data = base64.b64encode(content).decode()
    return f'<img alt="{escape(text)}" src="data:image/{kind};base64,{data}">'
