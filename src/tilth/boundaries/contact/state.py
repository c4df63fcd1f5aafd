# SPDX-License-Identifier: BSD-3-Clause
"""Contact and rigid bodies at the end of a step, for output and tracked quantities."""

from __future__ import annotations

from dataclasses import dataclass

from tilth.arrays import Floats


@dataclass(frozen=True, eq=False)
class RigidBodyState:
    """Motion of a rigid body since the start, and what the soil exerts on it.

    Attributes:
        displacement: of its centre [length], shape (dim,).
        rotation: rotation vector [rad], shape (3,); in the plane only z.
        force: of the soil on the body [force], shape (dim,).
        moment: of that force about the body's centre [force length], shape (3,).
    """

    displacement: Floats
    rotation: Floats
    force: Floats
    moment: Floats
