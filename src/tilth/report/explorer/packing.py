# SPDX-License-Identifier: BSD-3-Clause
"""Arrays inside a page: 16 bits a number, bytes sorted by place, deflated, base64."""

from __future__ import annotations

import base64
import zlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilth.arrays import Floats, Integers

STEPS = 65534
"""Steps between the smallest and the largest number; the next integer is "no value"."""
_ELEMENT = 70
"""Characters around a text in the page, at most."""


@dataclass
class Blobs:
    """Texts that a page holds apart from its description, by number."""

    texts: list[str] = field(default_factory=list)
    _known: dict[str, int] = field(default_factory=dict)

    def add(self, content: bytes) -> int:
        """Stores bytes deflated, equal ones once; returns their number."""
        return self.include(base64.b64encode(zlib.compress(content, 6)).decode())

    def include(self, text: str) -> int:
        """Stores what other blobs hold, once; returns its number."""
        if text not in self._known:
            self._known[text] = len(self.texts)
            self.texts.append(text)
        return self._known[text]

    def rounded(self, values: Floats) -> dict[str, Any]:
        """Stores numbers of any shape with an error of at most 1/131068 of their range.

        Returns where they are (``blob``) and their range (``low``, ``high``). What is not finite
        is stored as "no value".
        """
        flat = np.asarray(values, dtype=np.float64).ravel()
        known = np.isfinite(flat)
        low, high = (float(flat[known].min()), float(flat[known].max())) if known.any() else (0, 0)
        place = np.full(len(flat), STEPS + 1, dtype="<u2")
        scale = high - low
        share = (flat[known] - low) / scale if scale > 0.0 else np.zeros(int(known.sum()))
        place[known] = np.round(share * STEPS).astype("<u2")
        return {"blob": self.add(_by_place(place)), "low": low, "high": high}

    def exact(self, values: Floats | Integers, kind: str) -> int:
        """Stores numbers as ``kind`` (``<f8``, ``<u4``); returns the number of the blob."""
        return self.add(np.ascontiguousarray(values).astype(kind).tobytes())

    @property
    def size(self) -> int:
        """Number of characters, with those of the elements that hold the texts."""
        return sum(len(text) + _ELEMENT for text in self.texts)

    def elements(self, group: str) -> str:
        """Returns the elements that hold the texts; ``group`` begins their names."""
        return "".join(
            f'<script type="text/plain" id="{group}-blob-{number}">{text}</script>\n'
            for number, text in enumerate(self.texts)
        )


def _by_place(numbers: NDArray[Any]) -> bytes:
    """Returns all low bytes, then all high ones: equal bytes side by side become shorter."""
    return numbers.view(np.uint8).reshape(-1, 2).T.tobytes()


def packed_line(blobs: Blobs, part: dict[str, Any]) -> dict[str, Any]:
    """Stores the ``position`` of a part: segments (k, 2, 2) or triangles (k, 3, 3)."""
    position = np.asarray(part["position"], dtype=np.float64)
    return {**part, "position": [blobs.rounded(column) for column in np.moveaxis(position, -1, 0)]}
