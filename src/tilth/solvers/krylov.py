# SPDX-License-Identifier: BSD-3-Clause
"""Preconditioned Krylov methods: conjugate gradients, and GMRES for unsymmetric matrices.

Saad, Iterative methods for sparse linear systems (2003): algorithms 9.1 and 9.6. Inner products
are those of `tilth.comm`, which are identical for any number of threads.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from tilth import _core
from tilth.arrays import Floats
from tilth.comm import SERIAL, Communicator, advance, inner, norm, total, two_inner
from tilth.solvers.protocol import Solution, SolveFailed

Operator = Callable[[Floats, Floats], None]
"""Applies an operator to its first argument; writes the result to its second."""


class NotDefinite(SolveFailed):
    """The matrix or the preconditioner of conjugate gradients is not positive definite."""


RESTART = 100
"""Iterations of GMRES after which it restarts from the current solution.

Few systems need so many. Those that do have single modes that the preconditioner does not reduce
(yielding soil); a restart loses these modes, which costs more than the memory of the directions.
"""


def conjugate_gradients(
    product: Operator,
    precondition: Operator,
    right_side: Floats,
    tolerance: float,
    limit: int,
    comm: Communicator = SERIAL,
) -> Solution:
    """Returns the solution of A x = b, for a symmetric positive definite matrix and preconditioner.

    The direction is made conjugate by the difference of the residuals (Polak and Ribiere), which
    tolerates a preconditioner in single precision. That difference is the last step length times
    the last product.

    Raises:
        NotDefinite: the matrix or the preconditioner is not positive definite.
        SolveFailed: more than `limit` iterations to ||b - A x|| <= tolerance ||b||.
    """
    size = norm(comm, right_side)
    if size == 0.0:
        return Solution(np.zeros_like(right_side), 0, 0.0)
    x, r = np.zeros_like(right_side), right_side.copy()
    p, q, z = np.zeros_like(r), np.zeros_like(r), np.empty_like(r)
    z_r, length = 1.0, 0.0
    for iteration in range(1, limit + 1):
        precondition(r, z)
        z_r_before = z_r
        z_r, z_q = two_inner(comm, z, r, q)
        _core.combine(1.0, z, -length * z_q / z_r_before, p)
        product(p, q)
        p_q = inner(comm, p, q)
        if not (z_r > 0.0 and p_q > 0.0):
            raise NotDefinite("a matrix or preconditioner that is not positive definite")
        length = z_r / p_q
        if advance(comm, length, p, q, x, r) <= (tolerance * size) ** 2:
            product(x, q)
            r = right_side - q
            residual = norm(comm, r) / size
            if residual <= 2.0 * tolerance:
                return Solution(x, iteration, residual)
            p[:] = 0.0
    raise _not_converged(limit, norm(comm, r) / size)


def flexible_gmres(
    product: Operator,
    precondition: Operator,
    right_side: Floats,
    tolerance: float,
    limit: int,
    comm: Communicator = SERIAL,
) -> Solution:
    """Returns the solution of A x = b by flexible GMRES, preconditioned from the right.

    Raises:
        SolveFailed: more than `limit` iterations to ||b - A x|| <= tolerance ||b||.
    """
    size = norm(comm, right_side)
    if size == 0.0:
        return Solution(np.zeros_like(right_side), 0, 0.0)
    x, r = np.zeros_like(right_side), right_side
    residual, iterations = 1.0, 0
    while iterations < limit:
        basis = [r / (residual * size)]
        directions: list[Floats] = []
        triangle = np.zeros((RESTART + 1, RESTART))
        rotations: list[tuple[float, float]] = []
        rotated = [residual * size]  # right side of the least-squares problem, rotated
        while len(directions) < RESTART and iterations < limit:
            k = len(directions)
            iterations += 1
            directions.append(np.empty_like(r))
            w = np.empty_like(r)
            precondition(basis[k], directions[k])
            product(directions[k], w)
            _orthogonalise(comm, basis, w, triangle[:, k])
            length = norm(comm, w)
            column = triangle[:, k]
            for i, (c, s) in enumerate(rotations):
                column[i], column[i + 1] = (
                    c * column[i] + s * column[i + 1],
                    (c * column[i + 1] - s * column[i]),
                )
            radius = math.hypot(column[k], length)
            if not (0.0 < radius < math.inf):
                raise SolveFailed("the linear system is singular")
            rotations.append((column[k] / radius, length / radius))
            column[k] = radius
            rotated.append(-rotations[k][1] * rotated[k])
            rotated[k] *= rotations[k][0]
            if abs(rotated[-1]) <= tolerance * size or length == 0.0:
                break
            basis.append(w / length)
        n = len(directions)
        coefficients = np.zeros(n)
        for i in reversed(range(n)):
            solved = triangle[i, i + 1 : n] @ coefficients[i + 1 :]
            coefficients[i] = (rotated[i] - solved) / triangle[i, i]
        for coefficient, direction in zip(coefficients, directions, strict=True):
            _core.combine(coefficient, direction, 1.0, x)
        product(x, w)
        r = right_side - w
        residual = norm(comm, r) / size
        if residual <= 2.0 * tolerance:
            return Solution(x, iterations, residual)
        if not math.isfinite(residual):
            break
    raise _not_converged(iterations, residual)


def _orthogonalise(
    comm: Communicator, basis: Sequence[Floats], w: Floats, products: Floats
) -> None:
    """Subtracts from w, in place, its parts along the basis, and adds these to `products`.

    One process takes one direction after the other. Several take all at once, which is one message,
    and repeat it for the round-off (Giraud, Langou and Rozloznik 2005).
    """
    if comm.size == 1:
        for i, v in enumerate(basis):
            products[i] = _core.inner(v, w)
            _core.combine(-products[i], v, 1.0, w)
        return
    for _ in range(2):
        parts = total(comm, np.array([_core.inner(v, w) for v in basis]))
        for part, v in zip(parts, basis, strict=True):
            _core.combine(-part, v, 1.0, w)
        products[: len(basis)] += parts


def _not_converged(iterations: int, residual: float) -> SolveFailed:
    return SolveFailed(f"no solution in {iterations} iterations (relative residual {residual:.1e})")
