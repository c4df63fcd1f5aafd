# SPDX-License-Identifier: BSD-3-Clause
"""The samples of a study: which values each of them has, and its model."""

from __future__ import annotations

import itertools
import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tilth.errors import BadInput, Problem, shown
from tilth.model import Model, Range, Study, UniformDistribution, Vary
from tilth.model.fields import MOST
from tilth.model.problems import dotted
from tilth.model.study import Distribution
from tilth.studies.key_paths import changed, near_key, value_at


@dataclass(frozen=True)
class Sample:
    """One sample of a study.

    Attributes:
        number: from 1.
        values: of the entries of `Study.vary`, in their order.
        entries: of its case.
    """

    number: int
    values: tuple[Any, ...]
    entries: dict[str, Any]

    @property
    def folder(self) -> str:
        """Name of its folder."""
        return folder_of(self.number)


def folder_of(number: int) -> str:
    """Returns the name of the folder of a sample."""
    return f"{number:04d}"


def values_of_samples(study: Study) -> list[tuple[Any, ...]]:
    """Returns the values of all samples, in their order.

    The draws follow each other; each is made with all combinations of the given values. So the
    samples of a study with fewer draws are the first ones of a study with more.
    """
    given = [(i, _given(entry)) for i, entry in enumerate(study.vary) if not entry.is_random]
    lists = [values for _, values in given]
    combinations = list(
        zip(*lists, strict=True) if study.combine == "zip" and lists else itertools.product(*lists)
    )
    samples = []
    for draw in range(study.samples or 1):
        drawn = {
            i: _drawn(entry, study.seed, draw)
            for i, entry in enumerate(study.vary)
            if entry.is_random
        }
        for combination in combinations:
            chosen = drawn | {i: v for (i, _), v in zip(given, combination, strict=True)}
            samples.append(tuple(chosen[i] for i in range(len(study.vary))))
    return samples


def make_samples(study: Study, entries: dict[str, Any]) -> list[Sample]:
    """Returns all samples, each with a case that is a valid model.

    Args:
        entries: of the case, with absolute paths.

    Raises:
        BadInput: a key is no place in the case, or a sample is not a valid model.
    """
    problems = []
    for i, entry in enumerate(study.vary):
        try:
            value_at(entries, entry.key)
        except BadInput as error:
            problems += [replace(p, key=f"vary[{i}].{p.key}") for p in error.problems]
    if problems:
        raise BadInput.of(problems)
    samples = []
    for number, values in enumerate(values_of_samples(study), start=1):
        case = entries
        for entry, value in zip(study.vary, values, strict=True):
            case = changed(case, entry.key, value)
        try:
            Model.from_dict(case)
        except BadInput as error:
            which = described(study.vary, values)
            found = [
                _explained(p, entries, study.vary, f"{number}: {which}") for p in error.problems
            ]
            raise BadInput.of(found) from None
        samples.append(Sample(number, values, case))
    return samples


def described(vary: Sequence[Vary], values: Sequence[Any]) -> str:
    """Returns the values of a sample in words."""
    pairs = zip(vary, values, strict=True)
    return ", ".join(f"{entry.column} = {shown(value)}" for entry, value in pairs)


def _explained(
    problem: Problem, entries: dict[str, Any], vary: Sequence[Vary], which: str
) -> Problem:
    """Returns a problem of a sample's model with the sample, and a near key if one is unknown."""
    remedy = problem.remedy
    for entry in vary:
        last = entry.key.rpartition(".")[2]
        if problem.problem == "unknown key" and problem.key.endswith(dotted((last,))):
            near = near_key(entries, entry.key)
            remedy = f"did you mean `{near}`?" if near else remedy
    return replace(problem, problem=f"{problem.problem} (sample {which})", remedy=remedy)


def _given(entry: Vary) -> Sequence[Any]:
    if entry.values is not None:
        return entry.values
    assert entry.range is not None
    return _spaced(entry.range)


def _spaced(values: Range) -> list[float]:
    if values.count == 1:
        return [values.start]
    space = np.geomspace if values.spacing == "log" else np.linspace
    numbers = [float(number) for number in space(values.start, values.stop, values.count)]
    if all(float(n).is_integer() for n in (values.start, values.stop)) and _are_whole(numbers):
        return [round(number) for number in numbers]
    return numbers


def _are_whole(numbers: Sequence[float]) -> bool:
    """Whether numbers are whole: entries that count something take no others."""
    return all(number.is_integer() and abs(number) < 2**53 for number in numbers)


def _drawn(entry: Vary, seed: int, draw: int) -> float | int:
    """Returns the value of a random entry, which depends on its key, seed and draw alone."""
    generator = np.random.default_rng([seed, zlib.crc32(entry.key.encode()), draw])
    if entry.distribution is None:
        return int(generator.integers(0, MOST, endpoint=True))
    return _from(entry.distribution, generator)


def _from(distribution: Distribution, generator: np.random.Generator) -> float:
    if isinstance(distribution, UniformDistribution):
        return float(generator.uniform(distribution.lower, distribution.upper))
    mean, deviation = distribution.mean, distribution.standard_deviation
    if distribution.type == "normal":
        return float(generator.normal(mean, deviation))
    variance = math.log1p((deviation / mean) ** 2)
    return float(generator.lognormal(math.log(mean) - variance / 2.0, math.sqrt(variance)))
