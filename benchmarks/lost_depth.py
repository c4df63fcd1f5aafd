# SPDX-License-Identifier: BSD-3-Clause
"""How much less a load sinks into a cylinder of elastic soil than into a half-space.

The soil has radius and height L, with rollers on its side and base; the force P acts on a small
patch of its surface, radius 1. Far from the patch its displacements are those of a point force, and
what side and base take away is k P / (E L) for the whole patch. Prints k = (u(8 L) - u(L)) E L
/ (7/8 P) for some L, from eight-node elements in axisymmetry on graded meshes, each an extension of
the one before. `python benchmarks/lost_depth.py` (ten seconds).
"""

from __future__ import annotations

import math

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from tilth.arrays import Floats

XI = np.array([-1.0, 1.0, 1.0, -1.0, 0.0, 1.0, 0.0, -1.0])
ETA = np.array([-1.0, -1.0, 1.0, 1.0, -1.0, 0.0, 1.0, 0.0])
GAUSS = list(zip(*np.polynomial.legendre.leggauss(3), strict=True))


def shape_gradients(x: float, y: float) -> tuple[Floats, Floats, Floats]:
    """Returns the eight functions and their derivatives by the local coordinates, (8,) each."""
    a, b = 1.0 + XI * x, 1.0 + ETA * y
    corner = np.arange(8) < 4
    across = XI == 0.0
    value = np.where(
        corner,
        0.25 * a * b * (XI * x + ETA * y - 1.0),
        np.where(across, 0.5 * (1.0 - x * x) * b, 0.5 * (1.0 - y * y) * a),
    )
    by_x = np.where(
        corner,
        0.25 * XI * b * (2.0 * XI * x + ETA * y),
        np.where(across, -x * b, 0.5 * XI * (1.0 - y * y)),
    )
    by_y = np.where(
        corner,
        0.25 * ETA * a * (XI * x + 2.0 * ETA * y),
        np.where(across, 0.5 * ETA * (1.0 - x * x), -y * a),
    )
    return value, by_x, by_y


def sinking(line: Floats, poisson: float) -> float:
    """Returns the displacement at the axis under a unit pressure on r <= 1, E = 1.

    line: coordinates of the elements' corners in both directions, shape (n + 1,).
    """
    count = len(line) - 1
    fine = np.sort(np.concatenate([line, 0.5 * (line[1:] + line[:-1])]))
    even = np.arange(len(fine)) % 2 == 0
    used = even[:, None] | even[None, :]
    number = np.where(used, np.cumsum(used).reshape(used.shape) - 1, -1)
    i, j = (2 * each.ravel() for each in np.indices((count, count)))
    nodes = np.stack([number[i + 1 + int(x), j + 1 + int(y)] for x, y in zip(XI, ETA, strict=True)])
    lame, shear = poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), 0.5 / (1.0 + poisson)
    elastic = np.diag([2.0 * shear] * 3 + [shear])
    elastic[:3, :3] += lame
    width, height = fine[i + 2] - fine[i], fine[j + 2] - fine[j]
    stiffness = np.zeros((len(i), 16, 16))
    for x, of_x in GAUSS:
        for y, of_y in GAUSS:
            value, by_x, by_y = shape_gradients(x, y)
            radius = fine[i + 1] + 0.5 * x * width
            strain = np.zeros((len(i), 4, 16))
            strain[:, 0, 0::2] = strain[:, 3, 1::2] = by_x * (2.0 / width)[:, None]
            strain[:, 1, 1::2] = strain[:, 3, 0::2] = by_y * (2.0 / height)[:, None]
            strain[:, 2, 0::2] = value / radius[:, None]
            weight = 0.5 * math.pi * radius * width * height * of_x * of_y
            stiffness += np.einsum("e,eai,ab,ebj->eij", weight, strain, elastic, strain)
    unknown = np.stack([2 * nodes, 2 * nodes + 1], axis=-1).transpose(1, 0, 2).reshape(-1, 16)
    size = 2 * int(used.sum())
    rows, columns = np.repeat(unknown, 16, axis=1), np.tile(unknown, (1, 16))
    entries = (stiffness.ravel(), (rows.ravel(), columns.ravel()))
    matrix = sp.coo_array(entries, shape=(size, size)).tocsc()
    load = np.zeros(size)
    for element in np.flatnonzero((j == 0) & (fine[i + 2] < 1.0 + 1e-12)):
        for x, of_x in GAUSS:
            radius = fine[i[element] + 1] + 0.5 * x * width[element]
            force = math.pi * radius * width[element] * of_x
            load[2 * nodes[:, element] + 1] += force * shape_gradients(x, -1.0)[0]
    axis, side, base = number[0], number[-1], number[:, -1]
    held = np.concatenate([2 * axis[axis >= 0], 2 * side[side >= 0], 2 * base[base >= 0] + 1])
    free = np.setdiff1d(np.arange(size), held)
    sunk = spsolve(matrix[free][:, free], load[free])
    return float(sunk[np.searchsorted(free, 2 * number[0, 0] + 1)])


def graded(extents: list[float], first: float, ratio: float) -> list[Floats]:
    """Returns corners that reach each extent, the steps growing by a ratio."""
    line, step, found = [*np.linspace(0.0, 1.0, round(1.0 / first) + 1)], first, []
    for extent in extents:
        while line[-1] < extent * (1.0 - 1e-12):
            step *= ratio
            line.append(min(line[-1] + step, extent))
        found.append(np.array(line))
    return found


def main() -> None:
    """Prints the factors."""
    extents = [20.0, 40.0, 80.0]
    for poisson in (0.3, 0.49):
        for extent in extents:
            small, large = (
                sinking(line, poisson) for line in graded([extent, 8.0 * extent], 1.0 / 6.0, 1.12)
            )
            factor = (large - small) * extent / (0.875 * math.pi)
            print(f"nu {poisson:g}, L {extent:g}: k = {factor:.4f}")


if __name__ == "__main__":
    main()
