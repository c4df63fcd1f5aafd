# SPDX-License-Identifier: BSD-3-Clause
"""Units of the materials' parameters."""

from __future__ import annotations

import re
from functools import cache
from typing import get_args

from tilth.model.base import meaning_of
from tilth.model.materials import Material


@cache
def parameter_units() -> dict[str, str]:
    """Returns the units of the numeric entries of all materials, by key.

    A unit is that in brackets in the meaning of the entry: "stress", "-", "degrees" and others.
    """
    units = {}
    for cls in get_args(get_args(Material)[0]):
        for key in cls.model_fields:
            if found := re.search(r"\[([^\]]+)\]", meaning_of(cls, key)):
                units[key] = found[1]
    return units
