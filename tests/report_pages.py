# SPDX-License-Identifier: BSD-3-Clause
"""What a page holds: the HTML of blocks, and the numbers from which it draws its figures."""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.report import blocks as blocks_module
from tilth.report.blocks import Block

BLOCKS = (
    '{% from "blocks.html" import show with context %}'
    "{% for block in blocks %}{{ show(block) }}{% endfor %}"
)


def html_of(blocks: Sequence[Block]) -> str:
    """The HTML of blocks."""
    return blocks_module._environment().from_string(BLOCKS).render(blocks=blocks)


def data_of(page: Path) -> dict[str, Any]:
    """The description of all that a page draws."""
    text = page.read_text(encoding="utf-8")
    found = re.search(r'<script type="application/json" id="tilth-data">(.*?)</script>', text, re.S)
    assert found
    assert "<" not in found[1]
    content: dict[str, Any] = json.loads(found[1])
    return content


def stored(page: Path, number: int, group: str = "page") -> bytes:
    """The content of a blob of a page."""
    text = page.read_text(encoding="utf-8")
    found = re.search(f'<script type="text/plain" id="{group}-blob-{number}">(.*?)</script>', text)
    assert found
    return zlib.decompress(base64.b64decode(found[1]))


def exact(page: Path, number: int) -> Floats:
    """The numbers of a blob of a page that are stored with all digits."""
    return np.frombuffer(stored(page, number))


def chart(page: Path, name: str) -> dict[str, Any]:
    """The chart with a name, with the numbers of its lines."""
    (found,) = (each for each in data_of(page)["charts"] if each["name"] == name)
    for line in found["lines"]:
        line |= {axis: exact(page, line[axis]) for axis in "xy"}
    own: dict[str, Any] = found
    return own
