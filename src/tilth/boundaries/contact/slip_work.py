# SPDX-License-Identifier: BSD-3-Clause
"""The work of contact's tractions on slips and gaps: a body's work that is not on the soil."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.boundaries.contact.law import ContactResponse
from tilth.boundaries.contact.patches import Patches


@dataclass(frozen=True)
class SlipWork:
    """Work of the tractions of a surface on slips and gaps in a step [force length].

    Attributes:
        total: work of the surface, its force times its own motion, less that on the soil.
        friction: what friction dissipates of it, by the slips; not negative.
        gaps: what the tractions take of it where gaps close or open in the step: the normal ones of
            soil that comes into contact or leaves it, and of gaps that points carry in contact,
            whose mean over a patch is not zero as soon as the patches are others; and the shear
            tractions of soil that leaves against them.
        normal: integral of the normal traction over the surface at the end [force], tension > 0.
    """

    total: float
    friction: float
    gaps: float
    normal: float


def slip_work(
    parts: Sequence[tuple[Patches, Floats, ContactResponse]], normal_before: float | None
) -> SlipWork:
    """Returns the work of the tractions on slips and gaps in the step.

    By the trapezoidal rule, as all other work. What slides has its shear strength from the start of
    the step on, whatever traction it had while it stuck or slid another way.

    Friction only takes energy. By the trapezoidal rule half of the traction at the start acts on
    all of the motion of soil that comes loose, also against it, as where this soil springs back by
    its Poisson ratio; in truth the traction is gone before. What it gives there is no friction, but
    an error of the rule, as that of the normal traction on the gap that opens.

    Args:
        parts: patches with the mean gaps and slips (k, dim) of their multipliers at the end of the
            step, and the response to them.
        normal_before: `SlipWork.normal` of the last step, of which not all is carried where points
            have left the contact since then; None as carried.
    """
    carried = sum(float(patch.area @ patch.before[:, 0]) for patch, _, _ in parts)
    scale = 1.0 if normal_before is None or carried == 0.0 else normal_before / carried
    total = friction = gaps = normal = 0.0
    for patch, end, response in parts:
        before, sliding = scale * patch.before, response.sliding
        strength = patch.law_before.strength(-before[:, 0])[0]
        before[sliding, 1:] = strength[sliding, None] * response.slip[sliding]
        mean = 0.5 * (before + response.traction)
        work = patch.area * (mean[:, 1:] * end[:, 1:]).sum(axis=1)
        closing = float((patch.area * mean[:, 0]) @ (end[:, 0] - patch.gap))
        slides = work[sliding | ~response.closed]
        total += float(work.sum()) + closing
        friction += float(np.maximum(slides, 0.0).sum())
        gaps += closing + float(np.minimum(slides, 0.0).sum())
        normal += float(patch.area @ response.traction[:, 0])
    return SlipWork(total, friction, gaps, normal)
