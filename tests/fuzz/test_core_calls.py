# SPDX-License-Identifier: BSD-3-Clause
"""Whatever the compiled core is given, it returns or raises; and it never writes into a copy."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from fuzz.core_calls import (
    Call,
    make_fixed,
    make_random_calls,
    names,
    plain,
    valid_calls,
    written,
)
from tilth import _core
from tilth.grid.background import Grid


@pytest.fixture(scope="module")
def calls() -> dict[str, list[Call]]:
    """Valid calls of all functions and classes."""
    return valid_calls()


def test_every_function_is_called(calls: dict[str, list[Call]]) -> None:
    assert sorted(calls) == sorted(names())


@pytest.mark.usefixtures("every_loop_in_parallel")
def test_valid_calls_return(calls: dict[str, list[Call]]) -> None:
    for own in calls.values():
        for call in own:
            copy.deepcopy(call).make()


@pytest.mark.parametrize("seed", [1, 2])
def test_changed_calls_return_or_raise(calls: dict[str, list[Call]], seed: int) -> None:
    returned, raised = make_random_calls(calls, 200, seed)
    assert returned + raised == 200
    assert raised > 100  # most changes leave no meaningful call


def inexact(array: np.ndarray) -> dict[str, np.ndarray]:
    """Arrays of the same numbers that a kernel could only write to through a copy."""
    strided = np.repeat(array[..., None], 2, axis=-1)[..., 0]
    read_only = array.copy()
    read_only.flags.writeable = False
    other = np.int16 if array.dtype.kind == "i" else np.float32
    found = {"strided": strided, "read-only": read_only, "type": np.zeros(array.shape, other)}
    if min(array.shape) > 1 and array.ndim > 1:
        found["Fortran order"] = np.asfortranarray(array)
    return {name: each for name, each in found.items() if each.size > 1}


def test_written_arrays_are_never_copied(calls: dict[str, list[Call]]) -> None:
    tried = set()
    for name, own in calls.items():
        for call in own:
            for position in {i for signature in written(name) for i in signature}:
                if position >= len(call.arguments):
                    continue
                array = call.arguments[position]
                if not isinstance(array, np.ndarray) or name == "advance":
                    continue
                for what, wrong in inexact(array).items():
                    changed = copy.deepcopy(call)
                    changed.arguments[position], before = wrong, wrong.copy()
                    with pytest.raises(TypeError):
                        changed.make()
                    assert wrong.tobytes() == before.tobytes(), (name, what)
                    tried.add((name, what))
    assert {what for _, what in tried} == {"strided", "read-only", "type", "Fortran order"}
    assert len({name for name, _ in tried}) > 20


@pytest.mark.parametrize("field", ["jacobian_ratio", "jacobian"])
def test_written_attributes_are_never_copied(calls: dict[str, list[Call]], field: str) -> None:
    call = next(c for c in calls["stress_update"] if c.arguments[-4] is not None)
    changed = copy.deepcopy(call)
    setattr(changed.arguments[-4], field, getattr(changed.arguments[-4], field).astype(np.float32))
    with pytest.raises(TypeError, match=field):
        changed.make()


def test_numbers_that_are_read_are_converted() -> None:
    assert _core.inner(np.ones(3, dtype=np.float32), np.ones(6)[::2]) == 3.0


def test_indices_are_not_converted() -> None:
    with pytest.raises(TypeError):
        _core.lattice(np.array([0.5]))
    with pytest.raises(TypeError):
        _core.gather(np.array([1.7]), np.ones(3), np.zeros(1))


@pytest.mark.parametrize("coordinate", [np.nan, np.inf, -1e300, 1e7])
def test_points_beyond_all_cells(coordinate: float) -> None:
    """Neither a cell index nor a key exists there: the number of such points, or an exception."""
    at, one = np.array([[0.5, coordinate]]), np.ones(2)
    keys, grid = np.zeros(1, dtype=np.int64), Grid(np.zeros(2), np.ones(2))
    for basis in ("linear", "gimp"):
        assert _core.support_keys(basis, at, 0.25 * one[None], grid, keys) == 1
        assert keys[0] == -1
    corner = 0.25 * np.array([[[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]]])
    found, _, failures = _core.corner_supports(at, corner, grid)
    assert failures == 1
    assert found[0] == -1
    with pytest.raises(ValueError, match="position"):
        _core.locate_in_cells(at, grid, keys)
    with pytest.raises(ValueError, match="position"):
        _core.move_domain_faces(at, keys, one[None], grid, 0.25 * one[None])


def test_facets_across_too_many_cells() -> None:
    """Without a limit, a facet of 1e300 cells would be cut forever."""
    grid = Grid(np.zeros(2), np.ones(2))
    for length in (np.nan, 1e9, 1e300):
        with pytest.raises(ValueError, match="corner"):
            _core.cut_simplices(np.array([[[0.0, 0.0], [length, 1.0]]]), grid)


@pytest.mark.parametrize("cell_size", [0.0, -1.0, np.nan, np.inf])
def test_cell_sizes(cell_size: float) -> None:
    keys, grid = np.zeros(1, dtype=np.int64), Grid(np.zeros(2), np.array([1.0, cell_size]))
    with pytest.raises(ValueError, match="cell_size"):
        _core.locate_in_cells(np.ones((1, 2)), grid, keys)


@pytest.mark.parametrize(
    "line", [[0.0], [0.1, 1.0], [0.0, 1.0, 1.5], [0.0, np.nan], [0.0, np.inf], [0.0, 2.0, 1.0]]
)
def test_lines_of_a_grid(line: list[float]) -> None:
    grid = Grid(np.zeros(2), np.ones(2), lines=(np.zeros(0), np.array(line)))
    with pytest.raises(ValueError, match="lines"):
        _core.locate_in_cells(np.ones((1, 2)), grid, np.zeros(1, dtype=np.int64))


@pytest.mark.parametrize("parameters", [[1.0], [-1.0, 0.3], [1.0, 0.5], [1.0, -1.0], [np.nan, 0]])
def test_parameters_of_a_law(parameters: list[float]) -> None:
    with pytest.raises(ValueError, match="parameters"):
        _core.initial_state(
            "3d", "hencky_elastic", np.array(parameters), np.zeros((1, 6)), np.zeros((1, 0))
        )


@pytest.mark.parametrize("threads", [0, -1, 10**6])
def test_numbers_of_threads(threads: int) -> None:
    before = _core.threads()
    with pytest.raises(ValueError, match="threads"):
        _core.set_threads(threads)
    assert _core.threads() == before


def test_methods_in_another_order() -> None:
    start, row = np.array([0, 1], dtype=np.int32), np.zeros(1, dtype=np.int32)
    one, x = np.ones(1), np.zeros(1)
    factors = _core.BandFactors(start, row)
    with pytest.raises(ValueError, match="factorise"):
        factors.solve(one, x)
    assert not factors.factorise(0 * one)
    with pytest.raises(ValueError, match="factorise"):
        factors.solve(one, x)
    assert factors.factorise(2 * one)
    factors.solve(one, x)
    assert x[0] == 0.5

    grid = np.zeros((1, 3), dtype=np.int64)
    multigrid = _core.Multigrid(2, 1, grid, start.astype(np.int64), row, np.zeros(1, dtype=bool))
    with pytest.raises(ValueError, match="fill"):
        multigrid.cycle(one, x)
    multigrid.fill(4 * one)
    multigrid.cycle(one, x)
    assert x[0] == 0.25
    multigrid.begin()
    with pytest.raises(ValueError, match="fill"):
        multigrid.cycle(one, x)


def test_patterns_that_are_not_symmetric() -> None:
    """An order with a narrow band has every unknown once; the rows of free unknowns are refused."""
    start, row = np.array([0, 2, 3, 4], dtype=np.int32), np.array([0, 2, 1, 2], dtype=np.int32)
    factors, x = _core.BandFactors(start, row), np.zeros(3)
    assert factors.factorise(np.array([2.0, 1.0, 4.0, 5.0]))
    factors.solve(np.array([2.0, 4.0, 6.0]), x)
    np.testing.assert_allclose(x, [1.0, 1.0, 1.0])
    free = np.zeros((3, 1), dtype=bool)
    with pytest.raises(ValueError, match="symmetric"):
        _core.restrict_to_free(1, start.astype(np.int64), row, np.arange(3), free)
    symmetric = np.array([0, 1, 2, 3]), np.arange(3, dtype=np.int32)
    with pytest.raises(ValueError, match="twice"):
        _core.restrict_to_free(1, *symmetric, np.array([0, 1, 1]), free)


def test_stencils_of_other_nodes(calls: dict[str, list[Call]]) -> None:
    """The message names the argument that has too few rows, and nothing is written."""
    call = copy.deepcopy(calls["internal_force"][0])
    stencil, force = call.arguments[1], call.arguments[-2]
    call.arguments[1] = plain(stencil)
    call.arguments[1].node = stencil.node + np.int32(len(force))
    before = force.copy()
    with pytest.raises(ValueError, match="force"):
        call.make()
    assert np.array_equal(force, before)


def test_fixed_objects_are_checked_once_and_changed_ones_again(
    calls: dict[str, list[Call]],
) -> None:
    call = copy.deepcopy(calls["internal_force"][0])
    stencil = call.arguments[1]
    call.make()
    assert not hasattr(stencil, "_checked")  # its arrays could change
    make_fixed(stencil)
    call.make()
    first = stencil._checked
    call.make()
    assert stencil._checked is first
    with pytest.raises(ValueError, match="read-only"):
        stencil.node[0] = -1
    node = stencil.node.copy()
    node[0] = -1
    stencil.node = node
    with pytest.raises(ValueError, match="node"):
        call.make()
    other = copy.deepcopy(call)
    other.arguments[1].node = np.abs(node)
    other.make()
