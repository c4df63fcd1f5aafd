# SPDX-License-Identifier: BSD-3-Clause
"""Sections of a page that together are no larger than a page may be."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape, unescape

_IMAGE = re.compile(r'<img alt="([^"]*)" src="data:[^"]*">')


def within(parts: Sequence[str], room: int) -> list[str]:
    """Returns sections of HTML of at most ``room`` bytes, the largest images left out and named.

    Text is never left out: the result is larger if the text alone is.
    """
    found = list(parts)
    sizes = [len(part.encode()) for part in found]
    while sum(sizes) > room:
        images = [(len(m[0]), k, m) for k, part in enumerate(found) for m in _IMAGE.finditer(part)]
        if not images:
            break
        _, number, image = max(images, key=lambda each: each[0])
        name = escape(unescape(image[1]))
        text = f"<p>The figure “{name}” is too large for this page.</p>"
        found[number] = found[number].replace(image[0], text, 1)
        sizes[number] = len(found[number].encode())
    return found
