# SPDX-License-Identifier: BSD-3-Clause
"""Flexible GMRES for several fields, with a cycle of multigrid for each field of the grid."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tilth import _core
from tilth.algebra.field import DISPLACEMENT
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Floats
from tilth.comm import total
from tilth.mpm.active_grid import ActiveGrid
from tilth.solvers.bordered_system import LARGEST_CONDITION, require_regular
from tilth.solvers.coupled_system import CoupledSystem
from tilth.solvers.cycle import Cycle, CycleMaker
from tilth.solvers.free_unknowns import FreeUnknowns
from tilth.solvers.grid_fields import EliminatedSystem
from tilth.solvers.krylov import flexible_gmres
from tilth.solvers.member_patch import MemberPatch
from tilth.solvers.multigrid import ITERATIONS_WITH_FEWER, MAXIMUM_ITERATIONS
from tilth.solvers.protocol import SolveFailed
from tilth.solvers.row_scaling import RowScaling


class BlockMultigrid:
    """Solves the systems of a step with several fields; all processes call its methods together.

    The preconditioner is block triangular: a cycle for the displacement, then one for each other
    field of the grid on what elimination of the displacement leaves. Members are solved exactly,
    with the soil that they touch, before and after it. Global unknowns are eliminated from the
    preconditioner.

    Args:
        system: has the matrices.
        unknowns: the free ones.
        maker: of the cycles.
    """

    def __init__(self, system: CoupledSystem, unknowns: FreeUnknowns, maker: CycleMaker) -> None:
        self._system, self._unknowns, self._maker = system, unknowns, maker
        self._scaling = RowScaling(system)
        fields = system.matrix.fields
        on_grid = [name for name, each in fields.items() if isinstance(each.nodes, ActiveGrid)]
        self._eliminated = {name: EliminatedSystem(system, name) for name in on_grid[1:]}
        self._cycles: dict[str, Cycle] = {}
        self._patch = MemberPatch(system, unknowns) if len(on_grid) < len(fields) else None

    def fill(self, keep_levels: bool = False) -> None:
        """Takes the matrix that the system has now.

        keep_levels: whether the levels of the last matrix precondition this one, too.

        Raises:
            SolveFailed: it has entries that are not numbers, or no levels, or the equations of the
                global unknowns are singular.
        """
        for each in self._eliminated.values():
            each.fill()
        if not self._cycles:
            linear = {name: each.linear for name, each in self._eliminated.items()}
            for name, own in {DISPLACEMENT: self._system.displacement, **linear}.items():
                self._cycles[name] = self._maker.cycle(own, name)
        for cycle in self._cycles.values():
            cycle.fill(keep_levels)
        if self._patch is not None:
            self._patch.fill()
        self._rows = self._unknowns.of_fields(self._scaling.factors())
        self._eliminate_globals()

    def _eliminate_globals(self) -> None:
        """Prepares the solution of the border's equations by the preconditioner."""
        self._solved: list[Floats] = []  # M B, a vector for each global unknown
        border = self._system.matrix.border
        if border is None:
            return
        zeros = {name: each.zero() for name, each in self._system.matrix.fields.items()}
        for column in border.columns:
            found = self._of_fields(self._own(Unknowns({**zeros, DISPLACEMENT: column})))
            self._solved.append(found)
        rows = border.rows_by_field()
        product = np.stack([self._border_rows(rows, each) for each in self._solved], axis=1)
        try:
            self._inverse = np.asarray(np.linalg.inv(border.corner - product), dtype=np.float64)
        except np.linalg.LinAlgError as error:
            raise SolveFailed("the equations of the global unknowns are singular") from error
        sizes = [np.abs(each) for each in self._solved]
        rows = {name: np.abs(each) for name, each in rows.items()}
        cancels = np.stack([self._border_rows(rows, each) for each in sizes], axis=1)
        by = border.scale[:, None] * border.scale
        terms = float(((np.abs(border.corner) + cancels) / by).max())
        require_regular(self._inverse * by, terms, LARGEST_CONDITION)

    def _border_rows(self, rows: Mapping[str, Floats], own: Floats) -> Floats:
        """Returns the products of rows, see `Border`, with unknowns of fields, shape (m,)."""
        nodes, values = self._system.displacement.active, self._unknowns.at_owned(own)
        products = np.zeros(len(rows[DISPLACEMENT]))
        for name, of_field in rows.items():
            mine = self._system.matrix.fields[name].nodes.owned
            products += [_core.inner(row[mine], values[name][mine]) for row in of_field]
        return total(nodes.comm, products)

    def solve(self, right_side: Unknowns, tolerance: float) -> tuple[Unknowns, int]:
        """Returns the solution and the iterations.

        tolerance: residual of all equations, made comparable, relative to the right side.

        Raises:
            SolveFailed: it is not reached.
        """
        if any(each.may_increase for each in self._cycles.values()):
            try:
                return self._iterate(right_side, tolerance, ITERATIONS_WITH_FEWER)
            except SolveFailed:
                for each in self._cycles.values():
                    each.increase()
                self._eliminate_globals()
        return self._iterate(right_side, tolerance, MAXIMUM_ITERATIONS)

    def _iterate(self, right_side: Unknowns, tolerance: float, limit: int) -> tuple[Unknowns, int]:
        unknowns, matrix, count = self._unknowns, self._system.matrix, len(right_side.globals)
        of_globals = np.zeros(0) if matrix.border is None else 1.0 / matrix.border.scale
        if not unknowns.has_globals:
            of_globals = of_globals[:0]
        rows = np.concatenate([self._rows, of_globals])

        def product(x: Floats, result: Floats) -> None:
            found = matrix.times(unknowns.values(x, count))
            result[:] = rows * unknowns.vector(found)

        def precondition(residual: Floats, result: Floats) -> None:
            result[:] = self._precondition(residual / rows)

        right = rows * unknowns.vector(right_side)
        found = flexible_gmres(product, precondition, right, tolerance, limit, unknowns.comm)
        return unknowns.values(found.x, count), found.iterations

    def _precondition(self, residual: Floats) -> Floats:
        """Returns the correction for a residual, of the owned unknowns with the global ones."""
        own = self._unknowns.count
        correction = self._of_fields(residual[:own])
        border = self._system.matrix.border
        if border is None:
            return correction
        of_border = self._unknowns.comm.gathered(residual[own:].copy())[-1]
        product = self._border_rows(border.rows_by_field(), correction)
        step = self._inverse @ (of_border - product)
        for share, solved in zip(step, self._solved, strict=True):
            correction = correction - share * solved
        return np.concatenate([correction, step[: None if len(residual) > own else 0]])

    def _of_fields(self, residual: Floats) -> Floats:
        """Returns the correction of the unknowns of fields for their residual, (n,) each."""
        if self._patch is None:
            return self._cycle(residual)
        found = self._patch.solve(residual)
        found += self._cycle(residual - self._times(found))
        return found + self._patch.solve(residual - self._times(found))

    def _times(self, own: Floats) -> Floats:
        """Returns the product with unknowns of fields."""
        matrix, values = self._system.matrix, self._unknowns.values(own, 0)
        product = {name: each.zero() for name, each in matrix.fields.items()}
        for (row, column), block in matrix.blocks.items():
            product[row] += block.times(values.of[column])
        return self._own(Unknowns(product))

    def _own(self, values: Unknowns) -> Floats:
        return self._unknowns.vector(values)[: self._unknowns.count]

    def _cycle(self, residual: Floats) -> Floats:
        """Returns the corrections of the cycles of all fields of the grid."""
        matrix, constrained = self._system.matrix, self._system.constrained
        rest = self._unknowns.at_owned(residual)
        found = {name: each.zero() for name, each in matrix.fields.items()}
        done: list[str] = []
        for name, cycle in self._cycles.items():
            nodes = matrix.fields[name].nodes
            for other in done:
                if (name, other) in matrix.blocks:
                    rest[name] -= matrix[name, other].times(found[other])
            own = np.where(constrained[name], 0.0, rest[name])[nodes.owned]
            sign = self._eliminated[name].sign if done else 1.0
            found[name][nodes.owned] = sign * cycle.precondition(own)
            if name != list(self._cycles)[-1]:
                found[name] = nodes.updated(found[name])
            done.append(name)
        return self._own(Unknowns(found))
