# SPDX-License-Identifier: BSD-3-Clause
"""The multipliers of implicit boundaries meet the inf-sup condition, however the plane lies.

The bounds are 0.7 of the least that benchmarks/inf_sup.py finds over its planes and refinements
(docs/theory/implicit_boundaries.md): planes that were not drawn there may lie a little lower, and a
multiplier that lacks nodes of its own has a constant of 0, as those of single points do.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"

BOUND = {2: 0.17, 3: 0.09}
"""Of the constant [-], by the dimension."""


@pytest.fixture
def inf_sup(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("inf_sup")


@pytest.mark.parametrize(
    ("dim", "cells", "planes", "condition"),
    [
        (2, 4, 12, "fixed"),
        (2, 8, 12, "fixed"),
        (2, 8, 12, "roller"),
        (3, 3, 6, "fixed"),
        (3, 5, 2, "fixed"),
    ],
)
def test_means_over_patches_have_a_bound(
    inf_sup: Any, dim: int, cells: int, planes: int, condition: str
) -> None:
    found = inf_sup.constants(dim, cells, planes, condition)
    assert len(found) == planes
    assert min(each.patches for each in found) > BOUND[dim]


@pytest.mark.parametrize("angle", [0.0, 1e-4, 0.5, 26.565, 45.0])
@pytest.mark.parametrize("height", [0.0, 9e-4, 1.1e-3, 0.5])
def test_so_have_those_of_planes_along_the_grid_and_through_its_nodes(
    inf_sup: Any, angle: float, height: float
) -> None:
    """Height: of the plane over a node, in cells."""
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    axes = np.array([[cosine, sine], [-sine, cosine]])
    means, _ = inf_sup.spectra(axes, np.array([0.37, 0.0]) + height * axes[1], 8)
    assert means[0] > BOUND[2]


@pytest.mark.parametrize("cells", [4, 8])
def test_a_multiplier_at_each_point_has_none(inf_sup: Any, cells: int) -> None:
    """Most combinations of them meet no displacement at all."""
    found = inf_sup.constants(2, cells, 12, points=True)
    assert max(each.points for each in found) < 1e-12
    assert min(each.vanishing for each in found) > 0.6
