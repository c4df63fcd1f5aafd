# SPDX-License-Identifier: BSD-3-Clause
"""Solution of systems with unknowns that belong to no node (docs/decisions/0020-unknowns.md).

Of [[A, B], [C, D]] [x; g] = [r; s] a direct solver factorises the whole matrix. An iterative
solver has A only: g follows from the Schur complement S = D - C A^-1 B, which takes one solution
with A for each global unknown.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from tilth.algebra.border import Border
from tilth.arrays import Floats
from tilth.comm import norm
from tilth.solvers.protocol import Matrix, SolveFailed, Solver
from tilth.solvers.system import LinearSystem

COLUMN_TOLERANCE = 1e-10
"""Relative residual of A^-1 B in the Schur complement."""

LARGEST_CONDITION = 1e12
"""Ratio of the terms of the Schur complement to their difference from which it counts as singular:
four digits of double precision remain."""

EQUILIBRATIONS = 5
"""Passes of the equilibration of a bordered matrix."""

MAXIMUM_REFINEMENTS = 3
"""Maximum number of refinements of a condensed solution."""


def factorise_bordered(
    solver: Solver, system: LinearSystem, border: Border
) -> Callable[[Floats], Floats]:
    """Factorises the whole matrix by a direct solver; its unknowns are `system.free`, then g.

    The matrix is equilibrated before, and whether it is singular is judged after that: soil, weak
    supports and rigid bodies have stiffnesses that differ by many orders of magnitude.

    Args:
        solver: the direct solver.
        system: contains A.
        border: contains B, C and D, scaled.

    Returns:
        A function that solves for one right side, shape (n,).

    Raises:
        SolveFailed: if the matrix is singular or nearly so.
    """
    columns, rows = (
        part.reshape(border.unknowns, -1)[:, system.free] for part in (border.columns, border.rows)
    )
    return factorise_with_border(solver, system.matrix(), border, columns, rows)


def factorise_with_border(
    solver: Solver, matrix: Matrix, border: Border, of_columns: Floats, of_rows: Floats
) -> Callable[[Floats], Floats]:
    """As `factorise_bordered`, for any n unknowns of A.

    of_columns, of_rows: what the border has at these unknowns, shape (m, n).
    """
    whole = _bordered_matrix(matrix, of_columns, of_rows, border.corner)
    matrix, rows, columns = equilibrated(whole)
    solver.setup(matrix)
    unknowns, free = of_columns.shape
    inverse = np.empty((unknowns, unknowns))  # of the Schur complement
    for k in range(unknowns):
        unit = np.zeros(free + unknowns)
        unit[free + k] = 1.0
        inverse[:, k] = solver.solve(unit).x[free:]
    parts = (border.columns, border.rows, *border.others.values(), border.corner)
    known = all(bool(np.isfinite(part).all()) for part in parts)
    require_regular(inverse, 1.0 if known else math.nan, LARGEST_CONDITION)
    return lambda right_side: columns * solver.solve(rows * right_side).x


def equilibrated(matrix: Matrix) -> tuple[Matrix, Floats, Floats]:
    """Returns R A C with rows and columns whose largest entries are near 1, and R and C.

    Each pass divides rows and columns by the square roots of their largest entries (Ruiz 2001).
    The factors are powers of two, so that no digit is lost. A row or column of zeros stays as it
    is, and so does a matrix with entries that are not numbers, which the solver will name.

    matrix: A, shape (n, n).

    Returns:
        R A C, and the diagonals R and C, shape (n,) each.
    """
    count = len(matrix.indptr) - 1
    column = np.repeat(np.arange(count), np.diff(matrix.indptr))
    rows, columns = np.ones(count), np.ones(count)
    size = np.abs(matrix.data)
    if not np.isfinite(size).all():
        return matrix, rows, columns
    for _ in range(EQUILIBRATIONS):
        largest = np.zeros((2, count))
        np.maximum.at(largest[0], matrix.indices, size)
        np.maximum.at(largest[1], column, size)
        largest[largest == 0.0] = 1.0
        by = np.exp2(-np.round(0.5 * np.log2(largest)))
        rows, columns = rows * by[0], columns * by[1]
        size = size * by[0][matrix.indices] * by[1][column]
    scaled = matrix.data * rows[matrix.indices] * columns[column]
    return Matrix(scaled, matrix.indices, matrix.indptr, matrix.comm), rows, columns


def _bordered_matrix(matrix: Matrix, columns: Floats, rows: Floats, corner: Floats) -> Matrix:
    """Returns the whole matrix, its pattern symmetric, with the global unknowns last."""
    import scipy.sparse as sp  # takes 0.2 s: only where it is used

    unknowns, free = columns.shape
    number, index = np.nonzero((columns != 0.0) | (rows != 0.0))
    place = np.indices((unknowns, unknowns)).reshape(2, -1)
    shape = (free, unknowns)
    whole = sp.bmat(
        [
            [matrix.in_scipy(), sp.coo_matrix((columns[number, index], (index, number)), shape)],
            [
                sp.coo_matrix((rows[number, index], (number, index)), shape[::-1]),
                sp.coo_matrix((corner.ravel(), tuple(place)), (unknowns, unknowns)),
            ],
        ],
        format="csc",
    )
    whole.sort_indices()
    indices, indptr = (part.astype(np.int32, copy=False) for part in (whole.indices, whole.indptr))
    return Matrix(whole.data, indices, indptr, matrix.comm)


def solve_condensed(
    system: LinearSystem,
    border: Border,
    solve: Callable[[Floats, float], Floats],
    right_side: Floats,
    global_right_side: Floats,
    tolerance: float,
) -> tuple[Floats, Floats]:
    """Solves by elimination of the nodal unknowns, and corrects for the true residual.

    Args:
        system: contains A, which must not be singular.
        border: contains B, C and D, scaled.
        solve: returns A^-1 times a nodal vector, to a relative residual; zero where constrained.
        right_side: r, shape (nodes, components).
        global_right_side: s, scaled, shape (m,).
        tolerance: largest norm of the residual, relative to that of the right side.

    Returns:
        x, shape (nodes, components), zero where constrained, and g, scaled, shape (m,).

    Raises:
        SolveFailed: A or the Schur complement is singular or nearly so.
    """
    comm, own, free = system.comm, system.active.owned, ~system.constrained
    solved = [solve(column, COLUMN_TOLERANCE) for column in border.columns]

    def size(nodal: Floats, of_border: Floats) -> float:
        return math.hypot(norm(comm, nodal[own]), float(np.linalg.norm(of_border)))

    product = np.stack([system.inner_products(border.rows, x) for x in solved], axis=1)
    schur = border.corner - product
    rows = np.abs(border.rows)
    cancels = np.stack([system.inner_products(rows, np.abs(x)) for x in solved], axis=1)
    try:
        inverse: Floats = np.asarray(np.linalg.inv(schur), dtype=np.float64)
    except np.linalg.LinAlgError as error:
        raise SolveFailed("the equations of the global unknowns are singular") from error
    terms = float((np.abs(border.corner) + cancels).max())
    require_regular(inverse, terms, min(LARGEST_CONDITION, 0.1 / COLUMN_TOLERANCE))

    residual = np.where(free, right_side, 0.0)
    of_border = global_right_side
    x, g = np.zeros_like(residual), np.zeros_like(of_border)
    whole = size(residual, of_border)
    relative = 1.0 if whole > 0.0 else 0.0
    for _ in range(1 + MAXIMUM_REFINEMENTS):
        if relative <= 2.0 * tolerance or not math.isfinite(relative):
            break
        correction = solve(residual, tolerance)
        step = inverse @ (of_border - system.inner_products(border.rows, correction))
        g = g + step
        x = x + correction - sum(share * column for share, column in zip(step, solved, strict=True))
        coupling = np.tensordot(g, border.columns, axes=1)
        residual = np.where(free, right_side - system.times(x) - coupling, 0.0)
        of_border = global_right_side - system.inner_products(border.rows, x) - border.corner @ g
        relative = size(residual, of_border) / whole
    if not relative <= 2.0 * tolerance:
        raise SolveFailed(
            f"no solution with the global unknowns (relative residual {relative:.1e})"
        )
    return x, g


def require_regular(inverse: Floats, terms: float, limit: float) -> None:
    """Checks a Schur complement by its inverse (m, m) and the size of its terms.

    Raises:
        SolveFailed: it is singular or nearly so.
    """
    condition = float(np.abs(inverse).max()) * terms
    if not condition < limit:  # also for NaN
        raise SolveFailed(
            f"the equations of the global unknowns are singular or nearly so "
            f"(condition {condition:.1e})"
        )
