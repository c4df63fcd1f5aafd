# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of element tests: several tests and materials in the usual diagrams."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.arrays import Floats
from tilth.element_tests.result import ElementResult
from tilth.model import ElementPlot
from tilth.model.laws import EXCESS_PORE_PRESSURE
from tilth.report.texts import AS_IT_IS, LEGEND_WIDTH, on_lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = ("#1d3557", "#c1121f", "#2a6f4e", "#c9a66b", "#6d4c91", "#4895b5", "#8a5a2b", "#555555")
_DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.5)), (0, (5, 2, 1, 2)))
_WORDS = {
    "p": "mean effective stress p",
    "q": "deviatoric stress q",
    "axial_strain": "axial strain",
    "shear_strain": "shear strain",
    "stress_xy": "shear stress",
    "volumetric_strain": "volumetric strain",
    "void_ratio": "void ratio e",
    EXCESS_PORE_PRESSURE: "excess pore pressure",
}


def draw_plot(plot: ElementPlot, results: Sequence[ElementResult], title: str = "") -> Figure:
    """Returns the figure of a declared picture with one curve for each result.

    There is a colour for each test and a dash for each material, or the other way round if there
    are more materials than tests. Compression is positive.
    """
    from matplotlib.figure import Figure

    columns = min(2, len(plot.panels))
    rows = -(-len(plot.panels) // columns)
    height = 3.3 * rows + 0.22 * len(results) + (0.3 if title else 0.0)
    figure = Figure(figsize=(4.7 * columns, height), layout="constrained")
    panels = [figure.add_subplot(rows, columns, n + 1) for n in range(len(plot.panels))]
    for panel, axes in zip(plot.panels, panels, strict=True):
        _draw_panel(axes, panel, results)
    if title:
        figure.suptitle(title, fontsize=11, **AS_IT_IS)
    handles = panels[0].get_lines()[: len(results)]
    names = [on_lines(f"{each.test}, {each.material}", LEGEND_WIDTH) for each in results]
    legend = figure.legend(
        handles=handles, labels=["-"] * len(handles), loc="outside lower center", ncols=2,
        fontsize=8, frameon=False,
    )  # fmt: skip
    for text, name in zip(legend.get_texts(), names, strict=True):
        text.set(text=name, **AS_IT_IS)
    return figure


def _draw_panel(axes: Axes, panel: str, results: Sequence[ElementResult]) -> None:
    tests = list(dict.fromkeys(result.test for result in results))
    materials = list(dict.fromkeys(result.material for result in results))
    turned = len(materials) > len(tests)
    with_void_ratio = all("void_ratio" in result.columns for result in results)
    volume = "void_ratio" if with_void_ratio else "volumetric_strain"
    labels: list[list[str]] = [[], []]
    for result in results:
        curve = _curve(panel, result, volume)
        x, y, names = ([np.nan], [np.nan], ("", "")) if curve is None else curve
        numbers = tests.index(result.test), materials.index(result.material)
        colour, dash = reversed(numbers) if turned else numbers
        axes.plot(
            x, y, linewidth=1.4, color=_COLOURS[colour % len(_COLOURS)],
            linestyle=_DASHES[dash % len(_DASHES)],
        )  # fmt: skip
        for label, name in zip(labels, names, strict=True):
            if name and _label(name, result) not in label:
                label.append(_label(name, result))
    axes.set_xlabel(" / ".join(labels[0]), fontsize=9, **AS_IT_IS)
    axes.set_ylabel(" / ".join(labels[1]), fontsize=9, **AS_IT_IS)
    if panel == "compression" and labels[0]:
        axes.set_xscale("log")
    if panel == "volume-strain" or (panel == "compression" and not with_void_ratio):
        axes.invert_yaxis()
    axes.tick_params(labelsize=8)
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)


def _curve(
    panel: str, result: ElementResult, volume: str
) -> tuple[Floats, Floats, tuple[str, str]] | None:
    """Returns the numbers of a curve and the names of their columns; None if there is none.

    volume: the column that the diagram "compression" has.
    """
    shear = "shear_strain" in result.columns
    strain = "shear_strain" if shear else "axial_strain"
    x, y = {
        "p-q": ("p", "q"),
        "q-strain": (strain, "stress_xy" if shear else "q"),
        "volume-strain": (strain, "volumetric_strain"),
        "pressure-strain": (strain, EXCESS_PORE_PRESSURE),
        "compression": ("p", volume),
    }[panel]
    if y not in result.columns:
        return None
    shown = result["p"] > 0.0 if panel == "compression" else np.full(len(result["p"]), True)
    return (result[x][shown], result[y][shown], (x, y)) if shown.any() else None


def _label(name: str, result: ElementResult) -> str:
    return f"{_WORDS[name]} [{result.units[name]}]"
