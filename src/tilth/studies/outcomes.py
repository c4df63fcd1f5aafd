# SPDX-License-Identifier: BSD-3-Clause
"""What a study takes from the folder of a run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from tilth.analysis.tracker import tracked_columns
from tilth.arrays import Floats
from tilth.errors import BadInput, Problem
from tilth.model import FunctionOutcome, HistoryOutcome, Model, SafetyOutcome, Study
from tilth.model.problems import unknown_name
from tilth.model.study import Outcome
from tilth.model.user_function import described, file_of, load_function
from tilth.output.folder import HISTORY
from tilth.output.history import FIRST_COLUMNS, OF_STAGES, read_history
from tilth.output.safety_files import read_safety
from tilth.report.fields import with_unit


def require_outcomes(study: Study, model: Model) -> None:
    """Checks that the runs of a model have what a study takes from them.

    Raises:
        BadInput: a column is not tracked, or a function of the user cannot be loaded.
    """
    problems = []
    for i, outcome in enumerate(study.outcomes):
        if isinstance(outcome, FunctionOutcome):
            load_function(outcome.function, Path(), key=f"outcomes[{i}].function")
        if not isinstance(outcome, HistoryOutcome) or outcome.table != HISTORY:
            continue
        columns = [("column", outcome.column)]
        columns += [("at.column", outcome.at.column)] if outcome.at is not None else []
        for key, column in columns:
            known = {name: heading for heading, name in _names(_headings(model)).items()}
            if column not in known and column not in known.values():
                what, remedy = unknown_name("column", column, known)
                remedy = f"{remedy.replace('declared', 'columns')} ([[track]] of the case adds one)"
                problems.append(Problem(f"outcomes[{i}].{key}", what, remedy, column))
    if problems:
        raise BadInput.of(problems)


def unit_of(outcome: Outcome, model: Model) -> str:
    """Returns the unit of an outcome; "" where it has none or it is not known before a run."""
    if isinstance(outcome, FunctionOutcome):
        return outcome.unit
    if isinstance(outcome, SafetyOutcome) or outcome.table != HISTORY:
        return ""
    for name, unit in tracked_columns(model):
        if outcome.column in (name, f"{name} [{unit}]"):
            return unit
    return ""


def value_of(outcome: Outcome, folder: Path) -> float:
    """Returns the outcome of the run in a folder.

    Raises:
        BadInput: the folder does not have it, or it is not a finite number.
    """
    if isinstance(outcome, SafetyOutcome):
        summary = read_safety(folder)
        if not summary.is_decided:
            raise BadInput(f"is undecided: {summary.bracket}")
        value = summary.factor
    elif isinstance(outcome, HistoryOutcome):
        value = _of_history(outcome, read_history(folder / outcome.table))
    else:
        value = _of_function(outcome, folder)
    if not math.isfinite(value):
        raise BadInput(f"is {value}, not a finite number")
    return value


def _of_history(outcome: HistoryOutcome, table: Mapping[str, Floats]) -> float:
    values = _column(table, outcome.column)
    if outcome.at_time is not None:
        return _at(table["time"], outcome.at_time, values, "time")
    if outcome.at is not None:
        other = _column(table, outcome.at.column)
        return _at(other, outcome.at.value, values, outcome.at.column)
    found = values[np.isfinite(values)]
    if outcome.take in (None, "last") or not len(found):
        return float(values[-1])
    return float(found.max() if outcome.take == "largest" else found.min())


def _at(other: Floats, wanted: float, values: Floats, name: str) -> float:
    """Returns the value where `other` first reaches a number, linear between two rows."""
    away = other - wanted
    exact = np.flatnonzero(away == 0.0)
    between = np.flatnonzero(away[:-1] * away[1:] < 0.0)
    first = int(exact[0]) if len(exact) else len(other)
    if len(between) and between[0] < first:
        row = int(between[0])
        share = away[row] / (away[row] - away[row + 1])
        return float(values[row] + share * (values[row + 1] - values[row]))
    if first == len(other):
        what = f"`{name}` never reaches {wanted:g}: it lies between {np.nanmin(other):g} and "
        raise BadInput(f"{what}{np.nanmax(other):g}")
    return float(values[first])


def _column(table: Mapping[str, Floats], column: str) -> Floats:
    """Returns the column with a heading or name."""
    names = {name: heading for heading, name in _names(list(table)).items()}
    heading = column if column in table else names.get(column)
    if heading is None:
        raise BadInput("the table has no such column", value=column, key="column")
    return table[heading]


def _names(headings: Sequence[str]) -> dict[str, str]:
    """Returns the names of columns by heading: what is before the unit."""
    return {h: h.rpartition(" [")[0] if h.endswith("]") and " [" in h else h for h in headings}


def _headings(model: Model) -> list[str]:
    tracked = [with_unit(name, unit) for name, unit in tracked_columns(model)]
    return [*FIRST_COLUMNS, *(OF_STAGES[1:] if model.stages else ()), *tracked]


def _of_function(outcome: FunctionOutcome, folder: Path) -> float:
    function = load_function(outcome.function, Path())
    try:
        result = function(folder)
    except (Exception, SystemExit) as error:
        raise BadInput(
            f"{outcome.function} failed: {described(error, file_of(function))}"
        ) from error
    if isinstance(result, bool) or not isinstance(result, (int, float, np.number)):
        what = f"{outcome.function} returned a {type(result).__name__}, not a number"
        raise BadInput(what)
    return float(result)
