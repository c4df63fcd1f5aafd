# SPDX-License-Identifier: BSD-3-Clause
"""A layer that consolidates at any strain, by finite volumes in material coordinates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_banded
from scipy.optimize import brentq

from tilth.arrays import Floats

Law = Callable[[Floats], Floats]
"""Of the stretch, shape (n,) -> (n,)."""


@dataclass(frozen=True)
class LayerAtTime:
    """The layer at one time.

    Attributes:
        pressure: excess at the sealed end [stress].
        settlement: of the top [length].
        place, profile: distance from the drain now [length] and excess pressure [stress] of the
            material, shape (n,) each.
    """

    pressure: float
    settlement: float
    place: Floats
    profile: Floats


@dataclass(frozen=True)
class MaterialColumn:
    """A layer, drained at one end and sealed at the other, loaded at once.

    With the stretch l of the material at the initial distance Z from the drain, the excess pressure
    v = q + w Z - s(l) and what flows through the material relative to it (Gibson, England and
    Hussey 1967)

        dl/dt = d/dZ (kappa(l) / l dv/dZ),  v = 0 at Z = 0,  dv/dZ = 0 at Z = H.

    Cells of equal initial height, steps of backward Euler that grow with the root of time, and
    extrapolation from two grids, the finer one with twice the cells and four times the steps: it
    has nothing in common with a computation that moves points through a grid.

    height: H [length]. stress: effective axial Cauchy stress s(l), compression positive, without
    that of the start. conductivity: kappa(l) [length^4 / (force time)]. load: q [stress]. weight:
    w, of the soil under water over its initial volume [force / length^3], with the drain at the
    top; none if it is at the base.
    """

    height: float
    stress: Law
    conductivity: Law
    load: float
    weight: float = 0.0

    @cached_property
    def drained(self) -> float:
        """The stretch at the drain [-]."""
        return self._stretch(self.load)

    def _stretch(self, stress: float) -> float:
        return float(brentq(lambda x: float(self.stress(np.array([x]))[0]) - stress, 0.4, 1.0))

    @cached_property
    def final(self) -> float:
        """Settlement in the end [length]."""
        place, share = np.polynomial.legendre.leggauss(20)
        depth = 0.5 * self.height * (place + 1.0)
        stretch = [self._stretch(self.load + self.weight * each) for each in depth]
        return self.height * (1.0 - 0.5 * float(share @ np.array(stretch)))

    def _pressure(self, stretch: Floats) -> Floats:
        """Returns the excess pressure of cells of equal initial height [stress], shape (n,)."""
        distance = (np.arange(len(stretch)) + 0.5) * self.height / len(stretch)
        return np.asarray(self.load + self.weight * distance - self.stress(stretch))

    def at(self, times: Sequence[float], cells: int = 40, steps: int = 40) -> list[LayerAtTime]:
        """Returns the layer at some times, increasing.

        cells: of the coarser grid. steps: in it, from each time to the next.
        """
        coarse = self._march(times, cells, steps)
        fine = self._march(times, 2 * cells, 4 * steps)
        return [
            LayerAtTime(
                (4.0 * b.pressure - a.pressure) / 3.0, (4.0 * b.settlement - a.settlement) / 3.0,
                b.place, b.profile,
            )
            for a, b in zip(coarse, fine, strict=True)
        ]  # fmt: skip

    def _march(self, times: Sequence[float], cells: int, steps: int) -> list[LayerAtTime]:
        stretch, size = np.ones(cells), self.height / cells
        found, begun = [], 0.0
        for time in times:
            roots = np.linspace(begun**0.5, time**0.5, steps + 1)
            for step in np.diff(roots**2):
                stretch = self._step(stretch, float(step), size)
            begun = time
            pressure = self._pressure(stretch)
            top = float(9.0 * pressure[-1] - pressure[-2]) / 8.0  # without gradient there
            place = size * (np.cumsum(stretch) - 0.5 * stretch)
            found.append(LayerAtTime(top, self.height - size * stretch.sum(), place, pressure))
        return found

    def _step(self, before: Floats, step: float, size: float) -> Floats:
        stretch, n = before.copy(), len(before)
        for _ in range(50):
            residual = self._residual(stretch, before, step, size)
            bands = np.zeros((3, n))
            for colour in range(3):  # three columns of a tridiagonal matrix do not meet
                moved, own = stretch.copy(), np.arange(colour, n, 3)
                moved[own] += 1e-7
                change = (self._residual(moved, before, step, size) - residual) / 1e-7
                for shift in (-1, 0, 1):
                    rows = own + shift
                    inside = (rows >= 0) & (rows < n)
                    bands[1 + shift, own[inside]] = change[rows[inside]]
            correction = solve_banded((1, 1), bands, -residual)
            largest = float(np.abs(correction / stretch).max())
            stretch = stretch + correction * min(1.0, 0.3 / max(largest, 1e-300))
            if largest < 1e-11:
                break
        return stretch

    def _residual(self, stretch: Floats, before: Floats, step: float, size: float) -> Floats:
        pressure = self._pressure(stretch)
        ends = np.array([self.drained])
        through = self.conductivity(stretch) / stretch
        first = 0.5 * (through[0] + float(self.conductivity(ends)[0] / ends[0]))
        flow = np.zeros(len(stretch) + 1)  # upwards negative: towards the drain
        flow[0] = first * pressure[0] / (0.5 * size)
        flow[1:-1] = 0.5 * (through[1:] + through[:-1]) * np.diff(pressure) / size
        return np.asarray(stretch - before - step / size * np.diff(flow))


def hencky(modulus: float) -> Law:
    """Returns the stress of Hencky's law in uniaxial strain, -M ln(l) / l."""
    return lambda stretch: np.asarray(-modulus * np.log(stretch) / stretch)


def constant(conductivity: float) -> Law:
    """Returns a conductivity that does not change."""
    return lambda stretch: np.full_like(stretch, conductivity)


def kozeny_carman(conductivity: float, porosity: float) -> Law:
    """Returns kappa ~ n^3 / (1 - n)^2, n = 1 - (1 - n0) / l; porosity: n0."""

    def of(stretch: Floats) -> Floats:
        solid = (1.0 - porosity) / stretch
        ratio = (1.0 - solid) ** 3 / solid**2 * (1.0 - porosity) ** 2 / porosity**3
        return np.asarray(conductivity * ratio)

    return of


def taylor(conductivity: float, porosity: float, index: float) -> Law:
    """Returns log10 kappa ~ e / C_k, 1 + e = l / (1 - n0); porosity: n0. index: C_k."""
    swelling = 1.0 / (1.0 - porosity)
    return lambda stretch: np.asarray(conductivity * 10.0 ** ((stretch - 1.0) * swelling / index))


def power_law(conductivity: float, porosity: float, exponent: float) -> Law:
    """Returns kappa ~ e^m, e = l / (1 - n0) - 1; porosity: n0. exponent: m."""
    return lambda stretch: np.asarray(
        conductivity * ((stretch - 1.0 + porosity) / porosity) ** exponent
    )
