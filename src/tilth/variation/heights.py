# SPDX-License-Identifier: BSD-3-Clause
"""Heights over the horizontal axes: a grid in a CSV file, or an ESRI ASCII grid."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.input_files import require_file
from tilth.variation.csv_file import MOST_BYTES
from tilth.variation.grid_file import RegularGrid, read_grid

NAMES = ("value", "z", "height", "elevation")
"""Names of the column of heights in a CSV file."""

EXAMPLE = "ncols 3, nrows 2, xllcorner 0, yllcorner 0, cellsize 10, then rows from north to south"


def read_heights(file: str, axes: int, key: str) -> RegularGrid:
    """Reads heights [length]; NaN where an ASCII grid has none.

    Args:
        file: path of a .csv file as of `read_grid`, or of an ESRI ASCII grid, .asc (3D).
        axes: number of horizontal axes.
        key: of the entry in the case file, for messages.

    Raises:
        BadInput: the file cannot be read, or is no such grid.
    """
    if not file.lower().endswith(".asc"):
        scattered = '; or places = "scattered" for survey points' if axes == 2 else ""
        return read_grid(file, axes, key, NAMES, scattered)
    if axes != 2:
        remedy = "give rows (x, elevation), or a .csv file with the columns x,z"
        raise BadInput("an ASCII grid is for 3D", remedy, key=key, value=file)
    return _read_ascii(file, key)


def _count(name: str, value: float) -> int:
    """Returns a number of rows or columns; raises `ValueError` if it is none."""
    if not value.is_integer():
        raise ValueError(f"{name} = {value:g} is not a whole number")
    return int(value)


def _read_ascii(file: str, key: str) -> RegularGrid:
    """Reads a grid of rows from north to south below a header of names and numbers."""

    def refused(problem: str, remedy: str = EXAMPLE) -> BadInput:
        return BadInput(problem, remedy, key=key, value=file)

    path = Path(file)
    try:
        require_file(path)
        if path.stat().st_size > MOST_BYTES:
            raise refused("is larger than 1 GB", "cut out the part with the soil")
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        problem = f"cannot be read: {error.strerror or error}"
        raise refused(problem, "check the path and its permissions") from None
    except UnicodeDecodeError:
        raise refused("is not a text file", "save it as ESRI ASCII grid") from None
    header: dict[str, float] = {}
    first = 0
    try:
        while first < len(lines) and (words := lines[first].split()) and words[0][0].isalpha():
            if words[0].lower() in ("nan", "inf"):
                break
            header[words[0].lower()] = float(words[1])
            first += 1
        columns, rows = (_count(name, header[name]) for name in ("ncols", "nrows"))
        size = [header[f"d{axis}"] if f"d{axis}" in header else header["cellsize"] for axis in "xy"]
        origin = [
            header[f"{axis}llcenter"]
            if f"{axis}llcenter" in header
            else header[f"{axis}llcorner"] + 0.5 * width
            for axis, width in zip("xy", size, strict=True)
        ]
        value = np.array(" ".join(lines[first:]).split(), dtype=np.float64)
    except KeyError as error:
        raise refused(f"is no ASCII grid: {error.args[0]} is missing in its header") from None
    except (ValueError, IndexError, OverflowError) as error:
        raise refused(f"is no ASCII grid: {error}") from None
    if columns < 2 or rows < 2 or not min(size) > 0.0 or not np.isfinite([*size, *origin]).all():
        raise refused("has a header without at least two rows and columns of a size above 0")
    if len(value) != rows * columns:
        raise refused(f"has {len(value)} heights, not {rows} rows of {columns}")
    value = value.reshape(rows, columns)[::-1].T
    value = np.where(np.isfinite(value), value, np.nan)
    if (none := header.get("nodata_value")) is not None:
        value = np.where(value == none, np.nan, value)
    (x0, y0), (dx, dy) = origin, size
    x: Floats = np.asarray(x0 + dx * np.arange(columns), dtype=np.float64)
    y: Floats = np.asarray(y0 + dy * np.arange(rows), dtype=np.float64)
    return RegularGrid((0, 1), (x, y), value)
