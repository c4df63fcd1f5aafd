# SPDX-License-Identifier: BSD-3-Clause
"""Small problems for tests over all kinds of analysis, bases and materials.

`KINDS`, `BASES` and `MATERIALS` follow the lists of the compiled core, so that a new basis or
material is tested at once; a new parameter needs one entry in `TYPICAL`.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.model.laws import laws
from tilth.mpm.grid import ActiveGrid, Buffers, Grid, locate
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.mpm.soil import Soil
from tilth.timers import Timers

KINDS = ("plane_strain", "axisymmetric", "3d")
BASES = tuple(_core.basis_names())
CORNER_BASES = tuple(_core.corner_basis_names())
MATERIALS = tuple(laws())

TYPICAL = {
    "young_modulus": 1000.0,
    "poisson_ratio": 0.3,
    "yield_stress": 60.0,
    "hardening_modulus": 40.0,
}
"""A value of each material parameter; yielding starts at strains near 0.05."""

EXTREME = {"hardening_modulus": (0.0, 800.0), "poisson_ratio": (0.0, 0.49)}
"""Further values of some parameters, for tests of a law by itself."""

AXES = "xyz"


def dimension(kind: str) -> int:
    return 3 if kind == "3d" else 2


def parameters(material: str, **changed: float) -> Floats:
    """Parameters of a material in the order of the core's list."""
    return np.array([{**TYPICAL, **changed}[name] for name in laws()[material].parameters])


def principal_update(material: str, strain: npt.ArrayLike) -> tuple[Floats, Floats]:
    """Principal Kirchhoff stress and elastic strain of a point strained in one step."""
    given, size = parameters(material), len(laws()[material].state_variables)
    before, after = np.zeros(size), np.zeros(size)
    _core.initial_state(material, given, before)
    stress, elastic, tangent = np.empty(3), np.empty(3), np.empty((3, 3))
    trial = np.asarray(strain, dtype=float)
    assert _core.principal_update(
        material, given, trial, 0.0, before, after, stress, elastic, tangent
    )
    return stress, elastic


def yields(material: str) -> bool:
    """Whether a law flows plastically under a large strain."""
    strain = [0.3, 0.0, -0.3]
    return not np.array_equal(principal_update(material, strain)[1], strain)


def material_entries(material: str, density: float = 2.0, **changed: float) -> dict[str, Any]:
    """A material as a case file would declare it."""
    return {
        "model": material,
        "density": density,
        **dict(zip(laws()[material].parameters, parameters(material, **changed), strict=True)),
    }


def block_entries(
    kind: str, basis: str, material: str = "hencky_elastic", cells: int = 2, **changed: Any
) -> dict[str, Any]:
    """A cube of cells of size 1 at the origin, driven by no motion at all, as a dictionary."""
    dim = dimension(kind)
    entries: dict[str, Any] = {
        "analysis": {"kind": kind, "solver": "superlu"},
        "grid": {"cell_size": 1.0},
        "materials": {"soil": material_entries(material)},
        "bodies": [
            {
                "name": "block",
                "material": "soil",
                "shape": {"type": "box", "lower": [0.0] * dim, "upper": [float(cells)] * dim},
                "basis": basis,
                "points_per_cell": 2,
            }
        ],
        "boundaries": [affine(np.eye(dim))],
        "schedule": {"steps": 1},
    }
    return {**entries, **changed}


def affine(end: Floats, path: str = "linear") -> dict[str, Any]:
    """An affine motion of all nodes to the deformation gradient `end`."""
    return {
        "type": "affine",
        "name": "drive",
        "deformation_gradient": np.asarray(end).tolist(),
        "path": path,
    }


def plane(name: str, axis: str, at: float, **more: Any) -> dict[str, Any]:
    """A condition on a grid plane, a roller unless told otherwise."""
    entries = {"type": "plane", "name": name, "axis": axis, "at": at, "condition": "roller"}
    return {**entries, **more}


def rollers(kind: str, size: float = 2.0, sides: bool = True) -> list[dict[str, Any]]:
    """Rollers on the lower faces of a block, and on its sides if asked for."""
    dim = dimension(kind)
    found = [plane(f"low {AXES[k]}", AXES[k], 0.0) for k in range(dim)]
    if sides:
        found += [plane(f"high {AXES[k]}", AXES[k], size) for k in range(dim - 1)]
    return found


def weight(kind: str, acceleration: float) -> dict[str, Any]:
    """Gravity downwards."""
    dim = dimension(kind)
    return {"type": "body_force", "acceleration": [0.0] * (dim - 1) + [-acceleration]}


def off_lines(entries: dict[str, Any], shift: float) -> dict[str, Any]:
    """The same with x = 0 a share of a cell beyond a grid line; in place."""
    entries["grid"]["origin"] = [-shift * entries["grid"]["cell_size"], 0.0]
    return entries


def jittered_points(model: Model, random: np.random.Generator, share: float) -> MaterialPoints:
    """The points of a model, each moved by up to `share` of its half lengths."""
    points = initial_points(model)
    points.position += share * points.half_length * random.uniform(-1, 1, points.position.shape)
    return points


@dataclass
class Laboratory:
    """Points, their grid and the soil's kernels, driven by any nodal displacement."""

    kind: str
    points: MaterialPoints
    grid: Grid

    def __post_init__(self) -> None:
        self.locate()

    @classmethod
    def of(
        cls, kind: str, basis: str, material: str, random: np.random.Generator, **changed: Any
    ) -> Laboratory:
        model = Model.from_dict(block_entries(kind, basis, material, **changed))
        points = jittered_points(model, random, 0.4)
        return cls(kind, points, Simulation(model, points).grid)

    def copy(self) -> Laboratory:
        return Laboratory(self.kind, copy.deepcopy(self.points), self.grid)

    def locate(self) -> None:
        self.active: ActiveGrid = locate(self.points, self.grid, Buffers())
        self.soil = Soil(self.points, self.active, self.kind, Timers())

    def random_displacement(self, random: np.random.Generator, size: float) -> Floats:
        """Nodal displacements of up to `size`, of order r near the axis in axisymmetry."""
        u = size * random.uniform(-1, 1, self.active.position.shape)
        if self.kind == "axisymmetric":
            u[:, 0] *= np.minimum(1.0, self.active.position[:, 0])
        return u

    def step(self, displacement: Floats) -> None:
        """One whole step with a prescribed displacement of all nodes."""
        self.soil.update(displacement)
        self.soil.advance(displacement, self.soil.moved_domains(displacement))
        self.locate()

    def internal_force(self, displacement: Floats) -> Floats:
        self.soil.update(displacement)
        return self.soil.internal_force()

    def stiffness(self, displacement: Floats) -> sp.bsr_matrix:
        """d internal_force / d displacement at `displacement`, unknowns node by node."""
        self.soil.update(displacement)
        dim = self.grid.dim
        blocks = np.zeros((len(self.active.column), dim, dim))
        self.soil.add_stiffness(self.active, blocks)
        size = self.active.nodes * dim
        return sp.bsr_matrix(
            (blocks, self.active.column, self.active.row_start), shape=(size, size)
        )


def deformed_laboratory(
    kind: str, basis: str, material: str, random: np.random.Generator, steps: int = 3
) -> Laboratory:
    """A block after some random steps: general strain, partly plastic where the soil can be."""
    laboratory = Laboratory.of(kind, basis, material, random)
    for _ in range(steps):
        laboratory.step(laboratory.random_displacement(random, 0.06))
    return laboratory


def tensor(components: Floats) -> Floats:
    """Symmetric tensors (..., 3, 3) of components xx yy zz xy yz xz (..., 6)."""
    place = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
    return np.asarray(components)[..., place]


def by_number(points: MaterialPoints) -> dict[str, npt.NDArray[np.generic]]:
    """Copies of all arrays of the points, in the order of their permanent numbers."""
    order = points.index_of(np.arange(len(points)))
    arrays = points.arrays() | {"elastic_strain": points.elastic_strain}
    return {name: array[order].copy() for name, array in arrays.items()}


def assert_same_bits(one: MaterialPoints, other: MaterialPoints) -> None:
    """Asserts that all arrays are the same to the bit, apart from the order of the points."""
    first, second = by_number(one), by_number(other)
    for name, array in first.items():
        assert array.tobytes() == second[name].tobytes(), f"{name} differs"
