# SPDX-License-Identifier: BSD-3-Clause
"""Conjugate gradients of the consistent mass: solutions, known components, threads, failure."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from tilth import _core


def mass_matrix(n: int) -> sp.csr_array:
    """Consistent mass of n x n bilinear cells whose density varies, and a node without mass."""
    line = sp.diags([1.0, 4.0, 1.0], [-1, 0, 1], shape=(n, n))
    density = sp.diags(np.random.default_rng(n).uniform(0.5, 2.0, n * n))
    massive = sp.csr_array(density @ sp.kron(line, line) @ density)
    whole = sp.lil_array((n * n + 1, n * n + 1))
    whole[: n * n, : n * n] = massive
    matrix = sp.csr_array(whole)
    empty = sp.csr_array((np.zeros(1), ([n * n], [n * n])), shape=matrix.shape)
    rows, columns = sp.coo_array(matrix).coords
    data = np.append(sp.coo_array(matrix).data, empty.data)
    index = np.lexsort((np.append(columns, n * n), np.append(rows, n * n)))
    start = np.concatenate([[0], np.cumsum(np.bincount(np.append(rows, n * n)))])
    return sp.csr_array((data[index], np.append(columns, n * n)[index], start), shape=matrix.shape)


def solved(
    matrix: sp.csr_array, right: np.ndarray, known: np.ndarray, limit: int = 100
) -> tuple[bool, np.ndarray]:
    start, column = matrix.indptr.astype(np.int64), matrix.indices.astype(np.int32)
    x = right.copy()
    return _core.project(start, column, matrix.data, 0.0, known, 1e-13, limit, right, x), x


@pytest.mark.slow
@pytest.mark.parametrize("columns", [4, 8, 12])
@pytest.mark.parametrize("n", [1, 9, 80])
def test_solution_with_known_components(n: int, columns: int) -> None:
    """The third has more than one block of rows (4,096)."""
    matrix, random = mass_matrix(n), np.random.default_rng(columns)
    known = random.random((n * n + 1, columns)) < 0.2
    right = random.normal(size=known.shape)
    converged, x = solved(matrix, right, known)
    assert converged
    known[-1] = True  # without mass
    assert (x[known] == 0.0).all()
    rest = np.where(known, 0.0, right - matrix @ x)
    assert np.abs(rest).max() <= 1e-11 * np.abs(right).max()


@pytest.mark.usefixtures("every_loop_in_parallel")
def test_the_same_for_any_number_of_threads() -> None:
    matrix = mass_matrix(80)
    right = np.random.default_rng(0).normal(size=(matrix.shape[0], 4))
    known = np.zeros(right.shape, dtype=bool)
    found = []
    for threads in (1, 2, 4):
        _core.set_threads(threads)
        found.append(solved(matrix, right, known)[1])
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[0], found[2])


def test_failure_to_converge_is_told() -> None:
    matrix = mass_matrix(9)
    right = np.ones((matrix.shape[0], 4))
    known = np.zeros(right.shape, dtype=bool)
    assert not solved(matrix, right, known, limit=1)[0]
    assert not solved(matrix, np.full(right.shape, np.nan), known)[0]


@pytest.mark.parametrize("columns", [2, 3])
def test_product(columns: int) -> None:
    matrix = mass_matrix(9)
    x = np.random.default_rng(columns).normal(size=(matrix.shape[0], columns))
    start, column = matrix.indptr.astype(np.int64), matrix.indices.astype(np.int32)
    product = np.empty_like(x)
    _core.symmetric_product(start, column, matrix.data, x, product)
    np.testing.assert_allclose(product, matrix @ x, rtol=0, atol=1e-12 * np.abs(product).max())
