# SPDX-License-Identifier: BSD-3-Clause
"""A figure of a field at one output that can be drawn again with another one, for movies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.output.snapshot import Snapshot
from tilth.plot.layout import Layout, fit, span_in_space
from tilth.plot.run import PlottedRun
from tilth.plot.views import Limits, View, around
from tilth.report.colour_scale import ColourScale
from tilth.report.fields import field_values
from tilth.report.handles import Handle
from tilth.report.texts import AS_IT_IS, add_legend, any_characters, on_lines

_GREY = "grey: no value for this soil"


@dataclass(frozen=True, eq=False)
class Scene:
    """What several outputs have in common in their pictures."""

    limits: Limits
    scale: ColourScale
    label: str
    """Name of the field with its unit."""
    handles: Sequence[Handle]
    """Entries of the legend."""
    title: str
    """The longest one."""
    gaps: bool
    """Whether some soil has no value of the field."""

    @classmethod
    def of(
        cls,
        run: PlottedRun,
        view: View,
        field: str,
        outputs: Sequence[int],
        scale: ColourScale | None = None,
    ) -> Scene:
        """Returns what outputs, by their numbers, have in common; raises ``BadInput``.

        scale: of the colours; None for that of all values.
        """
        limits: list[Limits] = []
        ranges: list[Floats] = []
        titles: list[str] = []
        ends: dict[int, Snapshot] = {}
        label, gaps = "", False
        for index in outputs:
            snapshot = run.results.snapshot(index)
            values, label = field_values(snapshot, field, run.results.units)
            known = values[np.isfinite(values)]
            gaps |= len(known) < len(values)
            if len(known):
                ranges.append(np.array([known.min(), known.max()]))
            if (own := view.limits(snapshot)) is not None:
                limits.append(own)
            titles.append(_title(run, view, snapshot))
            if index in (outputs[0], outputs[-1]):
                ends[index] = snapshot
        if not limits:
            raise view.nothing(ends[outputs[-1]])
        common = around(limits)
        handles: dict[str, Handle] = {}
        for snapshot in ends.values():
            handles |= {handle.label: handle for handle in view.handles(snapshot, common)}
        scale = ColourScale.of(ranges) if scale is None else scale
        title = max(titles, key=len)
        return cls(common, scale, label, list(handles.values()), title, gaps)


class FieldPicture:
    """The figure of a field; its axes, colours and sizes do not change from output to output."""

    def __init__(self, run: PlottedRun, view: View, field: str, scene: Scene, strip: bool = False):
        """``strip``: whether there are axes below for a curve, `strip`."""
        from matplotlib.figure import Figure

        self._run, self._view, self._field, self._scene = run, view, field, scene
        low, high = scene.limits
        self._layout = Layout.of(high - low)
        self._mappable = scene.scale.matplotlib()
        self.figure = Figure(figsize=(12.0, 12.0))
        self.figure.set_layout_engine("none")
        boxes = self._layout.boxes(self._note, strip)
        kind: Any = {"projection": "3d"} if len(low) == 3 else {}
        self.axes: Any = self.figure.add_axes(boxes["field"], **kind)
        self.strip: Any = self.figure.add_axes(boxes["strip"]) if strip else None
        below = self._layout.bar_below
        bar: Any = self.figure.colorbar(
            self._mappable,
            cax=self.figure.add_axes(boxes["bar"]),
            orientation="horizontal" if below else "vertical",
        )
        bar.set_label(on_lines(scene.label, self._layout.label_width), fontsize=9, **AS_IT_IS)
        bar.ax.tick_params(labelsize=8)
        for axis in (bar.ax.xaxis, bar.ax.yaxis):
            axis.get_offset_text().set_fontsize(8)
        bar.formatter.set_powerlimits((-3, 4))
        self._bar: Any = bar.ax
        self._top = 1.0
        """Where the title is, over the height of the axes."""
        self._add_legend()

    @property
    def _note(self) -> str:
        notes = [self._layout.note] if self._layout.note else []
        return "; ".join([*notes, *([_GREY] if self._scene.gaps else [])])

    def draw(self, snapshot: Snapshot, scale: ColourScale | None = None) -> None:
        """Draws an output in place of what is there; ``scale``: other colours."""
        values = field_values(snapshot, self._field, self._run.results.units)[0]
        if scale is not None:
            self._mappable.set_cmap(scale.matplotlib().get_cmap())
            self._mappable.set_clim(scale.low, scale.high)
        self.axes.clear()
        self._view.draw(self.axes, snapshot, values, self._mappable.to_rgba, self._scene.limits)
        if len(self._scene.limits[0]) == 2:
            self._finish_plane()
        self._set_title(_title(self._run, self._view, snapshot))

    def finish(self) -> None:
        """Cuts the figure to what is drawn, with room for the longest title."""
        shown = self.axes.get_title()
        with any_characters():
            if len(self._scene.limits[0]) == 3:
                self._fill_height(*span_in_space(self.axes))
            self._set_title(self._scene.title)
            fit(self.figure)
        self._set_title(shown)

    def _fill_height(self, low: float, high: float) -> None:
        """Moves legend and title to the upper end of what is seen of space; the bar beside it."""
        self._top = high
        box, bar = self.axes.get_position().bounds, self._bar.get_position().bounds
        self._bar.set_position((bar[0], box[1] + low * box[3], bar[2], (high - low) * box[3]))
        for legend in self.figure.legends:
            legend.set_bbox_to_anchor((0.5, self._above_title), self.axes.transAxes)

    @property
    def _above_title(self) -> float:
        """Height of the lower end of the legend, over that of the axes."""
        lines = on_lines(self._scene.title, self._layout.title_width).count("\n") + 1
        return self._top + (0.12 + 0.16 * lines) / self._layout.size[1]

    def _set_title(self, text: str) -> None:
        own = on_lines(text.replace("\n", " "), self._layout.title_width)
        self.axes.set_title(own, y=self._top, fontsize=9, **AS_IT_IS)
        self.axes.title.set_y(self._top)  # `set_title` lowers it in space

    def _finish_plane(self) -> None:
        axes, layout = self.axes, self._layout
        low, high = self._scene.limits
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        axes.set_aspect("auto")  # the sizes of the axes are to scale, but for a stated stretch
        across, up = self._view.labels
        axes.set_xlabel(f"{across}\n{self._note}".strip(), fontsize=9, **AS_IT_IS)
        axes.set_ylabel(up, fontsize=9, **AS_IT_IS)
        axes.tick_params(labelsize=8)
        axes.locator_params(axis="x", nbins=layout.ticks[0])
        axes.locator_params(axis="y", nbins=layout.ticks[1])

    def _add_legend(self) -> None:
        """Puts the legend above the title, outside of the axes."""
        if not self._scene.handles:
            return
        add_legend(
            self.figure,
            self._scene.handles,
            loc="lower center",
            bbox_to_anchor=(0.5, self._above_title),
            bbox_transform=self.axes.transAxes,
            ncols=self._layout.columns([handle.label for handle in self._scene.handles]),
            fontsize=8,
            frameon=False,
            handlelength=2.2,
            borderaxespad=0.0,
            borderpad=0.1,
        )


def _title(run: PlottedRun, view: View, snapshot: Snapshot) -> str:
    return ", ".join(part for part in (view.title, run.title(snapshot)) if part)
