# SPDX-License-Identifier: BSD-3-Clause
"""Makes the figures of docs/figures: `python docs/generate_figures.py [NUMBER]...`.

The problems of C.E. Augarde et al., Issues with the Material Point Method for geotechnical
modelling, and how to address them, NUMGE 2018, from runs of the examples; the numbers are those of
the paper's figures. Without numbers it makes all of them, which takes about ten minutes, most of
it for figures 8 and 9: two runs of 125,000 material points, 200 steps each.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

import tilth
from tilth.output.vtkhdf import Results, read_results
from tilth.report.colour_scale import ColourScale
from tilth.report.field_plots import draw_plane
from tilth.report.fields import field_values
from tilth_verification.cases import varied
from tilth_verification.reference import rigid_footing_elastic, square_footing
from tilth_verification.rigid_footing_elastic import press

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples"
FIGURES = ROOT / "docs" / "figures"
sys.path.insert(0, str(EXAMPLES))

from make_pictures import surface_figure  # noqa: E402

SOIL, REFERENCE = "#1d3557", "#c1121f"
RUNS = tempfile.TemporaryDirectory()


def run(
    name: str, file: str, changes: dict[str, Any] | None = None
) -> tuple[tilth.Model, tilth.Result, Results]:
    """Runs a case of an example in a folder that is removed at the end."""
    changes = {"output.report": False, **(changes or {})}
    model = varied(tilth.load_case(EXAMPLES / name / file), changes)
    folder = Path(RUNS.name) / name / file
    result = tilth.run(model, folder, quiet=True)
    return model, result, read_results(folder / "results.vtkhdf")


def draw_grid(axes: Axes, model: tilth.Model) -> None:
    """Draws the grid's lines over what the axes show."""
    origin = np.array(model.grid.origin or (0.0, 0.0))
    cell = np.array(model.cell_size)
    for k, (low, high) in enumerate((axes.get_xlim(), axes.get_ylim())):
        first, last = np.ceil((low - origin[k]) / cell[k]), np.floor((high - origin[k]) / cell[k])
        draw = (axes.axvline, axes.axhline)[k]
        for line in origin[k] + cell[k] * np.arange(first, last + 1):
            draw(line, color="black", alpha=0.35, linewidth=0.3, zorder=3)


def draw_field(axes: Axes, results: Results, index: int, field: str, scale: ColourScale) -> str:
    """Draws a field over the soil; returns its name with the unit."""
    snapshot = results.snapshot(index)
    values, label = field_values(snapshot, field, results.units)
    draw_plane(axes, snapshot, values, scale.matplotlib().to_rgba, "field")
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    return label


def slope() -> Figure:
    """Figure 1: one slope on two grids, and the loads of both."""
    figure = Figure(figsize=(9.6, 5.6), layout="constrained")
    panels = figure.subplots(2, 2, height_ratios=[3.0, 2.0])
    curve = figure.add_subplot(panels[1, 0].get_gridspec()[1, :])
    for axes in panels[1]:
        axes.remove()
    scale = ColourScale(0.0, 0.3, "viridis")
    coarse = {"bodies.0.spacing": 0.125}
    kinds = (
        ("aligned.toml", "sides and base on grid lines", {"grid.cell_size": 0.25}),
        (
            "case.toml",
            "sides and base off the grid lines",
            {"grid.cell_size": [0.256, 0.24], "grid.origin": [1.0, -0.125]},
        ),
    )
    for axes, (file, title, grid), style in zip(panels[0], kinds, ("-", "--"), strict=True):
        model, result, results = run("slope", file, {**coarse, **grid})
        label = draw_field(axes, results, len(results) - 1, "displacement", scale)
        axes.set(xlim=(-0.3, 8.3), ylim=(-0.4, 5.3))
        axes.add_patch(_rectangle((0.0, 4.7), 1.0, 0.3))
        draw_grid(axes, model)
        axes.set_title(title, fontsize=9)
        load = 1e-3 * result.history["footing load [N/m]"]
        curve.plot(0.3 * result.history["time"], load, style, color=SOIL, label=title)
    figure.colorbar(scale.matplotlib(), ax=list(panels[0]), label=label)
    curve.set(xlabel="settlement [m]", ylabel="load of half the footing [kN/m]")
    curve.set(xlim=(0.0, 0.3), ylim=(0.0, None))
    curve.legend(frameon=False)
    return figure


def moving_footing() -> Figure:
    """Figure 4: a rigid block that moves through the grid, and its force."""
    figure = Figure(figsize=(10.4, 3.6), layout="constrained")
    panels = figure.subplots(1, 3)
    model, result, results = run("rigid_footing_elastic", "case.toml")
    scale = ColourScale(0.0, 1.0, "viridis")
    for axes, time in zip(panels[:2], (0.4, 1.0), strict=True):
        index = int(np.abs(np.array(results.times) - time).argmin())
        label = draw_field(axes, results, index, "displacement", scale)
        axes.set(xlim=(-0.1, 3.1), ylim=(-0.1, 4.0))
        lower = (0.0, 3.0 - time)
        axes.add_patch(_rectangle(lower, 1.0, 3.95 - lower[1]))
        draw_grid(axes, model)
        axes.set_title(f"settlement {time:g} m", fontsize=9)
    figure.colorbar(scale.matplotlib(), ax=list(panels[:2]), label=label, shrink=0.8)
    curve = panels[2]
    modulus = model.materials["soil"].parameter("young_modulus")
    force = result.history["footing force [N/m]"] / modulus
    curve.plot(result.history["time"], force, color=SOIL, label="block, cells of 0.1 m")
    narrowing = tilth.load_case(EXAMPLES / "rigid_footing_elastic" / "narrowing.toml")
    settlement, force, _ = press(narrowing, 0.05, 0.3)
    curve.plot(settlement, force, "o", color=SOIL, ms=3, label="face as narrow as the reference's")
    exact = rigid_footing_elastic()
    curve.plot(exact.settlement, exact.force, color=REFERENCE, label="finite elements")
    curve.set(xlabel="settlement [m]", ylabel="force of half the footing over E [m]")
    curve.set(xlim=(0.0, 1.0), ylim=(0.0, None))
    curve.legend(frameon=False, fontsize=8)
    return figure


def _rectangle(lower: tuple[float, float], width: float, height: float) -> Rectangle:
    return Rectangle(lower, width, height, facecolor="0.6", edgecolor="black", zorder=4)


def _beam(modulus: float) -> tilth.Model:
    """The beam under pressure on fine cells, with Young's modulus [Pa]."""
    model = tilth.load_case(EXAMPLES / "pressure_cantilever" / "fine.toml")
    return varied(model, {"materials.rubber.young_modulus": modulus})


def cantilever() -> Figure:
    """Figure 6: the surface that carries a pressure, on the paper's grid and on a fine one."""
    case = tilth.load_case(EXAMPLES / "pressure_cantilever" / "case.toml")
    return surface_figure([case, _beam(1e6)])


def softer_cantilevers() -> Figure:
    """Figure 7: the same beam, stiff, softer and softest."""
    return surface_figure([_beam(modulus) for modulus in (1e6, 5e5, 2.5e5)])


def square_footings() -> tuple[Figure, Figure]:
    """Figures 8 and 9: load and stress under a square footing, with and without F-bar."""
    curves = Figure(figsize=(6.4, 4.0), layout="constrained")
    axes = curves.subplots()
    stresses = Figure(figsize=(9.2, 4.2), layout="constrained")
    panels = stresses.subplots(1, 2, sharey=True)
    scale = ColourScale(-8.0, 8.0, "coolwarm")
    kinds = (("case.toml", "with F-bar"), ("standard.toml", "without F-bar"))
    for panel, (file, title), style in zip(panels, kinds, ("-", "--"), strict=True):
        model, result, results = run("square_footing", file)
        strength = model.materials["clay"].parameter("yield_stress") / np.sqrt(3.0)
        pressure = result.history["footing load [N]"] / (0.25 * strength)
        axes.plot(2.0 * result.history["time"], pressure, style, color=SOIL, label=title)
        snapshot = results.snapshot(len(results) - 1)
        start = np.round(snapshot.position - snapshot.point_fields["displacement"], 6)
        layer = start[:, 1] < start[:, 1].min() + 1e-6
        xx, yy, zz, xy, yz, xz = snapshot.point_fields["cauchy_stress"][layer].T
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
        minor = np.linalg.eigvalsh(tensor)[:, 0] / strength
        x, z = start[layer][:, 0], start[layer][:, 2]
        order, side = np.lexsort((x, z)), len(np.unique(x))
        panel.pcolormesh(
            *(v[order].reshape(-1, side) for v in (x, z, minor)),
            cmap=scale.name,
            vmin=scale.low,
            vmax=scale.high,
            shading="nearest",
        )
        panel.plot([0.0, 0.5], [5.0, 5.0], color="black", linewidth=4, solid_capstyle="butt")
        panel.set(xlim=(0.0, 2.0), ylim=(3.0, 5.02), aspect="equal", xlabel="x [m]", title=title)
    panels[0].set_ylabel("z [m]")
    bar = stresses.colorbar(scale.matplotlib(), ax=list(panels), extend="both")
    bar.set_label("minor principal stress / c [-]")
    for label, name, colour in (
        ("B-bar elements of 0.25 m", "b_bar", REFERENCE),
        ("standard elements of 0.25 m", "standard", "0.5"),
    ):
        exact = square_footing(0.5, 0.25, name)
        axes.plot(1e3 * exact.settlement, exact.pressure, color=colour, linewidth=1, label=label)
    axes.axhline(5.25, color="black", linewidth=0.6, linestyle=":")
    axes.text(1.98, 5.3, "limit of graded B-bar elements, 5.25", fontsize=7, ha="right")
    axes.set(xlabel="settlement [mm]", ylabel="mean pressure / c [-]", xlim=(0.0, 2.0))
    axes.set_ylim(0.0, None)
    axes.legend(frameon=False, fontsize=8)
    return curves, stresses


MAKERS: dict[tuple[str, ...], Callable[[], Figure | tuple[Figure, ...]]] = {
    ("figure_1.png",): slope,
    ("figure_4.png",): moving_footing,
    ("figure_6.png",): cantilever,
    ("figure_7.png",): softer_cantilevers,
    ("figure_8.png", "figure_9.png"): square_footings,
}


def main() -> None:
    """Writes the figures with the numbers given, all without."""
    chosen = {f"figure_{number}.png" for number in sys.argv[1:]}
    for names, make in MAKERS.items():
        if chosen and not chosen & set(names):
            continue
        made = make()
        figures = made if isinstance(made, tuple) else (made,)
        for name, figure in zip(names, figures, strict=True):
            figure.savefig(FIGURES / name, dpi=130)


if __name__ == "__main__":
    with RUNS:
        main()
