# SPDX-License-Identifier: BSD-3-Clause
"""All essential conditions of a step taken together: who holds what, and rigid motions left."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Flags, Floats
from tilth.boundaries.implicit.constraint import ImplicitConstraint
from tilth.boundaries.implicit.constraints import ImplicitConstraints
from tilth.boundaries.protocol import Boundary
from tilth.errors import BadInput
from tilth.mpm.grid import ActiveGrid

NOBODY = -1
AXIS = -2
"""Holder of what the axis of symmetry holds: none of the user's boundaries."""


@dataclass(frozen=True)
class Conditions:
    """The constrained degrees of freedom of one step.

    Attributes:
        names: names of the boundaries.
        holder: number of the first declared boundary that holds each degree of freedom, -1 if
            none, -2 if the axis of symmetry does, shape (nodes, dim).
        increment: prescribed displacement in the step [length], shape (nodes, dim).
        touched: which boundaries hold any active node.
    """

    names: list[str]
    holder: npt.NDArray[np.int64]
    increment: Floats
    touched: list[bool]

    @classmethod
    def gather(
        cls, boundaries: list[Boundary], active: ActiveGrid, before: float, after: float
    ) -> Conditions:
        """Asks all boundaries; where two hold the same component they must agree.

        Raises:
            BadInput: names two boundaries that prescribe different values at one node.
        """
        holder = np.full((active.nodes, active.grid.dim), NOBODY)
        increment = np.zeros(holder.shape)
        touched = []
        for number, boundary in enumerate(boundaries):
            prescribed = boundary.prescribe(active, before, after)
            both = prescribed.constrained & (holder != NOBODY)
            differ = both & (prescribed.increment != increment)
            if differ.any():
                node, component = np.argwhere(differ)[0]
                other = boundaries[holder[node, component]].name
                place = ", ".join(f"{x:g}" for x in active.position[node])
                raise BadInput(
                    f"boundaries {other!r} and {boundary.name!r} prescribe different "
                    f"{'xyz'[component]} displacements at the node ({place})",
                    "restrict one of them with `range`, or give both the same motion",
                    key=f"boundaries[{number}]",
                )
            new = prescribed.constrained & ~both
            holder[new] = number
            increment[new] = prescribed.increment[new]
            touched.append(bool(prescribed.constrained.any()))
        return cls([b.name for b in boundaries], holder, increment, touched)

    def with_axis(self, on_axis: Flags) -> Conditions:
        """Returns these and u_r = 0 where nobody else holds it at the nodes `on_axis`, (nodes,)."""
        holder = self.holder.copy()
        holder[on_axis & (holder[:, 0] == NOBODY), 0] = AXIS
        return replace(self, holder=holder)

    @property
    def constrained(self) -> Flags:
        """Which degrees of freedom are prescribed, shape (nodes, dim)."""
        return np.asarray(self.holder != NOBODY)

    def forces(self, reaction: Floats) -> dict[str, Floats]:
        """Returns the nodal forces of each boundary on the soil [force], (nodes, dim), by name.

        A component that two boundaries hold counts for the one declared first; what the axis of
        symmetry holds counts for none.
        """
        return {
            name: np.where(self.holder == number, reaction, 0.0)
            for number, name in enumerate(self.names)
        }


def require_no_rigid_motion(
    active: ActiveGrid, kind: str, constrained: Flags, constraints: ImplicitConstraints
) -> None:
    """Checks that every connected part of the active grid is constrained against rigid motion.

    Raises:
        BadInput: the system would be singular; names the place and the motion that is free.
    """
    label = np.asarray(_core.connected_parts(active.row_start, active.column))
    for part in range(label.max() + 1):
        nodes = np.flatnonzero(label == part)
        position = active.position[nodes]
        centre = position.mean(axis=0)
        modes = _rigid_modes(position - centre, active.grid.cell_size, kind)
        own = [np.isin(constraint.at.node[:, 0], nodes) for constraint in constraints.parts]
        restricted = np.array(
            [
                np.concatenate(
                    [mode[constrained[nodes]]]
                    + [
                        _held_by(constraint, chosen, active.nodes, nodes, mode)
                        for constraint, chosen in zip(constraints.parts, own, strict=True)
                    ]
                )
                for _, mode in modes
            ]
        )
        left = np.linalg.svd(restricted @ restricted.T)
        null = left.U[:, 1e-12 * len(nodes) >= left.S]
        if null.shape[1] == 0:
            continue
        names = [name for (name, _), row in zip(modes, null, strict=True) if abs(row).max() > 1e-6]
        place = ", ".join(f"{x:g}" for x in centre)
        raise BadInput(
            f"the material around ({place}) is not constrained against {' and '.join(names)}: "
            "the system of equations is singular",
            "add an essential condition that holds it, on nodes of cells that it touches",
            key="boundaries",
        )


def _held_by(
    constraint: ImplicitConstraint,
    cells: Flags,
    count: int,
    nodes: npt.NDArray[np.intp],
    mode: Floats,
) -> Floats:
    """Returns the constrained parts of a mode of `nodes` at an implicit boundary's places."""
    whole = np.zeros((count, mode.shape[1]))
    whole[nodes] = mode
    there = constraint.at.interpolate(whole)
    there = np.einsum("nij,nj->ni", constraint.pose.projector, there)
    return np.asarray(there[cells[constraint.at.cell]].ravel())


def _rigid_modes(x: Floats, cell_size: Floats, kind: str) -> list[tuple[str, Floats]]:
    """Rigid motions of nodes at `x` from their centre, in units of the cell."""
    dim = x.shape[1]
    modes = []
    for k in range(dim):
        if kind == "axisymmetric" and k == 0:
            continue  # a radial displacement strains the hoop
        translation = np.zeros(x.shape)
        translation[:, k] = 1.0
        modes.append((f"translation along {'xyz'[k]}", translation))
    if kind == "axisymmetric":
        return modes
    scale = max(float(np.abs(x).max()), float(cell_size.max()))
    for i, j in [(0, 1)] if dim == 2 else [(0, 1), (1, 2), (0, 2)]:
        rotation = np.zeros(x.shape)
        rotation[:, i] = -x[:, j] / scale
        rotation[:, j] = x[:, i] / scale
        modes.append((f"rotation in the {'xyz'[i]}{'xyz'[j]} plane", rotation))
    return modes
