# SPDX-License-Identifier: BSD-3-Clause
"""All essential conditions of a step, and the check for unconstrained rigid motions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Flags, Floats
from tilth.boundaries.protocol import Boundary
from tilth.boundaries.step.constraints import ImplicitConstraints
from tilth.boundaries.surfaces.points import PointsNearSoil
from tilth.comm import count
from tilth.errors import BadInput
from tilth.mpm.active_grid import ActiveGrid

UNCONSTRAINED = -1
"""Value of `Conditions.boundary` at unconstrained degrees of freedom."""

AXIS = -2
"""Value of `Conditions.boundary` at degrees of freedom constrained by the axis of symmetry."""


@dataclass(frozen=True)
class Conditions:
    """The constrained degrees of freedom of one step.

    Attributes:
        names: names of the boundaries.
        boundary: number of the first declared boundary that constrains each degree of freedom, -1
            if none does, -2 if the axis of symmetry does, shape (nodes, dim).
        increment: prescribed displacement in the step [length], shape (nodes, dim).
        has_nodes: whether each boundary constrains any active node.
        base: which components have a given acceleration, shape (nodes, dim), and their motion
            before the step, shape (nodes, 3, dim); None if none has.
    """

    names: list[str]
    boundary: npt.NDArray[np.int64]
    increment: Floats
    has_nodes: list[bool]
    base: tuple[Flags, Floats] | None = None

    @classmethod
    def gather(
        cls, boundaries: list[Boundary], active: ActiveGrid, before: float, after: float
    ) -> Conditions:
        """Returns the conditions of all boundaries in the step from time `before` to `after`.

        Raises:
            BadInput: two boundaries prescribe different values at one node.
        """
        constrained_by = np.full((active.nodes, active.grid.dim), UNCONSTRAINED)
        increment = np.zeros(constrained_by.shape)
        has_nodes = []
        base: tuple[Flags, Floats] | None = None
        for number, boundary in enumerate(boundaries):
            prescribed = boundary.prescribe(active, before, after)
            both = prescribed.constrained & (constrained_by != UNCONSTRAINED)
            differ = both & (prescribed.increment != increment)
            if differ.any():
                node, component = np.argwhere(differ)[0]
                other = boundaries[constrained_by[node, component]].name
                at = ", ".join(f"{x:g}" for x in active.position[node])
                raise BadInput(
                    f"boundaries {other!r} and {boundary.name!r} prescribe different "
                    f"{'xyz'[component]} displacements at the node ({at})",
                    "restrict one of them with `range`, or give both the same motion",
                    key=f"boundaries[{number}]",
                )
            new = prescribed.constrained & ~both
            constrained_by[new] = number
            increment[new] = prescribed.increment[new]
            if prescribed.motion is not None:
                moving, motion = base or (np.zeros_like(new), np.zeros_like(prescribed.motion))
                base = moving | new, motion + np.where(new[:, None], prescribed.motion, 0.0)
            has_nodes.append(bool(prescribed.constrained.any()))
        return cls([b.name for b in boundaries], constrained_by, increment, has_nodes, base)

    def with_axis(self, on_axis: Flags) -> Conditions:
        """Returns these with u_r = 0 where it is free at the nodes `on_axis`, shape (nodes,)."""
        boundary = self.boundary.copy()
        boundary[on_axis & (boundary[:, 0] == UNCONSTRAINED), 0] = AXIS
        return replace(self, boundary=boundary)

    def of_owners(self, active: ActiveGrid) -> Conditions:
        """Returns these, at the nodes of other processes as these have them."""
        if active.shared is None:
            return self
        base = self.base and (active.updated(self.base[0]), active.updated(self.base[1]))
        return replace(
            self,
            boundary=active.updated(self.boundary),
            increment=active.updated(self.increment),
            has_nodes=[count(active.comm, int(each)) > 0 for each in self.has_nodes],
            base=base,
        )

    @property
    def constrained(self) -> Flags:
        """Which degrees of freedom are prescribed, shape (nodes, dim)."""
        return np.asarray(self.boundary != UNCONSTRAINED)

    def forces(self, reaction: Floats) -> dict[str, Floats]:
        """Returns the nodal forces of each boundary on the soil [force], (nodes, dim), by name.

        The reaction at a component that two boundaries prescribe belongs to the one declared first;
        that of the axis of symmetry belongs to none.
        """
        return {
            name: np.where(self.boundary == number, reaction, 0.0)
            for number, name in enumerate(self.names)
        }


def require_no_rigid_motion(
    active: ActiveGrid, kind: str, constrained: Flags, constraints: ImplicitConstraints
) -> None:
    """Checks that every connected part of the active grid is constrained against rigid motion.

    Raises:
        BadInput: a part has an unconstrained rigid motion; the system would be singular.
    """
    label = np.asarray(_core.connected_parts(active.row_start, active.column))
    touching = [each for part in constraints.contacts for each in part.in_cells()]
    holding: list[PointsNearSoil] = [*constraints.parts, *touching]
    for part in range(label.max() + 1):
        nodes = np.flatnonzero(label == part)
        position = active.position[nodes]
        centre = position.mean(axis=0)
        modes = _rigid_modes(position - centre, active.grid.cell_size, kind)
        own = [np.isin(constraint.at.node[:, 0], nodes) for constraint in holding]
        restricted = np.array(
            [
                np.concatenate(
                    [mode[constrained[nodes]]]
                    + [
                        _constrained_mode(constraint, chosen, active.nodes, nodes, mode)
                        for constraint, chosen in zip(holding, own, strict=True)
                    ]
                )
                for _, mode in modes
            ]
        )
        decomposition = np.linalg.svd(restricted @ restricted.T)
        null = decomposition.U[:, 1e-12 * len(nodes) >= decomposition.S]
        if null.shape[1] == 0:
            continue
        names = [name for (name, _), row in zip(modes, null, strict=True) if abs(row).max() > 1e-6]
        at = ", ".join(f"{x:g}" for x in centre)
        raise BadInput(
            f"the material around ({at}) is not constrained against {' and '.join(names)}: "
            "the system of equations is singular",
            "add an essential condition that constrains it, on nodes of cells with this material",
            key="boundaries",
        )


def _constrained_mode(
    constraint: PointsNearSoil,
    cells: Flags,
    count: int,
    nodes: npt.NDArray[np.intp],
    mode: Floats,
) -> Floats:
    """Returns the constrained parts of a mode of `nodes` at an implicit boundary's points, (k,)."""
    nodal = np.zeros((count, mode.shape[1]))
    nodal[nodes] = mode
    at_points = constraint.at.interpolate(nodal)
    at_points = np.einsum("nij,nj->ni", constraint.pose.projector, at_points)
    return np.asarray(at_points[cells[constraint.at.cell]].ravel())


def _rigid_modes(x: Floats, cell_size: Floats, kind: str) -> list[tuple[str, Floats]]:
    """Returns rigid motions of nodes at `x` (n, dim) from their centre, with their names."""
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
