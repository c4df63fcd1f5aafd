# SPDX-License-Identifier: BSD-3-Clause
"""The folder of element tests: a table (CSV) of each test and material, and the pictures."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tilth.element_tests.plots import draw_plot
from tilth.element_tests.result import ElementResult
from tilth.input_files import require_file, require_plain_files
from tilth.model import ElementCase
from tilth.model.element_case import picture_of, table_of
from tilth.output.disk import writing
from tilth.output.files import write_durably, written_whole
from tilth.report.texts import save

LIST = "element_tests.json"
"""Names of the files that element tests have written into a folder."""

_REMEDY = "put this right, then make the tests again with --overwrite"
_ENDINGS = (".csv", ".png", ".svg", ".pdf")


def write_outputs(case: ElementCase, results: Sequence[ElementResult], folder: Path) -> None:
    """Writes tables and pictures into a folder; the outputs of earlier tests there are removed.

    Raises:
        AnalysisFailed: a file cannot be written.
        BadInput: something else than a file has the name of one.
    """
    files = [table_of(result.test, result.material) for result in results]
    pictures = [picture_of(plot) for plot in case.plots]
    require_plain_files(folder / name for name in (LIST, *files, *pictures))
    _remove_earlier(folder)
    content = json.dumps([*files, *pictures], indent=1, ensure_ascii=False) + "\n"
    _write(folder / LIST, content)
    for file, result in zip(files, results, strict=True):
        _write(folder / file, table_text(result))
    for plot, picture in zip(case.plots, pictures, strict=True):
        names = plot.tests or [test.name for test in case.tests]
        chosen = [result for result in results if result.test in names]
        figure = draw_plot(plot, chosen, case.title)
        with writing(folder / picture, _REMEDY), written_whole(folder / picture) as new:
            save(figure, new, dpi=110)


def _remove_earlier(folder: Path) -> None:
    """Removes what earlier tests wrote: the files that their list names, and no others."""
    for name in (*_listed(folder / LIST), LIST):
        file = folder / name
        if file.parent == folder and (file.is_file() or file.is_symlink()):
            with writing(file, _REMEDY):
                file.unlink()


def table_text(result: ElementResult) -> str:
    """Returns the table of a test as CSV; numbers have all their digits."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(result.headings())
    whole = [not unit for unit in result.units.values()]
    for row in np.stack(list(result.columns.values()), axis=1):
        rows.writerow(
            [
                str(int(number)) if is_whole else repr(float(number))
                for number, is_whole in zip(row, whole, strict=True)
            ]
        )
    return text.getvalue()


def _write(file: Path, text: str) -> None:
    with writing(file, _REMEDY):
        write_durably(file, text.encode())


def _listed(file: Path) -> list[str]:
    """Returns the names in an earlier list that can be those of outputs."""
    try:
        require_file(file)
        names = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return []
    found = names if isinstance(names, list) else []
    return [name for name in found if isinstance(name, str) and name.endswith(_ENDINGS)]
