# SPDX-License-Identifier: BSD-3-Clause
"""The state in a checkpoint besides the material points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from tilth.mpm.points import MaterialPoints, PointRange

DECLARED_POSITION = "declared position"
"""Array of a checkpoint: where the points were declared, in an analysis with stages."""

SAME = 1e-9
"""Relative difference of numbers that are the same but for round-off."""

Arrays = Mapping[str, npt.NDArray[Any]]


class MissingState(Exception):
    """An array that a checkpoint lacks; `str` gives its name."""


class WrongState(Exception):
    """An array of a checkpoint that does not fit the model; `str` says which and why."""


class Stateful(Protocol):
    """An object with variables that persist from step to step."""

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns what a later step reads, by name; the names are the same at any time."""
        ...

    def restore(self, state: Arrays) -> None:
        """Goes back to what `state` returned.

        Raises:
            ValueError: the arrays do not fit together.
        """
        ...


def state_of(owners: Mapping[str, Stateful]) -> dict[str, npt.NDArray[Any]]:
    """Returns the states of all owners, each array by `owner.name`."""
    return {
        f"{owner}.{name}": np.asarray(array)
        for owner, each in owners.items()
        for name, array in each.state().items()
    }


def restored_points(
    initial: MaterialPoints, arrays: Arrays, staged: bool = False
) -> MaterialPoints:
    """Returns the material points that a checkpoint stored; `initial` are those of the model.

    staged: whether the analysis has stages, so that points may be missing or placed later.

    Raises:
        MissingState: an array is missing.
        WrongState: an array is not of these points, or no state of soil.
    """
    found: dict[str, Any] = {}
    for name, first in initial.arrays().items():
        if name not in arrays:
            raise MissingState(name)
        require_kind(name, arrays[name], first)
        found[name] = arrays[name]
    number = found["point_id"]
    count = len(number) if staged else len(initial)
    for name, array in found.items():
        if len(array) != count:
            raise WrongState(f"{name!r} is of {len(array)} points instead of {count}")
    points = MaterialPoints(ranges=_ranges_with(initial, number), varying=initial.varying, **found)
    _require_same_start(points, initial, arrays.get(DECLARED_POSITION) if staged else None)
    for name, least in (
        ("initial_volume", points.initial_volume.min()),
        ("assumed_jacobian", points.assumed_jacobian.min()),
        ("half_length", points.half_length.min()),
        ("deformation_gradient", points.volume.min()),
    ):
        if least <= 0.0:
            raise WrongState(f"{name!r} has a point whose volume or length is not positive")
    return points


def _ranges_with(initial: MaterialPoints, number: npt.NDArray[Any]) -> list[PointRange]:
    """Returns the ranges of the points with these permanent numbers, one range after the other."""
    ranges, start = [], 0
    for range_ in initial.ranges:
        own = (number >= range_.start) & (number < range_.stop)
        stop = start + int(own.sum())
        if not own[start:stop].all() or len(np.unique(number[start:stop])) != stop - start:
            raise WrongState(f"'point_id' has not the numbers of the points of {range_.name!r}")
        if stop > start:
            ranges.append(replace(range_, start=start, stop=stop))
        start = stop
    if start != len(number) or start == 0:
        raise WrongState("'point_id' has numbers of no point of the model")
    return ranges


def _require_same_start(
    points: MaterialPoints, initial: MaterialPoints, declared: npt.NDArray[Any] | None
) -> None:
    """Checks that the points began where those of the model do, with the same parameters.

    The model names files, of horizons, tables or functions, which may have changed since.

    declared: where they were declared when the run began, if that does not follow from their
        displacements.
    """
    number = points.point_id
    if declared is None:
        declared = points.position - points.displacement
    elif declared.shape != points.position.shape:
        raise WrongState(f"{DECLARED_POSITION!r} is not of these points")
    moved = np.abs(declared - initial.position[number])
    size = np.abs(points.position) + np.abs(points.displacement)
    if (moved > SAME * (size + initial.initial_half_length[number])).any():
        raise WrongState("the points do not begin where those of the model do: a file has changed")
    before, now = points.parameters, initial.parameters[number]
    if (np.abs(before - now) > SAME * np.abs(now)).any():
        raise WrongState(
            "'parameters' are not those of the model: a table, a function or a library has changed"
        )


def restore_all(owners: Mapping[str, Stateful], arrays: Arrays) -> None:
    """Gives each owner, which is in its first state, back what `state_of` returned.

    Raises:
        MissingState: an array of an owner is missing.
        WrongState: an array is not of the owner's kind, or they do not fit together.
    """
    for owner, each in owners.items():
        found = {}
        for name, first in each.state().items():
            key = f"{owner}.{name}"
            if key not in arrays:
                raise MissingState(key)
            found[name] = arrays[key]
            require_kind(key, arrays[key], first)
        try:
            each.restore(found)
        except ValueError as error:
            raise WrongState(f"{owner}: {error}") from error


def require_kind(name: str, array: npt.NDArray[Any], like: npt.NDArray[Any]) -> None:
    """Checks type and columns of an array, and that its numbers are finite.

    An array that begins with infinite numbers may keep them, but none is "not a number".

    Raises:
        WrongState: with the name of the array.
    """
    if array.dtype != like.dtype:
        raise WrongState(f"{name!r} is of type {array.dtype} instead of {like.dtype}")
    if array.shape[1:] != like.shape[1:] or array.ndim != like.ndim:
        raise WrongState(f"{name!r} has the shape {array.shape} instead of {like.shape}")
    if like.dtype.kind == "f":
        wrong = np.isnan(array) if np.isinf(like).any() else ~np.isfinite(array)
        if wrong.any():
            raise WrongState(f"{name!r} has {int(wrong.sum())} numbers that are not finite")
