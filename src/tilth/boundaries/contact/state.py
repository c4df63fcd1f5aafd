# SPDX-License-Identifier: BSD-3-Clause
"""Contact and rigid bodies at the end of a step, for output and tracked quantities."""

from __future__ import annotations

from dataclasses import dataclass

from tilth.arrays import Flags, Floats


@dataclass(frozen=True, eq=False)
class ContactState:
    """The candidate points of a contact surface; n points, `dim` is 2 or 3.

    Attributes:
        position: [length], shape (n, dim).
        normal: unit, into the soil, shape (n, dim).
        weight: area of the point's part of the surface [length^(dim - 1)], in axisymmetry with
            2 pi r [length^2], shape (n,).
        normal_stress: [stress], tension positive, shape (n,).
        shear_stress: of the surface on the soil [stress], a vector in the plane of the surface,
            shape (n, dim).
        gap: distance along the normal to the surface of the soil [length], > 0 open, shape (n,).
        sliding: whether the soil slides along the surface, shape (n,).
        in_contact: whether the soil touches it, shape (n,).
    """

    position: Floats
    normal: Floats
    weight: Floats
    normal_stress: Floats
    shear_stress: Floats
    gap: Floats
    sliding: Flags
    in_contact: Flags

    @property
    def area(self) -> float:
        """Area in contact [length^(dim - 1), in axisymmetry length^2]."""
        return float(self.weight[self.in_contact].sum())


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
