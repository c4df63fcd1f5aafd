# SPDX-License-Identifier: BSD-3-Clause
"""Texts of the user in figures: drawn as they are, on lines of limited length."""

from __future__ import annotations

import textwrap
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tilth.report.handles import Handle

AS_IT_IS: dict[str, Any] = {"parse_math": False, "usetex": False}
"""Options of every text that holds words of the user: $, \\ and _ have no meaning there."""
LEGEND_WIDTH, LABEL_WIDTH = 40, 48
"""Characters of a line in a legend and beside an axis, at most."""


def on_lines(text: str, width: int) -> str:
    """Returns ``text`` with line breaks, so that no line has more than ``width`` characters."""
    lines = [textwrap.wrap(part, width) or [part] for part in text.split("\n")]
    return "\n".join(line for part in lines for line in part)


def add_legend(figure: Figure, handles: Sequence[Handle], **style: Any) -> None:
    """Adds a legend of ``handles`` with their labels, also those that begin with an underscore."""
    own = [handle.matplotlib() for handle in handles]
    legend = figure.legend(handles=own, labels=["-"] * len(handles), **style)
    for text, handle in zip(legend.get_texts(), handles, strict=True):
        text.set(text=on_lines(handle.label, LEGEND_WIDTH), **AS_IT_IS)


@contextmanager
def any_characters() -> Iterator[None]:
    """While a figure is laid out or drawn: a character without a glyph is a box, no warning."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
        warnings.filterwarnings("ignore", "Matplotlib currently does not support", UserWarning)
        yield


def save(figure: Figure, to: Any, **options: Any) -> None:
    """Draws the figure into a file, by its path or open for writing; options as `savefig`."""
    with any_characters():
        figure.savefig(to, **options)
