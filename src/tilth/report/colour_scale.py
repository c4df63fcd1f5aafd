# SPDX-License-Identifier: BSD-3-Clause
"""Colours of a field's values: the maps of matplotlib without it, for pages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tilth.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.cm import ScalarMappable

WITHOUT_VALUE = 0.75
"""Grey of what has no value."""

_MAPS = {
    "viridis": (
        "440154470d6048186a482374472d7b4537814240863e49893b528b375b8d33638d2f6b8e2c728e297a8e26828e"
        "23898e21918c1f988b1fa08822a78528ae8032b67a3fbc734ec36b5ec96270cf5784d44b98d83eaddc30c2df23"
        "d8e219ece51bfde725"
    ),
    "coolwarm": (
        "3b4cc0445acc4e68d85875e16282ea6c8ff1779af782a6fb8db0fe98b9ffa3c2feaec9fcb9d0f9c3d5f4ccd9ed"
        "d5dbe5dddcdce5d8d1ecd3c5f1ccb8f5c4acf7ba9ff7b093f6a586f4987af08b6eeb7d62e46e56dd5f4bd44e41"
        "ca3b37be242eb40426"
    ),
}
"""Colours at equal distances, of matplotlib (viridis; coolwarm: K. Moreland)."""


@dataclass(frozen=True)
class ColourScale:
    """Colours of the values from `low` to `high` by the map of this name."""

    low: float
    high: float
    name: str

    @classmethod
    def of(cls, values: Sequence[Floats]) -> ColourScale:
        """Returns one scale for all values, diverging about zero if both signs are relevant."""
        known = [value[~np.isnan(value)] for value in values]  # NaN: not of every material
        low = min((float(value.min()) for value in known if len(value)), default=0.0)
        high = max((float(value.max()) for value in known if len(value)), default=0.0)
        largest = max(abs(low), abs(high))
        if min(-low, high) > 0.05 * largest:
            return cls(-largest, largest, "coolwarm")
        if high - low <= 1e-12 * largest or largest == 0.0:
            margin = 1e-3 * largest or 1.0
            low, high = low - margin * (low != 0.0), high + margin
        return cls(low, high, "viridis")

    def colours(self, values: Floats) -> Floats:
        """Returns red, green and blue in [0, 1], grey where there is no value, shape (n, 3)."""
        table = np.array([*bytes.fromhex(_MAPS[self.name])]).reshape(-1, 3) / 255.0
        place = (values - self.low) / (self.high - self.low) * (len(table) - 1)
        found = [np.interp(place, np.arange(len(table)), column) for column in table.T]
        return np.where(np.isnan(values)[:, None], WITHOUT_VALUE, np.stack(found, axis=1))

    def matplotlib(self) -> ScalarMappable:
        """Returns the same of matplotlib."""
        from matplotlib import colormaps
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize

        grey = colormaps[self.name].with_extremes(bad=str(WITHOUT_VALUE))
        return ScalarMappable(Normalize(self.low, self.high), grey)
