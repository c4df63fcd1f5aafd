# SPDX-License-Identifier: BSD-3-Clause
"""Makes the picture of the README, docs/gallery/collapse.png: `python docs/generate_picture.py`.

Runs the example `collapse` and draws two of its outputs as the report does.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import tilth
from tilth.output import read_results
from tilth.report.field_plots import draw_frames

ROOT = Path(__file__).parents[1]
TIMES = (0.75, 1.0)


def main() -> None:
    """Writes the picture."""
    model = tilth.load_case(ROOT / "examples" / "collapse" / "case.toml")
    with tempfile.TemporaryDirectory() as folder:
        result = tilth.run(model, folder)
        results = read_results(result.folder / "results.vtkhdf")
        chosen = [int(np.abs(np.array(results.times) - time).argmin()) for time in TIMES]
        snapshots = [results.snapshot(index) for index in chosen]
        figure = draw_frames(snapshots, model.output.colour_by, results.units)
        figure.savefig(ROOT / "docs" / "gallery" / "collapse.png", dpi=100)


if __name__ == "__main__":
    main()
