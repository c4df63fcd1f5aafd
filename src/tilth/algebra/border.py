# SPDX-License-Identifier: BSD-3-Clause
"""Border of the node-block matrix: the rows and columns of unknowns that belong to no node."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from tilth.algebra.field import DISPLACEMENT
from tilth.arrays import Floats


@dataclass(frozen=True)
class Border:
    """Columns B, rows C and corner D of m global unknowns g, as those of a rigid body's motion.

    They extend the node-block matrix A to [[A, B], [C, D]] [x; g] = [r; s].

    Attributes:
        columns: derivative of the nodal residual with respect to each global unknown, shape
            (m, nodes, components).
        rows: derivative of the residual of each global unknown's equation with respect to the nodal
            unknowns, shape (m, nodes, components).
        corner: derivative of these residuals with respect to the global unknowns, shape (m, m).
        scale: factors that make the global unknowns comparable with the nodal ones, shape (m,),
            positive. Unknown times scale has the unit of the nodal unknowns; the residual of its
            equation over the scale has that of the nodal residuals. For a rotation [rad] the scale
            is a length, for a translation 1, for a Lagrange multiplier [force] a compliance
            [length/force].
        others: as `rows`, with respect to the nodal unknowns of other fields, by their names.
    """

    columns: Floats
    rows: Floats
    corner: Floats
    scale: Floats
    others: Mapping[str, Floats] = field(default_factory=dict)

    @property
    def unknowns(self) -> int:
        """The number m of global unknowns."""
        return len(self.corner)

    def rows_by_field(self) -> Mapping[str, Floats]:
        """Returns the rows by the fields' names, that of the displacement first."""
        return {DISPLACEMENT: self.rows, **self.others}

    def scaled(self) -> Border:
        """Returns the border of the scaled unknowns, whose scale is 1."""
        by = 1.0 / self.scale
        return Border(
            self.columns * by[:, None, None],
            self.rows * by[:, None, None],
            self.corner * by[:, None] * by,
            np.ones_like(by),
            {name: rows * by[:, None, None] for name, rows in self.others.items()},
        )
