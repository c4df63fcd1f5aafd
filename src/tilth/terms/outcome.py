# SPDX-License-Identifier: BSD-3-Clause
"""What a term of the balance tells of a converged step: named forces, work, state of contact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields

import numpy as np

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

    @classmethod
    def joined(cls, parts: Sequence[ContactState], dim: int) -> ContactState:
        """Returns one state of several surfaces, none of them if there is no soil near any."""
        if not parts:
            vectors, numbers, flags = np.zeros((0, dim)), np.zeros(0), np.zeros(0, dtype=bool)
            return cls(vectors, vectors, numbers, numbers, vectors, numbers, flags, flags)
        names = [each.name for each in fields(cls)]
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))

    @property
    def area(self) -> float:
        """Area in contact [length^(dim - 1), in axisymmetry length^2]."""
        return float(self.weight[self.in_contact].sum())


@dataclass(frozen=True)
class Work:
    """What a term takes of the work in a step, or gives [force length].

    By the trapezoidal rule; 0 for what the term has no part in.

    Attributes:
        surface: work of a surface in contact, its force times its own motion, less that on soil.
        friction: what friction dissipates of it; not negative.
        gaps: what contact takes of it where gaps close or open.
        damping: what Rayleigh damping dissipates.
        integration: what the time integration dissipates.
        stabilisation: kinetic energy of the ghost mass.
        radiated: energy that leaves through absorbing boundaries less what comes in.
        seepage: what flowing water dissipates, by the flow at the end of the step and the time for
            which it counts, see `WaterInStep.size`; not negative.
    """

    surface: float = 0.0
    friction: float = 0.0
    gaps: float = 0.0
    damping: float = 0.0
    integration: float = 0.0
    stabilisation: float = 0.0
    radiated: float = 0.0
    seepage: float = 0.0


@dataclass(frozen=True, eq=False)
class ContactOutcome:
    """Contact of soil with one boundary, rigid body or other soil body.

    Attributes:
        name: of the boundary, rigid body or pair of bodies.
        state: its points at the end of the step.
        normal: integral of the normal traction over the surface at the end [force], tension > 0.
        is_between_bodies: whether both sides are soil.
    """

    name: str
    state: ContactState
    normal: float
    is_between_bodies: bool


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a term tells of a step, at the displacement of the last evaluation.

    Attributes:
        forces: on the soil at the end of the step [force], shape (nodes, dim), by name of boundary,
            rigid body or pair of bodies; of a pair that on its second body.
        work: in the step.
        ghost_force: of the ghost mass at the end of the step [force], shape (nodes, dim); None
            without one.
        contact: of a term of contact; None for all others.
        outflow: volume of water that leaves the soil in the step through flow boundaries
            [length^dim], in axisymmetry with 2 pi r, shape (nodes, 1), by name of boundary.
    """

    forces: Mapping[str, Floats] = field(default_factory=dict)
    work: Work = field(default_factory=Work)
    ghost_force: Floats | None = None
    contact: ContactOutcome | None = None
    outflow: Mapping[str, Floats] = field(default_factory=dict)
