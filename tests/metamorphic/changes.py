# SPDX-License-Identifier: BSD-3-Clause
"""Copies of a model with other steps, with a stage of rest, or with an unloading."""

from __future__ import annotations

import copy
from typing import Any

from metamorphic.models import Tree


def with_steps(entries: Tree, factor: int) -> Tree:
    """The same model with each step of its schedules divided into as many."""
    other = copy.deepcopy(entries)
    for schedule in _schedules(other):
        schedule["steps"] *= factor
    return other


def with_rest(entries: Tree) -> Tree:
    """The same model with two further stages, of one step and of three, in which nothing changes.

    Over the first one the forces are released that are out of balance as the basis changes.
    """
    other = _staged(entries)
    for name, steps in (("rest", 1), ("further rest", 3)):
        other["stages"].append({"name": name, "schedule": {"steps": steps}})
    return other


def with_unloading(entries: Tree) -> Tree:
    """The same model with a further stage in which loads and motions go back to zero."""
    other = _staged(entries)
    end = [[0.0, 1.0], [1.0, 0.0]]
    names = [each["name"] for each in other.get("loads", ())]
    names += [each["name"] for each in other["boundaries"] if "displacement" in each]
    last = {"name": "unloading", "schedule": {"steps": 2}, "factors": dict.fromkeys(names, end)}
    other["stages"].append(last)
    return other


def _schedules(entries: Tree) -> list[dict[str, Any]]:
    if "stages" not in entries:
        return [entries["schedule"]]
    return [stage["schedule"] for stage in entries["stages"]]


def _staged(entries: Tree) -> Tree:
    other = copy.deepcopy(entries)
    if "stages" not in other:
        other["stages"] = [{"name": "first", "schedule": other.pop("schedule")}]
    return other
