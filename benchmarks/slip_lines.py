# SPDX-License-Identifier: BSD-3-Clause
"""Mean pressure under a shallow rigid sphere, and a flat circular footing, in Tresca clay.

By the method of characteristics in axisymmetry, with the hoop stress equal to the lesser principal
stress (A. Haar, T. von Karman), as for the footings of Shield (1955) and Eason & Shield (1960).
The clay is weightless. With compression positive, s_u = 1, the mean p of the stresses in the plane,
the angle psi of the greater one from the radius r, and z downwards, along the lines at psi + 45 and
psi - 45 degrees

    dp + 2 dpsi + (dr + dz) / r = 0,        dp - 2 dpsi + (dr - dz) / r = 0.

Beside the contact the clay is level, or has a lip that rises to the rim: it falls exponentially,
and has the volume that the sphere has displaced. Of it only c^2 = a^2 / (2 R d) is assumed, for the
depth d; simulations have 1.4 smooth, 1.3 rough. `python benchmarks/slip_lines.py` (half a minute).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

State = tuple[float, float, float, float]
"""r, z, p, psi at a point; lengths over the radius a of the contact."""
Profile = Callable[[float], tuple[float, float]]
"""Depth of the clay's surface below the rim, and the angle by which it falls, over r >= 1."""
SPREAD = 1.4
"""c^2 [-]."""
CENTRE = 0.02
"""Radius within which the pressure is taken to be uniform [-]."""
LINES, FAN, SHARE = 100, 50, 0.6
"""Lines that begin beside the contact, on this share of a, and lines of the fan at the rim."""


def level(_: float) -> tuple[float, float]:
    """Returns the profile of level clay."""
    return 0.0, 0.0


def lip(ratio: float) -> Profile:
    """Returns the profile of the lip at a / R: its height is that of the rim above level clay."""
    height = 0.5 * ratio * (1.0 - 1.0 / SPREAD)
    volume = 0.5 * ratio * (1.0 / SPREAD - 0.5)  # over pi: what the pit lacks to be filled by it
    length = math.sqrt(0.25 + 0.5 * volume / height) - 0.5

    def profile(r: float) -> tuple[float, float]:
        rest = height * math.exp((1.0 - r) / length)
        return height - rest, math.atan(rest / length)

    return profile


def crossing(first: State, second: State) -> State:
    """Returns where the line at psi + 45 degrees of `first` meets that at psi - 45 of `second`."""
    r1, z1, p1, psi1 = first
    r2, z2, p2, psi2 = second
    r, z, p, psi = r2, z2, 0.5 * (p1 + p2), 0.5 * (psi1 + psi2)
    for _ in range(50):
        plus, minus = 0.5 * (psi + psi1) + math.pi / 4, 0.5 * (psi + psi2) - math.pi / 4
        along = (r2 - r1) * math.sin(minus) - (z2 - z1) * math.cos(minus)
        along /= math.sin(minus - plus)
        r, z = r1 + along * math.cos(plus), z1 + along * math.sin(plus)
        total = p1 + 2.0 * psi1 - 2.0 * (r - r1 + z - z1) / (r + r1)
        less = p2 - 2.0 * psi2 - 2.0 * (r - r2 - z + z2) / (r + r2)
        old, p, psi = psi, 0.5 * (total + less), 0.25 * (total - less)
        if abs(psi - old) < 1e-13:
            break
    return r, z, p, psi


def at_face(point: State, ratio: float) -> State:
    """Returns where the line at psi - 45 degrees from a point meets the smooth sphere."""
    r0, z0, p0, psi0 = point
    r = z = psi = 0.0
    following = r0
    for _ in range(100):
        r = max(following, 0.0)
        z = (
            (math.sqrt(1.0 - (ratio * r) ** 2) - math.sqrt(1.0 - ratio**2)) / ratio
            if ratio
            else 0.0
        )
        psi = 0.5 * math.pi - math.asin(ratio * r)
        following = r0 + (z - z0) / math.tan(0.5 * (psi + psi0) - 0.25 * math.pi)
        if abs(following - r) < 1e-14:
            break
    return r, z, p0 + 2.0 * (psi - psi0) - 2.0 * (r - r0 - z + z0) / (r + r0), psi


def rim(profile: Profile, last: float) -> list[State]:
    """Returns the fan at the rim, in which psi grows from that of the clay's surface to `last`."""
    _, start = profile(1.0)
    angles = np.linspace(start, last, FAN + 1).tolist()
    return [(1.0, 0.0, 1.0 + 2.0 * (each - start), each) for each in angles]


def smooth(ratio: float, profile: Profile) -> float:
    """Returns the mean pressure under a smooth sphere with the contact ratio a / R over s_u."""
    line = rim(profile, 0.5 * math.pi - math.asin(ratio))
    face = [line[-1]]
    while face[-1][0] > CENTRE:
        r = 1.0 + SHARE * len(face) / LINES
        depth, angle = profile(r)
        following = [(r, depth, 1.0, angle)]
        for each in line:
            following.append(crossing(each, following[-1]))
        following.append(at_face(following[-1], ratio))
        line = following
        face.append(line[-1])
    r, _, p, _ = np.array(face[:-1]).T
    normal = p + 1.0
    return float(
        np.sum((r[:-1] ** 2 - r[1:] ** 2) * 0.5 * (normal[:-1] + normal[1:]))
        + r[-1] ** 2 * normal[-1]
    )


def rough(last: float, profile: Profile) -> tuple[float, float]:
    """Returns mean pressure over s_u, and psi, at the tip of the cone of clay below a rough face.

    last: psi at the side of this cone, at the rim.
    """
    line = rim(profile, last)
    side = [line[-1]]
    while side[-1][3] > 1.5:
        r = 1.0 + SHARE * len(side) / LINES
        depth, angle = profile(r)
        following = [(r, depth, 1.0, angle)]
        for each in line:
            following.append(crossing(each, following[-1]))
            if following[-1][0] < CENTRE:
                break
        if following[-1][0] < CENTRE:
            break
        line = following
        side.append(line[-1])
    r, z, p, psi = np.array(side).T
    mean = 0.5 * (p[1:] + p[:-1])
    force = np.sum((r[:-1] ** 2 - r[1:] ** 2) * mean + (r[:-1] + r[1:]) * np.diff(z))
    return float(force + r[-1] ** 2 * (p[-1] + 1.0)), float(psi[-1])


def rough_face(profile: Profile) -> tuple[float, float]:
    """Returns the mean pressure over s_u and the inclination of the cone's side at the rim [rad].

    The cone ends on the axis, where psi is 90 degrees. With too small an angle at the rim psi falls
    below that on the way, with too large a one it is above.
    """
    low, high = 0.5 * math.pi, 0.75 * math.pi
    force = math.nan
    for _ in range(12):
        middle = 0.5 * (low + high)
        force, psi = rough(middle, profile)
        low, high = (middle, high) if psi < 0.5 * math.pi else (low, middle)
    return force, 0.75 * math.pi - high


def main() -> None:
    """Prints the factors."""
    print("a / R   smooth, level   with lip   rough, level   with lip   cone and face at the rim")
    for ratio in (0.0, 0.1, 0.2, 0.3):
        heaped = lip(ratio) if ratio else level
        smooth_ones = [smooth(ratio, each) for each in (level, heaped)]
        (flat, _), (force, angle) = rough_face(level), rough_face(heaped)
        slopes = f"{math.degrees(angle):.1f} and {math.degrees(math.asin(ratio)):.1f} degrees"
        row = f"{smooth_ones[0]:13.3f}{smooth_ones[1]:11.3f}{flat:15.3f}{force:11.3f}"
        print(f"{ratio:.1f}  {row}   {slopes}")


if __name__ == "__main__":
    main()
