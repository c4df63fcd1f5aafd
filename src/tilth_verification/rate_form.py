# SPDX-License-Identifier: BSD-3-Clause
"""Von Mises plasticity along a homogeneous path: the rate equations, integrated to round-off."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp
from scipy.linalg import expm, logm
from scipy.optimize import brentq

from tilth.arrays import Floats
from tilth.errors import AnalysisFailed
from tilth.model import VonMises
from tilth_verification.closed_forms.homogeneous import hencky_strain
from tilth_verification.closed_forms.moduli import Moduli

Path = Callable[[float], tuple[Floats, Floats]]
"""A motion: time to the deformation gradient F and its rate dF/dt, shape (3, 3) each."""

RELATIVE_TOLERANCE = 1e-12
SAMPLES = 1000
MAXIMUM_SWITCHES = 100


@dataclass(frozen=True)
class Response:
    """Stress along a path at n given times.

    kirchhoff_stress, cauchy_stress: shape (n, 3, 3) [stress]; plastic_strain: equivalent plastic
    strain, shape (n,).
    """

    kirchhoff_stress: Floats
    cauchy_stress: Floats
    plastic_strain: Floats


def linear_path(end: npt.ArrayLike) -> Path:
    """Returns the path F(t) = I + t (F_end - I), from a 3x3 `end`."""
    rate = np.asarray(end, dtype=float) - np.eye(3)
    return lambda time: (np.eye(3) + time * rate, rate)


def exponential_path(end: npt.ArrayLike) -> Path:
    """Returns the path F(t) = exp(t ln F_end), from a 3x3 `end` with a real logarithm."""
    generator = np.real(logm(np.asarray(end, dtype=float)))

    def path(time: float) -> tuple[Floats, Floats]:
        gradient = expm(time * generator)
        return gradient, generator @ gradient

    return path


def von_mises_response(path: Path, times: Sequence[float], material: VonMises) -> Response:
    """Returns the response to a motion from time 0, without initial stress, at ascending `times`.

    Multiplicative plasticity with the elastic left Cauchy-Green tensor b_e = F G F^T, G the inverse
    plastic metric: tau = K tr(eps) I + 2 mu dev(eps) with eps = 1/2 ln b_e, and the associated rule
    F dG/dt F^T = -2 dp/dt n b_e with n = 3/2 dev(tau) / q (Simo, Comput. Methods Appl. Mech.
    Engrg. 99 (1992) 61-112). Since n has the axes of b_e, n : d(eps)/dt = n : d - 3/2 dp/dt with
    the rate of deformation d, so q = Y0 + H p holds if dp/dt = 2 mu n : d / (3 mu + H).
    G stays fixed while the state is elastic; an eighth-order Runge-Kutta method integrates it while
    it is not, from the onset of yield to where n : d turns negative; stress and plastic strain are
    converged to 1e-10 of their size. Yielding that lasts less than a thousandth of the time is not
    detected. Raises AnalysisFailed for a motion too rough to follow.
    """
    body = _Body(path, material)
    time, metric, hardening = 0.0, np.eye(3), 0.0
    states = []
    plastic = False
    switches = 0
    for target in times:
        while time < target:
            if plastic:
                time, metric, hardening, plastic = body.flow(time, target, metric, hardening)
            else:
                onset = body.onset(time, target, metric, hardening, target / SAMPLES)
                plastic, time = onset is not None, target if onset is None else onset
            switches += time < target
            if switches > MAXIMUM_SWITCHES:
                raise _too_rough(time)
        states.append((body.kirchhoff(target, metric), np.linalg.det(path(target)[0]), hardening))
    kirchhoff = np.array([stress for stress, _, _ in states])
    jacobian = np.array([volume for _, volume, _ in states])
    plastic_strain = np.array([p for _, _, p in states])
    return Response(kirchhoff, kirchhoff / jacobian[:, None, None], plastic_strain)


@dataclass(frozen=True)
class _Body:
    path: Path
    material: VonMises

    def kirchhoff(self, time: float, metric: Floats) -> Floats:
        strain, moduli = self._elastic_strain(time, metric), Moduli.of(self.material)
        volumetric: Floats = np.trace(strain) * np.eye(3)
        return moduli.bulk * volumetric + 2.0 * moduli.shear * (strain - volumetric / 3.0)

    def onset(
        self, start: float, end: float, metric: Floats, hardening: float, step: float
    ) -> float | None:
        """The first time of an elastic stretch at which the yield surface is reached, or None."""
        count = max(2, math.ceil((end - start) / step) + 1)
        previous = start
        for time in np.linspace(start, end, count)[1:]:
            if self._excess(time, metric, hardening) > 0.0:
                if self._excess(previous, metric, hardening) >= 0.0:
                    raise _too_rough(time)
                excess: Callable[..., float] = partial(
                    self._excess, metric=metric, hardening=hardening
                )
                return float(brentq(excess, previous, time, xtol=1e-15, rtol=1e-15))
            previous = time
        return None

    def flow(
        self, start: float, end: float, metric: Floats, hardening: float
    ) -> tuple[float, Floats, float, bool]:
        """Time, G, p where plastic flow stops or `end` is reached, and whether it still flows."""

        def rate(time: float, state: Floats) -> Floats:
            normal, multiplier, gradient = self._rates(time, state[:9].reshape(3, 3))
            mixed = np.linalg.solve(gradient, normal @ gradient) @ state[:9].reshape(3, 3)
            return np.append(-2.0 * multiplier * mixed.ravel(), multiplier)

        def unloading(time: float, state: Floats) -> float:
            return self._rates(time, state[:9].reshape(3, 3))[1]

        unloading.terminal, unloading.direction = True, -1.0  # type: ignore[attr-defined]
        solution = solve_ivp(
            rate,
            (start, end),
            np.append(metric.ravel(), hardening),
            method="DOP853",
            rtol=RELATIVE_TOLERANCE,
            atol=RELATIVE_TOLERANCE * 1e-2,
            events=unloading,
        )
        if not solution.success:
            raise _too_rough(float(solution.t[-1]))
        state = solution.y[:, -1]
        return float(solution.t[-1]), state[:9].reshape(3, 3), float(state[9]), solution.status == 0

    def _elastic_strain(self, time: float, metric: Floats) -> Floats:
        return hencky_strain(self.path(time)[0] @ np.linalg.cholesky(0.5 * (metric + metric.T)))

    def _excess(self, time: float, metric: Floats, hardening: float) -> float:
        """Mises stress above the current yield stress [stress]."""
        strain = self._elastic_strain(time, metric)
        deviator = strain - np.trace(strain) / 3.0 * np.eye(3)
        mises = 2.0 * Moduli.of(self.material).shear * math.sqrt(1.5) * np.linalg.norm(deviator)
        limit = self.material.initial_yield_stress + self.material.hardening_modulus * hardening
        return float(mises - limit)

    def _rates(self, time: float, metric: Floats) -> tuple[Floats, float, Floats]:
        """Flow direction n, dp/dt (negative: unloading) and F."""
        gradient, gradient_rate = self.path(time)
        strain, shear = self._elastic_strain(time, metric), Moduli.of(self.material).shear
        deviator = strain - np.trace(strain) / 3.0 * np.eye(3)
        normal = math.sqrt(1.5) * deviator / np.linalg.norm(deviator)
        velocity_gradient = gradient_rate @ np.linalg.inv(gradient)
        power = 2.0 * shear * float(np.sum(normal * velocity_gradient))
        return normal, power / (3.0 * shear + self.material.hardening_modulus), gradient


def _too_rough(time: float) -> AnalysisFailed:
    return AnalysisFailed(
        f"the motion switches between elastic and plastic too quickly to follow at time {time:.6g}",
        "use a smoother motion",
    )
