# SPDX-License-Identifier: BSD-3-Clause
"""Helpers for arrays."""

from __future__ import annotations

import numpy as np
import pytest

from tilth.arrays import distinct_rows

random = np.random.default_rng(1)
TABLES = {
    "whole numbers": random.integers(-5, 5, size=(500, 3)),
    "floats": np.floor(random.normal(size=(500, 2), scale=4.0)),
    "one row": np.array([[3, -4]]),
    "one column": random.integers(0, 3, size=(50, 1)),
    "too wide for a key": random.integers(0, 3, size=(50, 3)) * 2.0**40,
}


@pytest.mark.parametrize("table", TABLES.values(), ids=TABLES)
def test_first_of_each_distinct_row(table: np.ndarray) -> None:
    expected = np.unique(table, axis=0, return_index=True)[1]
    np.testing.assert_array_equal(distinct_rows(table), expected)
