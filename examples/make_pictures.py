# SPDX-License-Identifier: BSD-3-Clause
"""Makes the picture of each example's README: `python examples/make_pictures.py [NAME]...`.

Runs case.toml of the examples; draws the output at half time and the last one as the report does,
in the plane with the boundaries.
Of those in `FIELDS` it draws the initial values of a field and the last output.
Of the examples in `SURFACES` it draws the surface after every step, for the case files named there;
of those in `TROUGHS` the settlement on some grids and the last output; of those in `BASES` a case
at one time with several bases, on the true domains. For the example of element tests it draws the
first picture of each of its case files, `picture.png` of case.toml.
Of those in `HISTORIES` it draws tracked quantities over time, of those in `ISOCHRONES` the excess
pore pressure of the points at some times.
Of those in `SAFETY` it draws the mechanism at the factor of safety. Of `hertz` it draws the shear
under the cylinder of cattaneo.toml as well, cattaneo.png; of `strip_footing` graded.toml as
well, graded.png.
"""

import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.image import imsave

import tilth
from tilth.analysis.march import march
from tilth.curves import LocalCubicSpline
from tilth.element_tests.plots import draw_plot
from tilth.mpm.initial_points import initial_points
from tilth.mpm.pore_water import PRESSURE
from tilth.output.folder import SETUP
from tilth.output.vtkhdf import read_results
from tilth.plot.run import PlottedRun
from tilth.plot.surroundings import draw_segments
from tilth.plot.views import PlaneView, around
from tilth.report.field_plots import draw_frames
from tilth.report.setup_file import read_setup
from tilth_verification import (
    cam_clay_consolidation,
    large_consolidation,
    mandel,
    pressed_ball,
    radial_drain,
    slurry,
    terzaghi,
)
from tilth_verification.cases import varied
from tilth_verification.cattaneo import FRICTION, normal_contact, tractions
from tilth_verification.closed_forms.elastic_contact import Cattaneo
from tilth_verification.contact_runs import run_contact
from tilth_verification.reference import pressure_cantilever
from tilth_verification.shear_column import closed_form
from tilth_verification.tunnel import settle

EXAMPLES = Path(__file__).parent
SURFACES = {"pressure_cantilever": ("case.toml", "fine.toml")}
FIELDS = {"random_field_slope": "undrained_shear_strength", "k0_slope": "pore_pressure"}
BASES = {"generalized_shear": ("turn.toml", 15)}
HISTORIES = ("elastic_bar", "shear_column")
ISOCHRONES = {
    "cam_clay_consolidation": (cam_clay_consolidation.isochrone, 1, (4.0, 10.0, 20.0, 40.0, 80.0)),
    "terzaghi": (terzaghi.isochrone, 1, (273.75, 638.75, 1186.25, 1825.0, 3650.0)),
    "large_consolidation": (large_consolidation.isochrone, 1, (80.0, 240.0, 480.0, 800.0, 1600.0)),
    "cryer": (pressed_ball.isochrone, None, (1.0, 25.0, 125.0, 250.0, 500.0)),
    "de_leeuw": (pressed_ball.isochrone, None, (1.0, 25.0, 125.0, 250.0, 500.0)),
    "mandel": (mandel.isochrone, 0, (2.0, 10.0, 40.0, 80.0, 150.0)),
    "slurry": (slurry.isochrone, 1, (300.0, 600.0, 1200.0, 2400.0, 6000.0)),
    "radial_drain": (radial_drain.isochrone, 0, (1.0, 2.5, 6.0, 12.0, 24.0)),
}
"""Example -> reference, axis along which the pressure is drawn (None: distance from the centre),
times."""
SAFETY = ("slope_strength_reduction", "infinite_slope")
TROUGHS = {"tunnel": (0.6, 0.3)}
RULES = (("cpdi2", None), ("gimp", "left_stretch"), ("gimp", "corners"), ("linear", None))


def make_picture(name: str, case: str = "case", picture: str = "picture") -> None:
    model = tilth.load_case(EXAMPLES / name / f"{case}.toml")
    with tempfile.TemporaryDirectory() as folder:
        result = tilth.run(model, Path(folder) / "results", quiet=True)
        results = read_results(result.folder / "results.vtkhdf")
        numbers = sorted({len(results) // 2, len(results) - 1})
        figure = draw_frames(
            [results.snapshot(index) for index in numbers],
            model.output.colour_by,
            results.units,
            axisymmetric=model.analysis.kind == "axisymmetric",
            initial=results.snapshot(0),
            water=read_setup(result.folder / SETUP, results.snapshot(0)).water_at,
        )
        if model.dimension == 2:
            draw_boundaries(figure, PlottedRun.of(result.folder), numbers)
        figure.savefig(EXAMPLES / name / f"{picture}.png", dpi=110)


def draw_boundaries(figure: Figure, run: PlottedRun, outputs: list[int]) -> None:
    """Adds the boundaries to the panels of some outputs."""
    snapshots = [run.results.snapshot(number) for number in outputs]
    view = PlaneView(run, "field")
    panels = figure.axes[: len(snapshots)]
    shown = panels[0].viewLim
    limits = shown.min, shown.max
    if panels[0].get_aspect() == 1.0:  # to scale
        limits = around([limits, *(view.limits(snapshot) for snapshot in snapshots)])
    for axes, snapshot in zip(panels, snapshots, strict=True):
        axes.set(xlim=(limits[0][0], limits[1][0]), ylim=(limits[0][1], limits[1][1]))
        for part in run.boundaries(snapshot, *limits):
            draw_segments(axes, part["position"])


def draw_surfaces(name: str, files: tuple[str, ...]) -> None:
    """The surfaces of pressure_cantilever with some case files."""
    models = [tilth.load_case(EXAMPLES / name / file) for file in files]
    surface_figure(models).savefig(EXAMPLES / name / "picture.png", dpi=110)


def surface_figure(models: list[tilth.Model]) -> Figure:
    """The surface after every step, the points at the end and the reference, on the grid."""
    figure = Figure(figsize=(5.2 * len(models), 5.0), layout="constrained")
    axes_of = figure.subplots(1, len(models), sharex=True, sharey=True, squeeze=False)[0]
    for axes, model in zip(axes_of, models, strict=True):
        lines = []

        def after_step(simulation, result, time, lines=lines):
            (chain,) = simulation.state.surfaces["beam"].chains
            lines.append(LocalCubicSpline(chain.current).polyline(8))

        place = march(model, after_step).state.points.position
        axes.plot(*place.T, ".", color="#d8b070", markersize=30.0 / len(place) ** 0.5)
        for line in lines[:-1]:
            axes.plot(*line.T, color="#3b6ea5", linewidth=0.5)
        axes.plot(*lines[-1].T, color="#12304f", linewidth=1.6)
        modulus = model.materials["rubber"].parameter("young_modulus")
        for outline in pressure_cantilever(modulus).outlines.values():
            axes.plot(*outline.T, color="#c0392b", linewidth=1.0, linestyle=(0, (2, 3)))
        axes.set_aspect("equal")
        axes.set_title(f"E {modulus / 1e3:g} kPa, h {model.cell_size[0]:g} m", fontsize=9)
        axes.set_xlabel("x [m]")
    lower, upper = np.transpose([axes_of[0].get_xlim(), axes_of[0].get_ylim()])
    width, height = upper - lower
    figure.set_figheight(4.5 * height / width + 0.8)
    for axes, model in zip(axes_of, models, strict=True):
        cell = model.cell_size
        for k, draw in enumerate((axes.axvline, axes.axhline)):
            for line in range(int(np.ceil(lower[k] / cell[k])), int(upper[k] / cell[k]) + 1):
                draw(line * cell[k], color="0.85", linewidth=0.4, zorder=0)
    axes_of[0].set_ylabel("y [m]")
    return figure


def stack(name: str, pictures: list[np.ndarray]) -> None:
    """Stores pictures one above the other."""
    width = max(picture.shape[1] for picture in pictures)
    whole = [
        np.pad(p, ((0, 0), (0, width - p.shape[1]), (0, 0)), constant_values=255) for p in pictures
    ]
    imsave(EXAMPLES / name / "picture.png", np.concatenate(whole))


def draw_field(name: str, field: str) -> None:
    """A field at the start above the displacement at the end, from two figures of the report."""
    model = tilth.load_case(EXAMPLES / name / "case.toml")
    with tempfile.TemporaryDirectory() as folder:
        result = tilth.run(model, Path(folder) / "results", quiet=True)
        results = read_results(result.folder / "results.vtkhdf")
        pictures = []
        for index, colour_by in ((0, field), (-1, model.output.colour_by)):
            figure = draw_frames([results.snapshot(index)], colour_by, results.units)
            canvas = FigureCanvasAgg(figure)
            canvas.draw()
            pictures.append(np.asarray(canvas.buffer_rgba()))
    stack(name, pictures)


def draw_mechanism(name: str) -> None:
    """The picture that `tilth safety` draws, with a narrow bracket of the factor."""
    model = tilth.load_case(EXAMPLES / name / "case.toml")
    with tempfile.TemporaryDirectory() as folder:
        settings = tilth.StrengthReduction(tolerance=0.002)
        tilth.safety(model, Path(folder) / "results", settings=settings, quiet=True)
        shutil.copy(Path(folder) / "results" / "safety.png", EXAMPLES / name / "picture.png")


def von_mises_stress(points):
    xx, yy, zz, xy, yz, xz = points.stress.T
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.sqrt(0.5 * normal + 3.0 * (xy**2 + yz**2 + xz**2))


def outlines(points):
    """The domains' corners around each point; the boxes of GIMP and of the linear basis."""
    if points.ranges[0].has_corners:
        return points.position[:, None] + points.corner[:, [0, 1, 3, 2]]
    around = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return points.position[:, None] + points.half_length[:, None] * around


def draw_bases(name: str, file: str, steps: int) -> None:
    """The domains after some steps with each basis, coloured by stress over the exact one."""
    model = tilth.load_case(EXAMPLES / name / file)
    time = steps / model.schedule.steps
    short = {
        "boundaries.0.factor": [[0.0, 0.0], [1.0, time * model.boundaries[0].factor[-1][1]]],
        "schedule.steps": steps,
    }
    exact = march(varied(model, {**short, "boundaries.0.nodes": "all"})).state.points
    figure = Figure(figsize=(10.4, 4.4), layout="constrained")
    axes_of = figure.subplots(2, 2, sharex=True, sharey=True)
    for axes, (basis, rule) in zip(axes_of.flat, RULES, strict=True):
        body = {"bodies.0.basis": basis, "bodies.0.domain_update": rule}
        points = march(varied(model, {**short, **body})).state.points
        ratio = von_mises_stress(points) / von_mises_stress(exact)[0]
        if basis == "linear":
            drawn = axes.scatter(*points.position.T, c=ratio, s=14.0)
        else:
            drawn = axes.add_collection(PolyCollection(outlines(points), array=ratio))
            drawn.set(edgecolor="black", linewidth=0.25)
        drawn.set(cmap="coolwarm", clim=(0.5, 1.5))
        axes.set_aspect("equal")
        axes.set_title(f"{basis}, {rule}" if rule else basis, fontsize=9)
    for axes in axes_of[1]:
        axes.set_xlabel("x [m]")
    for axes in axes_of[:, 0]:
        axes.set_ylabel("y [m]")
    axes_of[0, 0].margins(0.03)
    figure.colorbar(
        drawn, ax=axes_of, extend="both", label="von Mises stress over the exact one [-]"
    )
    figure.savefig(EXAMPLES / name / "picture.png", dpi=110)


def draw_trough(name: str, sizes: tuple[float, ...]) -> None:
    """The surface on some grids and the closed form, above the displacement at the end."""
    model = tilth.load_case(EXAMPLES / name / "case.toml")
    figure = Figure(figsize=(8.2, 3.2), layout="constrained")
    axes = figure.subplots()
    for size, style in zip(sizes, ("o", "."), strict=True):
        found = settle(varied(model, {"grid.cell_size": size}))
        axes.plot(found.x, 1e3 * found.settlement, style, markersize=4, label=f"cells of {size} m")
    axes.plot(found.x, 1e3 * found.sink.settlement(found.x), "k", linewidth=1, label="closed form")
    axes.invert_yaxis()
    axes.set_xlabel("distance from the axis [m]")
    axes.set_ylabel("settlement of the surface [mm]")
    axes.legend(frameon=False)
    canvas = FigureCanvasAgg(figure)
    figure.set_dpi(110)
    canvas.draw()
    pictures = [np.asarray(canvas.buffer_rgba())]
    with tempfile.TemporaryDirectory() as folder:
        result = tilth.run(model, Path(folder) / "results", quiet=True)
        results = read_results(result.folder / "results.vtkhdf")
        last = [results.snapshot(len(results) - 1)]
        canvas = FigureCanvasAgg(draw_frames(last, model.output.colour_by, results.units))
        canvas.draw()
        pictures.append(np.asarray(canvas.buffer_rgba()))
    stack(name, pictures)


def draw_shear(name: str) -> None:
    """Shear under a cylinder that is pressed and drawn, means about nodes, and the closed form."""
    model = tilth.load_case(EXAMPLES / name / "cattaneo.toml")
    run = run_contact(model)
    across, down = run.force["cylinder"][-1]
    contact, middle = (
        normal_contact(model),
        model.rigid_bodies[0].centre[0] + run.displacement[-1, 0],
    )
    width, unit = contact.half_width(-down), FRICTION * contact.peak_pressure(-down)
    x = np.linspace(-1.2, 1.2, 2000)
    limit = FRICTION * contact.pressure(x * width, -down)
    law = Cattaneo(contact, FRICTION).shear(x * width, -down, across)
    means = tractions(model, run).about_nodes(model.cell_size[0])
    place = (means.place - middle) / width
    near = np.abs(place) < x.max()
    figure = Figure(figsize=(7.6, 3.6), layout="constrained")
    axes = figure.subplots()
    axes.plot(x, limit / unit, color="0.6", linewidth=1, label="friction times Hertz's pressure")
    axes.plot(x, law / unit, "k", linewidth=1, label="Cattaneo")
    axes.plot(place[near], means.expected[near] / unit, "k_", label="its means about nodes")
    axes.plot(
        place[near], means.shear[near] / unit, "o", color="#1d3557", markersize=4, label="shear"
    )
    axes.set_xlabel("x / a")
    axes.set_ylabel("shear over friction times p0")
    axes.legend(frameon=False, fontsize=8)
    figure.savefig(EXAMPLES / name / "cattaneo.png", dpi=110)


def draw_histories(name: str) -> None:
    """Tracked quantities over time: of the bar with its energies, of columns with d'Alembert's."""
    files = ("case.toml",) if name == "elastic_bar" else ("case.toml", "rigid.toml")
    figure = Figure(figsize=(8.2, 3.0 * max(len(files), 1)), layout="constrained")
    axes_of = figure.subplots(len(files), 1, squeeze=False)[:, 0]
    for axes, file in zip(axes_of, files, strict=True):
        model = tilth.load_case(EXAMPLES / name / file)
        with tempfile.TemporaryDirectory() as folder:
            quiet = varied(model, {"output.report": False})
            found = tilth.run(quiet, Path(folder) / "results", quiet=True).history
        time = found["time"]
        if name == "elastic_bar":
            axes.plot(1e3 * time, 1e9 * found["tip [m]"], color="#1d3557", label="free end [nm]")
            total = found["kinetic [N m/m]"][0]
            for kind, colour in (("kinetic", "#c1121f"), ("elastic", "#2a6f4e")):
                share = 100.0 * found[f"{kind} [N m/m]"] / total
                axes.plot(1e3 * time, share, color=colour, linewidth=0.8, label=f"{kind} [%]")
            axes.set_xlabel("time [ms]")
        else:
            exact = closed_form(file, time)
            axes.plot(time, exact, "k", linewidth=2.5, alpha=0.35, label="top, d'Alembert")
            for column, colour in (("top", "#c1121f"), ("bottom", "#118ab2")):
                axes.plot(time, found[f"{column} [m/s^2]"], color=colour, lw=1.0, label=column)
            axes.set_title(model.title, fontsize=9)
            axes.set_xlabel("time [s]")
            axes.set_ylabel("acceleration [m/s^2]")
        axes.grid(color="0.9", linewidth=0.6)
        axes.legend(fontsize=8, loc="upper right")
    figure.savefig(EXAMPLES / name / "picture.png", dpi=110)


def draw_isochrones(name: str) -> None:
    """The excess pressure of the points along an axis, and the reference, at some times."""
    reference, axis, times = ISOCHRONES[name]
    model = tilth.load_case(EXAMPLES / name / "case.toml")
    profiles, history = {}, []

    def after_step(simulation, result, time):
        points = simulation.state.points
        pressure = points.water[:, PRESSURE]
        history.append((time, pressure.max(), 1.0 - points.volume.sum() / whole))
        for each in times:
            if abs(time - each) < 1e-6 * times[-1]:
                place = points.position
                place = np.linalg.norm(place, axis=1) if axis is None else place[:, axis].copy()
                profiles[each] = place, pressure.copy()

    whole = initial_points(model).initial_volume.sum()
    march(model, after_step)
    figure = Figure(figsize=(8.6, 3.8), layout="constrained")
    along, over = figure.subplots(1, 2)
    units, colours = model.units, ("#1d3557", "#118ab2", "#2a6f4e", "#e09f3e", "#c1121f")
    for time, colour in zip(times, colours, strict=True):
        place, value = reference(model, time)
        found, pressure = profiles[time]
        lines = (value, place, pressure, found) if axis == 1 else (place, value, found, pressure)
        along.plot(*lines[:2], color=colour, linewidth=1.0)
        along.plot(*lines[2:], "o", color=colour, markersize=3.5, label=f"{time:g} {units.time}")
    way = "distance from the centre" if axis is None else "xyz"[axis]
    names = f"{way} [{units.length}]", f"excess pore pressure [{units.stress}]"
    along.set(xlabel=names[axis == 1], ylabel=names[axis != 1])
    along.set_title("points, and reference as lines", fontsize=9)
    along.legend(fontsize=8, frameon=False)
    time, highest, lost = np.array(history).T
    over.plot(time, highest, color="#c1121f")
    over.set(xlabel=f"time [{units.time}]", ylabel=f"greatest excess pressure [{units.stress}]")
    over.yaxis.label.set_color("#c1121f")
    other = over.twinx()
    other.plot(time, 100.0 * lost, color="#1d3557")
    if name == "radial_drain":
        barron = 100.0 * radial_drain.equal_strain(model, time)
        other.plot(
            time, barron, "--", color="#1d3557", linewidth=1.0, label="equal strain (Barron)"
        )
        other.legend(fontsize=8, frameon=False, loc="center right")
    other.set_ylabel("water that has left over the volume [%]", color="#1d3557")
    for axes in (along, over):
        axes.grid(color="0.9", linewidth=0.6)
    figure.savefig(EXAMPLES / name / "picture.png", dpi=110)


def draw_element_tests(name: str) -> None:
    """The first picture that each case file of element tests declares."""
    for file in sorted((EXAMPLES / name).glob("*.toml")):
        case = tilth.load_element_case(file)
        plot = case.plots[0]
        chosen = [each for each in tilth.element(case) if each.test in (plot.tests or [each.test])]
        picture = "picture.png" if file.stem == "case" else f"{file.stem}.png"
        draw_plot(plot, chosen, case.title).savefig(EXAMPLES / name / picture, dpi=110)


if __name__ == "__main__":
    folders = sorted(case.parent.name for case in EXAMPLES.glob("*/case.toml"))
    for name in sys.argv[1:] or folders:
        if name in SURFACES:
            draw_surfaces(name, SURFACES[name])
        elif name in FIELDS:
            draw_field(name, FIELDS[name])
        elif name in BASES:
            draw_bases(name, *BASES[name])
        elif name in SAFETY:
            draw_mechanism(name)
        elif name in TROUGHS:
            draw_trough(name, TROUGHS[name])
        elif name in HISTORIES:
            draw_histories(name)
        elif name in ISOCHRONES:
            draw_isochrones(name)
        elif name == "element_tests":
            draw_element_tests(name)
        else:
            make_picture(name)
            if name == "hertz":
                draw_shear(name)
            if name == "strip_footing":
                make_picture(name, "graded", "graded")
