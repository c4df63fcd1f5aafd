# SPDX-License-Identifier: BSD-3-Clause
"""The fewest lines of a model's case file of which a relation still fails."""

from __future__ import annotations

import sys
from collections.abc import Callable

from fuzz.fewer_lines import fewest_lines
from fuzz.toml_text import toml_text

from metamorphic.models import Tree

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ATTEMPTS = 400


def smaller(entries: Tree, fails: Callable[[Tree], bool]) -> str:
    """Returns the case file of a model without the lines that its fault does not need.

    fails: whether the model of other entries has the same fault.
    """

    def text_fails(text: bytes) -> bool:
        try:
            other = tomllib.loads(text.decode())
        except tomllib.TOMLDecodeError:
            return False
        return fails(other)

    whole = toml_text({"format": 1, **entries})
    return fewest_lines(whole.encode(), text_fails, ATTEMPTS).decode()
