# SPDX-License-Identifier: BSD-3-Clause
"""Writing figures into files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tilth.errors import BadInput
from tilth.output.disk import asked_to_save
from tilth.output.files import written_whole
from tilth.report.texts import save

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("svg", "png", "pdf")
RESOLUTION = 300
"""Of pixels in files [pixels per inch]."""


def require_format(path: Path) -> None:
    """Raises ``BadInput`` if a picture's name ends otherwise, or its folder does not exist."""
    require_ending(path, FORMATS, "pictures")


def require_ending(path: Path, formats: Sequence[str], what: str) -> None:
    """Raises ``BadInput`` if a name has none of some endings, or its folder does not exist."""
    if path.suffix.lower().removeprefix(".") not in formats:
        known = ", ".join(f".{each}" for each in formats)
        raise BadInput(
            f"is no format of {what} that can be written",
            f"let the name end with one of {known}",
            key="save",
            value=str(path),
        )
    if not path.parent.is_dir():
        raise BadInput(
            "its folder does not exist", "make the folder first", key="save", value=str(path)
        )


def save_figure(figure: Figure, path: Path) -> None:
    """Writes a figure; texts of SVG and PDF stay texts.

    Raises:
        BadInput: the name of the file does not say a format, or it cannot be written there.
        AnalysisFailed: the disk is full, or cannot be written for another reason of its own. An
            earlier file stays as it is then, and no part of the new one is left.
    """
    from matplotlib import rc_context

    require_format(path)
    kept: Any = {"svg.fonttype": "none", "pdf.fonttype": 42}
    with rc_context(kept), asked_to_save(path), written_whole(path) as new:
        cut = figure.get_layout_engine() is None  # by `layout.fit`, to what is drawn
        save(figure, new, dpi=RESOLUTION, **({} if cut else {"bbox_inches": "tight"}))
