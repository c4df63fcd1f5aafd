# SPDX-License-Identifier: BSD-3-Clause
"""Makes the pictures of the README and of the how-to about pictures, in docs/gallery.

`python docs/generate_picture.py` runs the example `collapse`; with the folder of such a run, it
draws from that.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import tilth
from tilth.output import read_results
from tilth.plot.field import field_figure
from tilth.plot.movie import write_movie
from tilth.report.field_plots import draw_frames

ROOT = Path(__file__).parents[1]
GALLERY = ROOT / "docs" / "gallery"
FIELD = "plastic_strain"
TIMES = (0.75, 1.0)


def main() -> None:
    """Writes the pictures."""
    if len(sys.argv) > 1:
        draw(Path(sys.argv[1]))
        return
    model = tilth.load_case(ROOT / "examples" / "collapse" / "case.toml")
    with tempfile.TemporaryDirectory() as folder:
        draw(tilth.run(model, folder).folder)


def draw(folder: Path) -> None:
    """Draws from the results of the example in a folder."""
    results = read_results(folder / "results.vtkhdf")
    chosen = [int(np.abs(np.array(results.times) - time).argmin()) for time in TIMES]
    snapshots = [results.snapshot(index) for index in chosen]
    draw_frames(snapshots, FIELD, results.units).savefig(GALLERY / "collapse.png", dpi=100)
    field_figure(folder, FIELD).savefig(GALLERY / "collapse_field.png", dpi=130)
    write_movie(folder, FIELD, GALLERY / "collapse.gif", history="run-out")


if __name__ == "__main__":
    main()
