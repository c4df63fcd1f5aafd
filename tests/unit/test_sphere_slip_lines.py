# SPDX-License-Identifier: BSD-3-Clause
"""The slip lines of benchmarks/slip_lines.py, and the fits of a shallow sphere to them."""

import importlib
import math
from pathlib import Path
from typing import Any

import pytest

from tilth_verification.closed_forms.limit_loads import CIRCULAR_FOOTING, shallow_sphere

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture
def slip_lines(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("slip_lines")


def test_flat_faces_carry_what_the_footings_of_the_literature_do(slip_lines: Any) -> None:
    """Shield 1955, Eason & Shield 1960."""
    assert slip_lines.smooth(0.0, slip_lines.level) == pytest.approx(
        CIRCULAR_FOOTING["smooth"], abs=5e-3
    )
    force, angle = slip_lines.rough_face(slip_lines.level)
    assert force == pytest.approx(CIRCULAR_FOOTING["rough"], abs=5e-3)
    assert 0.0 < angle < math.pi / 4


def test_the_lip_has_the_displaced_volume(slip_lines: Any) -> None:
    """Volumes over pi a^3: what lies above the first level and what lies below it."""
    ratio, spread = 0.2, slip_lines.SPREAD
    profile, count = slip_lines.lip(ratio), 200_000
    step = 10.0 / count
    heights = (profile(1.0 + (i + 0.5) * step)[0] for i in range(count))
    rim = 0.5 * ratio * (1.0 - 1.0 / spread)
    outside = sum(
        2.0 * (1.0 + (i + 0.5) * step) * (rim - height) * step for i, height in enumerate(heights)
    )
    depth = 0.5 * ratio / spread
    inside = depth - 0.25 * ratio  # of d - r^2 / (2 R), over the circle of the contact
    assert outside == pytest.approx(inside, rel=1e-4)


@pytest.mark.parametrize("ratio", [0.1, 0.2])
def test_the_fits_of_the_sphere_are_those_of_its_slip_lines(slip_lines: Any, ratio: float) -> None:
    profile = slip_lines.lip(ratio)
    smooth = slip_lines.smooth(ratio, profile)
    assert shallow_sphere(ratio, "smooth") == pytest.approx(smooth, abs=3e-3)
    rough, angle = slip_lines.rough_face(profile)
    assert shallow_sphere(ratio, "rough") == pytest.approx(rough, abs=3e-3)
    assert math.sin(angle) > ratio  # the clay below a rough face moves with it
