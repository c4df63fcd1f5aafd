# SPDX-License-Identifier: BSD-3-Clause
"""Units of the materials' parameters."""

from __future__ import annotations

import re
from functools import cache
from typing import get_args

from tilth.model.base import meaning_of
from tilth.model.materials import Material


@cache
def parameter_unit(key: str) -> str | None:
    """Returns the unit of a numeric entry of the materials; None if there is no such entry.

    It is that in brackets in the meaning of the entry: "stress", "-", "degrees" and others.
    """
    for cls in reversed(get_args(get_args(Material)[0])):
        if key in cls.model_fields and (found := re.search(r"\[([^\]]+)\]", meaning_of(cls, key))):
            return found[1]
    return None
