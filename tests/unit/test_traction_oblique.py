# SPDX-License-Identifier: BSD-3-Clause
"""The traction on oblique boundaries of a uniformly pressed block is uniform.

A multiplier at each quadrature point gave 6 to 53 % (docs/decisions/0018-multiplier-space.md). At
45 degrees the boxes of the points stand corner to corner with the sides, see the patch tests of
docs/theory/implicit_boundaries.md.
"""

from __future__ import annotations

import numpy as np
import pytest
from implicit_blocks import flat, implicit, model_of, steps_of

from tilth.arrays import Floats
from tilth.boundaries.surfaces.boundary import Implicit
from tilth.boundaries.surfaces.motion import rotation_matrix
from tilth_verification.cases import varied

SIDE = 2.0
LOWER = [(0.0, 0.0), (0.1, 0.2), (0.37, 0.05), (0.03, 0.11)]
"""Places of a corner: those of the sides in the cells differ."""


def variation(boundary: Implicit) -> float:
    """Coefficient of variation of the normal traction where the boundary bears [-]."""
    assert boundary.quadrature is not None
    normal: Floats = (boundary.carried * boundary.quadrature.normal).sum(axis=1)
    bears = normal != 0.0
    traction, weight = normal[bears], boundary.quadrature.weight[bears]
    mean = np.average(traction, weights=weight)
    return float(np.sqrt(np.average((traction - mean) ** 2, weights=weight)) / abs(mean))


@pytest.mark.slow
@pytest.mark.parametrize("cell", [0.25, 0.125])
@pytest.mark.parametrize("lower", LOWER)
@pytest.mark.parametrize(("angle", "bound"), [(17.0, 0.02), (30.0, 0.02), (45.0, 0.04)])
def test_traction_of_a_uniformly_pressed_block(
    angle: float, bound: float, lower: tuple[float, float], cell: float
) -> None:
    """Pressed by 1 % between four rollers; on the base at rest and on the plane that presses."""
    along, across = rotation_matrix(angle, None, 2).T
    corner = np.array(lower)
    far = corner + SIDE * (along + across)
    pressed = -0.01 * SIDE * across
    walls = [
        implicit("base", flat(corner, across)),
        implicit("top", flat(far, -across), displacement=dict(zip("xy", pressed, strict=True))),
        implicit("left", flat(corner, along)),
        implicit("right", flat(far, -along)),
    ]
    box = {"type": "box", "lower": corner, "upper": corner + SIDE, "angle": angle}
    model = model_of("plane_strain", "gimp", box, walls, loads=[])
    changes = {"grid.cell_size": cell, "bodies.0.points": None, "bodies.0.points_per_cell": 2}
    simulation, _ = steps_of(varied(model, changes))
    for boundary in simulation.state.implicit[:2]:
        assert variation(boundary) < bound, boundary.name
