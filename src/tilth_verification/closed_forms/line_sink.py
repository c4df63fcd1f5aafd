# SPDX-License-Identifier: BSD-3-Clause
"""Settlement above a line sink in an incompressible elastic layer: a deep tunnel that contracts.

The layer 0 <= y <= B has a free surface at B and a rigid base, and smooth walls at x = 0 and x = L.
The sink is at x = 0; by symmetry it takes up the area V of which half lies in the layer. With the
modes cos(k x), k = n pi / L, n >= 1, the displacement is the sum of

* the gradient of phi_n cos(k x), phi_n = V exp(-k |y - y0|) / (2 k L): that of the sinks of the
  walls' images in the plane without surface and base, free of pressure, and
* the field of a stream function f_n(y) sin(k x), with f_n in the span of exp(k y), exp(-k y),
  y exp(k y) and y exp(-k y), which solves the equations of equilibrium without change of volume.
  Its four factors follow from the stresses at the surface, which vanish, and from the base.

The mean of the settlement is V / (2 L). With B and L much greater than the depth h the settlement
becomes V h / (pi (x^2 + h^2)): C. Sagaseta (1987), Analysis of undrained soil deformation due to
ground loss, Géotechnique 37, 301-320; A. Verruijt & J.R. Booker (1996), Surface settlements due to
deformation of a tunnel in an elastic half plane, Géotechnique 46, 753-756, with nu 0.5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats

DECAY = 45.0
"""Modes with k h beyond it are left out: exp(-45) is below round-off."""


@dataclass(frozen=True)
class LineSink:
    """The sink in its layer.

    Attributes:
        lost: area V that the whole sink takes up [length^2].
        depth: of the sink below the surface [length].
        thickness: of the layer [length].
        width: distance of the walls [length].
        rough_base: whether the base holds the soil along it, not only across.
    """

    lost: float
    depth: float
    thickness: float
    width: float
    rough_base: bool = True

    def settlement(self, x: Floats) -> Floats:
        """Returns the settlement of the surface at x [length], > 0 downwards, shape (n,)."""
        k, factors = self._modes()
        top = np.einsum("nf,nf->n", self._functions(k, self.thickness)[0], factors)
        mode = k * top - self._potential(k, self.thickness)[1]
        cosines = np.cos(np.outer(np.asarray(x), k))
        return np.asarray(0.5 * self.lost / self.width + cosines @ mode)

    def settlement_of_sink(self) -> float:
        """Returns the settlement of the soil around the sink without its own contraction."""
        k, factors = self._modes()
        here = np.einsum("nf,nf->n", self._functions(k, self.thickness - self.depth)[0], factors)
        return float(0.25 * self.lost / self.width + (k * here).sum())

    def _modes(self) -> tuple[Floats, Floats]:
        """Returns the wave numbers (n,) and the factors of the four functions (n, 4)."""
        count = int(np.ceil(DECAY * self.width / (np.pi * self.depth)))
        k = np.asarray(np.pi / self.width * np.arange(1, count + 1), dtype=np.float64)
        top, base = self._functions(k, self.thickness), self._functions(k, 0.0)
        above, below = self._potential(k, self.thickness), self._potential(k, 0.0)
        shear = [f[2] + (k**2)[:, None] * f[0] for f in (base, top)]
        matrix = np.stack(
            [
                top[3] - 3.0 * (k**2)[:, None] * top[1],
                shear[1],
                base[0],
                base[1] if self.rough_base else shear[0],
            ],
            axis=1,
        )
        along_base = k * below[0] if self.rough_base else 2.0 * k * below[1]
        right = np.stack(
            [-2.0 * k * above[2], 2.0 * k * above[1], below[1] / k, along_base], axis=1
        )
        return k, np.linalg.solve(matrix, right[..., None])[..., 0]

    def _potential(self, k: Floats, y: float) -> tuple[Floats, Floats, Floats]:
        """Returns phi and its first two derivatives by y at a height other than the sink's."""
        above = y - (self.thickness - self.depth)
        phi: Floats = self.lost / (2.0 * k * self.width) * np.exp(-k * abs(above))
        return phi, (-k if above > 0.0 else k) * phi, k**2 * phi

    def _functions(self, k: Floats, y: float) -> Floats:
        """Returns the four functions and their first three derivatives, shape (4, n, 4)."""
        up, down = np.exp(k * (y - self.thickness)), np.exp(-k * y)
        found = []
        for order in range(4):
            power, sign = k**order, (-1.0) ** order
            rising = up * power * (k * (y - self.thickness) + order)
            falling = down * power * sign * (k * y - order)
            found.append(np.stack([up * power, down * power * sign, rising, falling], axis=1))
        return np.array(found)
