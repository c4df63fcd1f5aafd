# SPDX-License-Identifier: BSD-3-Clause
"""Units of the materials' parameters."""

from __future__ import annotations

from functools import cache
from typing import get_args

from tilth.model.materials import Material
from tilth.model.parameter_kinds import KINDS


@cache
def parameter_unit(key: str) -> str | None:
    """Returns the unit of a numeric entry of the materials; None if there is no such entry.

    It is that of the kind of the entry: "stress", "-", "degrees" and others.
    """
    for cls in reversed(get_args(get_args(Material)[0])):
        if key in cls.model_fields and key in cls.kinds:
            return KINDS[cls.kinds[key]].unit
    return None
