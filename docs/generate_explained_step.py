# SPDX-License-Identifier: BSD-3-Clause
"""Makes the output and the picture of docs/howto/explain_a_step.md.

`python docs/generate_explained_step.py` runs the example `vertical_cut` with gravity that is raised
in four large steps, prints the explanation of the fourth one, and writes its picture.
"""

from __future__ import annotations

import shutil
import tempfile
from contextlib import suppress
from pathlib import Path

import tilth

ROOT = Path(__file__).parents[1]
STEP = 4
FACTOR = [[0.0, 0.0], [1.0, 14.0]]
SCHEDULE = {"steps": 4, "minimum_step": 0.1, "outputs": 1}


def model() -> tilth.Model:
    """Returns the model of the how-to."""
    entries = tilth.load_case(ROOT / "examples" / "vertical_cut" / "case.toml").to_dict()
    entries["loads"][0]["factor"] = FACTOR
    entries["schedule"] = SCHEDULE
    entries["output"] = {"report": False}
    return tilth.Model.from_dict(entries)


def main() -> None:
    """Runs the case and writes the picture."""
    with tempfile.TemporaryDirectory() as folder:
        with suppress(tilth.AnalysisFailed):
            tilth.run(model(), folder, explain=STEP)
        picture = Path(folder) / f"explain_{STEP}.png"
        shutil.copy(picture, ROOT / "docs" / "howto" / "explain_a_step.png")


if __name__ == "__main__":
    main()
