# SPDX-License-Identifier: BSD-3-Clause
"""Makes the picture of each example's README: `python examples/make_pictures.py [NAME]...`.

Runs case.toml of the examples; draws the output at half time and the last one as the report does.
"""

import sys
import tempfile
from pathlib import Path

import tilth
from tilth.output.vtkhdf import read_results
from tilth.report.pictures import draw_frames

EXAMPLES = Path(__file__).parent


def make_picture(name: str) -> None:
    model = tilth.load_case(EXAMPLES / name / "case.toml")
    with tempfile.TemporaryDirectory() as folder:
        result = tilth.run(model, Path(folder) / "results", quiet=True)
        results = read_results(result.folder / "results.vtkhdf")
        figure = draw_frames(
            [results.snapshot(index) for index in sorted({len(results) // 2, len(results) - 1})],
            model.output.colour_by,
            results.units,
            axisymmetric=model.analysis.kind == "axisymmetric",
            initial=results.snapshot(0),
        )
        figure.savefig(EXAMPLES / name / "picture.png", dpi=110)


if __name__ == "__main__":
    folders = sorted(case.parent.name for case in EXAMPLES.glob("*/case.toml"))
    for name in sys.argv[1:] or folders:
        make_picture(name)
