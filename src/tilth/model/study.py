# SPDX-License-Identifier: BSD-3-Clause
"""The declaration of a study: many runs of one case, and what is taken from each of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, PlainValidator, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared, DeclaredFile, chosen_by
from tilth.model.davis import DavisForm
from tilth.model.declaration import FORMAT, format_of, one
from tilth.model.fields import (
    AsTuple,
    CellName,
    Count,
    CountOrZero,
    Entries,
    FileName,
    Label,
    Positive,
    PythonFunction,
    Real,
    Text,
    as_list,
)
from tilth.model.problems import reject, rejection
from tilth.model.strength_reduction import FactorTolerance

MOST_SAMPLES = 100_000
"""Samples of a study, at most."""

RESERVED = ("sample", "status", "reason")
"""Columns that every table of a study has."""


def _values(value: Any) -> tuple[Any, ...]:
    entries = as_list(value)
    if not entries:
        raise reject("must be a list of values", "such as [10e3, 20e3]")
    if len(entries) > MOST_SAMPLES:
        raise reject(f"has {len(entries):,} values", f"give at most {MOST_SAMPLES:,}")
    return tuple(entries)


class Range(Declared):
    """Values at equal distances, both ends included."""

    start: Real
    """First value."""
    stop: Real
    """Last value."""
    count: Count
    """Number of values."""
    spacing: Literal["linear", "log"] = "linear"
    """With "log" their logarithms have equal distances."""

    @model_validator(mode="after")
    def _can_be_divided(self) -> Any:
        if self.count > MOST_SAMPLES:
            problem = f"must be at most {MOST_SAMPLES:,}"
            raise rejection([Problem("count", problem, value=self.count)])
        for key in ("start", "stop"):
            if self.spacing == "log" and getattr(self, key) <= 0.0:
                what = 'must be greater than zero with spacing = "log"'
                raise rejection([Problem(key, what, value=getattr(self, key))])
        return self


class NormalDistribution(Declared):
    """Normal distribution."""

    type: Literal["normal"] = "normal"
    mean: Real
    """Mean."""
    standard_deviation: Positive
    """Standard deviation."""


class LognormalDistribution(Declared):
    """Lognormal distribution: the logarithm is normally distributed."""

    type: Literal["lognormal"] = "lognormal"
    mean: Positive
    """Mean of the parameter itself, not of its logarithm."""
    standard_deviation: Positive
    """Standard deviation of the parameter itself."""


class UniformDistribution(Declared):
    """Uniform distribution."""

    type: Literal["uniform"] = "uniform"
    lower: Real
    """Lower end."""
    upper: Real
    """Upper end."""

    @model_validator(mode="after")
    def _in_order(self) -> Any:
        if self.upper <= self.lower:
            what = f"must be greater than `lower` ({self.lower:g})"
            raise rejection([Problem("upper", what, value=self.upper)])
        return self


_DISTRIBUTIONS = (NormalDistribution, LognormalDistribution, UniformDistribution)
Distribution = Annotated[
    Annotated[
        NormalDistribution | LognormalDistribution | UniformDistribution,
        Field(discriminator="type"),
    ],
    chosen_by("type", *_DISTRIBUTIONS),
]


class Vary(Declared):
    """An entry of the case file that differs between samples: exactly one way to give its values.

    `values` and `range` are given; `distribution` and `new_seed` are random.
    """

    key: Text
    """Place in the case file: keys with points between them; an entry of a list by its `name`, or
    its number from 0, such as `bodies.slope.points_per_cell` or `loads.0.acceleration.1`."""
    name: CellName | None = None
    """Name of the column; the key if not given."""
    values: Annotated[Sequence[Any], PlainValidator(_values)] | None = None
    """List of values."""
    range: Range | None = None
    """Values at equal distances."""
    distribution: Distribution | None = None
    """Distribution from which each sample draws a value."""
    new_seed: bool = False
    """Whether each sample gets a seed of its own: for the `seed` of a random field."""

    @model_validator(mode="after")
    def _one_way(self) -> Any:
        given = [k for k in ("values", "range", "distribution") if getattr(self, k) is not None]
        given += ["new_seed"] * self.new_seed
        if len(given) != 1:
            what = f"has {' and '.join(given) or 'no values'}"
            remedy = "give one of `values`, `range`, `distribution` and `new_seed = true`"
            raise rejection([Problem("key", what, remedy, self.key)])
        return self

    @property
    def is_random(self) -> bool:
        """Whether the values are drawn at random."""
        return self.new_seed or self.distribution is not None

    @property
    def column(self) -> str:
        """Its column in the table."""
        return self.name or self.key


class Place(Declared):
    """A place in the history: where a column first reaches a value."""

    column: Text
    """Name of a column, with or without its unit."""
    value: Real
    """Value that it reaches; between two rows it is interpolated linearly."""


class HistoryOutcome(Declared):
    """A number from a table with a row for each step."""

    type: Literal["history"] = "history"
    name: CellName
    """Name of the column of the study's table."""
    column: Text
    """Name of the column of the run's table, with or without its unit."""
    table: Literal["history.csv", "boundaries.csv", "energies.csv"] = "history.csv"
    """The run's table."""
    take: Literal["last", "largest", "smallest"] | None = None
    """Which of its values; the last if neither this nor `at_time` or `at` is given."""
    at_time: Real | None = None
    """Time of the schedule at which the value is taken, interpolated linearly."""
    at: Place | None = None
    """Where another column first reaches a value, instead."""
    worst: Literal["largest", "smallest"] = "largest"
    """Which outcome is the worst."""

    @model_validator(mode="after")
    def _one_place(self) -> Any:
        given = [key for key in ("take", "at_time", "at") if getattr(self, key) is not None]
        if len(given) > 1:
            what = f"has {' and '.join(f'`{key}`' for key in given)}"
            raise rejection([Problem("name", what, "give one of them", self.name)])
        return self


class SafetyOutcome(Declared):
    """The factor of safety at the end of the run, by strength reduction."""

    type: Literal["safety"] = "safety"
    name: CellName = "factor of safety"
    """Name of the column of the study's table."""
    tolerance: FactorTolerance = 0.01
    """Of the factor [-]."""
    start: Positive = 1.0
    """Factor that is tried first [-]."""
    davis: DavisForm | None = None
    """Which associated equivalent of Davis replaces soil with psi < phi, as in a strength reduction
    of a stage; none if not given."""
    worst: Literal["largest", "smallest"] = "smallest"
    """Which outcome is the worst."""


class FunctionOutcome(Declared):
    """What a Python function of the user returns for the folder of a run."""

    type: Literal["function"] = "function"
    name: CellName
    """Name of the column of the study's table."""
    function: PythonFunction
    """A function of the folder (pathlib.Path) that returns a number."""
    unit: Label = ""
    """Unit, shown in tables and pictures."""
    worst: Literal["largest", "smallest"] = "largest"
    """Which outcome is the worst."""


_OUTCOMES = (HistoryOutcome, SafetyOutcome, FunctionOutcome)
Outcome = Annotated[
    Annotated[HistoryOutcome | SafetyOutcome | FunctionOutcome, Field(discriminator="type")],
    chosen_by("type", *_OUTCOMES),
]


class Study(DeclaredFile):
    """Many runs of one case with other values in it, and what is taken from each of them.

    The names are those of the study's file. Raises `BadInput` with every wrong entry.
    """

    format: Annotated[int, PlainValidator(format_of)] = FORMAT
    """Version of the file's schema."""
    title: Text = ""
    """Title, shown in the report."""
    case: FileName | None = None
    """Case file. In Python a model may be given instead."""
    combine: Literal["grid", "zip"] = "grid"
    """How entries with `values` or a `range` are combined: "grid" for all combinations, the last
    entry changing fastest; "zip" for the first of all, then the second of all, and so on."""
    samples: Count | None = None
    """Number of random draws; each is made with every combination of the given values. Required
    with random entries, and only with these."""
    seed: CountOrZero = 0
    """Seed of all random draws. A draw depends on the seed, its number and the key alone."""
    keep: Literal["all", "tables"] = "all"
    """What stays of each run: "tables" deletes fields, checkpoints, pictures and reports."""
    vary: Annotated[Sequence[Vary], Entries, AsTuple, AfterValidator(one)]
    """a section [[vary]] for each entry of the case file that differs between samples."""
    outcomes: Annotated[Sequence[Outcome], Entries, AsTuple, AfterValidator(one)]
    """a section [[outcomes]] for each quantity that is taken from the runs."""

    @model_validator(mode="after")
    def _entries_fit_together(self) -> Any:
        problems = [*self._repeated(), *self._counts()]
        if problems:
            raise rejection(problems)
        return self

    def _repeated(self) -> list[Problem]:
        """Returns names and keys that are there twice."""
        problems, used = [], set(RESERVED)
        keys: set[str] = set()
        columns = [(f"vary[{i}]", v.column) for i, v in enumerate(self.vary)]
        columns += [(f"outcomes[{i}].name", o.name) for i, o in enumerate(self.outcomes)]
        for key, column in columns:
            if column in used:
                what = "is the name of another column"
                problems.append(Problem(key, what, "give a different `name`", column))
            used.add(column)
        for i, entry in enumerate(self.vary):
            if entry.key in keys:
                problems.append(Problem(f"vary[{i}].key", "is given twice", value=entry.key))
            keys.add(entry.key)
        if sum(isinstance(o, SafetyOutcome) for o in self.outcomes) > 1:
            problems.append(Problem("outcomes", "a run has one factor of safety", "give it once"))
        return problems

    def _counts(self) -> list[Problem]:
        """Returns numbers of values that do not fit together."""
        is_random = any(v.is_random for v in self.vary)
        if is_random and self.samples is None:
            return [Problem("samples", "missing", "give the number of random draws")]
        if not is_random and self.samples is not None:
            remedy = "leave it out: the values give the number of samples"
            return [Problem("samples", "there is no random entry", remedy, self.samples)]
        lists = [v.values for v in self.vary if v.values is not None]
        ranges = [v.range for v in self.vary if v.range is not None]
        counts = [*map(len, lists), *(each.count for each in ranges)]
        if self.combine == "zip" and len(set(counts)) > 1:
            numbers = ", ".join(map(str, counts))
            what = f'with combine = "zip" all must have as many values; they have {numbers}'
            return [Problem("vary", what, "add values, or leave `combine` out for a grid")]
        total = self.samples or 1
        for count in counts[: 1 if self.combine == "zip" else None]:
            total *= count
        if total > MOST_SAMPLES:
            return [Problem("vary", f"gives {total:,} samples", f"at most {MOST_SAMPLES:,}")]
        return []

    def to_dict(self) -> dict[str, Any]:
        """Returns the study as a dictionary that JSON stores without loss; see `from_dict`."""
        return self.model_dump(mode="json", exclude_none=True)
