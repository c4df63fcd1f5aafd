# SPDX-License-Identifier: BSD-3-Clause
"""The notebooks run from the first cell to the last, and their pages show what they print.

`TILTH_ACCEPT_NOTEBOOKS=1 python -m pytest tests/test_notebooks.py -m slow` stores their output.
"""

from __future__ import annotations

import base64
import io
import os
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient
from PIL import Image

FOLDER = Path(__file__).parents[1] / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
LARGEST = 200_000
"""Size of a notebook with its output [byte]."""


def texts(notebook: Any) -> list[str]:
    """What each cell prints and shows, without the pictures.

    What a cell prints may come in any number of pieces.
    """
    found: list[str] = []
    for cell in notebook.cells:
        outputs = cell.get("outputs", ())
        found.append("".join(output.get("text", "") for output in outputs))
        found += [output.get("data", {}).get("text/plain", "") for output in outputs]
    return [text for text in found if text and not text.startswith("<Figure")]


def without_output_of_the_machine(notebook: Any) -> None:
    """Leaves one form of each output, and neither times nor versions."""
    notebook.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
    for cell in notebook.cells:
        cell.metadata = {}
        for output in cell.get("outputs", ()):
            data = output.get("data", {})
            if data:
                output["metadata"] = {}
            if "image/png" in data:
                output["data"] = {"image/png": with_few_colours(data["image/png"])}
            elif data:
                output["data"] = {"text/plain": data["text/plain"]}


def with_few_colours(png: str) -> str:
    """A picture in base64 with 256 colours, which needs half of the room."""
    small = io.BytesIO()
    image = Image.open(io.BytesIO(base64.b64decode(png))).convert("RGB")
    image.quantize(256).save(small, "PNG", optimize=True)
    return base64.b64encode(small.getvalue()).decode()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of the client's own packages
@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_runs(file: Path, tmp_path: Path) -> None:
    stored = nbformat.read(file, as_version=4)
    nbformat.validate(stored)
    fresh = nbformat.read(file, as_version=4)
    NotebookClient(
        fresh, timeout=500, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    if "TILTH_ACCEPT_NOTEBOOKS" in os.environ:
        without_output_of_the_machine(fresh)
        nbformat.write(fresh, file)
        stored = fresh
    assert texts(stored) == texts(fresh)


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_is_small_and_complete(file: Path) -> None:
    assert file.stat().st_size < LARGEST
    notebook = nbformat.read(file, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == [*range(1, len(code) + 1)]
    assert any("image/png" in o.get("data", {}) for cell in code for o in cell.outputs)
