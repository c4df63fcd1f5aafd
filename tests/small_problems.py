# SPDX-License-Identifier: BSD-3-Clause
"""Small problems for tests over all kinds of analysis, bases and materials.

`KINDS`, `BASES` and `MATERIALS` follow the lists of the compiled core, so that a new basis or
material is tested at once; a new material needs an entry in `ENTRIES`.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from pydantic import TypeAdapter

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.grid.background import Grid
from tilth.model.isotropic import ParametersAt
from tilth.model.laws import laws
from tilth.model.materials import Material
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.mpm.domains import bound_domains
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.mpm.soil import Soil
from tilth.timers import Timers

KINDS = ("plane_strain", "axisymmetric", "3d")
BASES = tuple(_core.basis_names())
CORNER_BASES = tuple(_core.corner_basis_names())
MATERIALS = tuple(laws())
STEP_MATERIALS = ("hencky_elastic", "von_mises", "mohr_coulomb")
"""Those of tests of whole load steps that start without stress."""
POINT_MATERIALS = (*STEP_MATERIALS, "modified_cam_clay", "undrained_drucker_prager")
"""Those of tests of the points' forces and stiffness: all kinds of tangents and state variables."""

ELASTIC = {"young_modulus": 1000.0, "poisson_ratio": 0.3}
_FRICTION = {"cohesion": 25.0, "friction_angle": 30.0, "dilation_angle": 10.0}
_SOFTENING = {
    "residual_cohesion": 5.0, "residual_friction_angle": 20.0, "softening_strain": 0.8,
    "softening_length": 1.0,
}  # fmt: skip
ENTRIES: dict[str, dict[str, Any]] = {
    "hencky_elastic": ELASTIC,
    "von_mises": {**ELASTIC, "yield_stress": 60.0, "hardening_modulus": 40.0},
    "tresca": {**ELASTIC, "undrained_shear_strength": 30.0},
    "mohr_coulomb": {**ELASTIC, **_FRICTION},
    "drucker_prager": {**ELASTIC, **_FRICTION, "fit": "compression"},
    "modified_cam_clay": {
        "compression_index": 0.2, "swelling_index": 0.05, "critical_state_slope": 1.2,
        "shear_modulus": 400.0, "preconsolidation_pressure": 150.0,
    },
}  # fmt: skip
"""Typical entries of each material, without density; yielding starts at strains near 0.05."""

WEAK: dict[str, dict[str, Any]] = {
    "von_mises": {"yield_stress": 20.0, "hardening_modulus": 100.0},
    "mohr_coulomb": {"cohesion": 10.0, "friction_angle": 10.0, "dilation_angle": 5.0},
}
"""Entries of materials of a lower strength."""

START = -100.0
"""Stress on all axes at the start of materials that cannot be without stress."""

PORE_FLUID = {"pore_fluid_bulk_modulus": 5000.0}

VARIANTS: list[tuple[str, dict[str, Any]]] = [
    *((material, {}) for material in MATERIALS),
    *((m, {"poisson_ratio": nu}) for m in ("hencky_elastic", "von_mises") for nu in (0.0, 0.49)),
    *(("von_mises", {"hardening_modulus": modulus}) for modulus in (0.0, 800.0)),
    *(
        (law, {"friction_angle": phi, "dilation_angle": psi})
        for law in ("mohr_coulomb", "drucker_prager", "undrained_mohr_coulomb")
        for phi, psi in ((0.0, 0.0), (0.001, 0.0), (30.0, 0.0), (30.0, 30.0), (50.0, 25.0))
    ),
    *(
        (law, {"tension_cut_off": cut})
        for law in ("mohr_coulomb", "drucker_prager")
        for cut in (0.0, 20.0)
    ),
    ("mohr_coulomb", {"friction_angle": 0.0, "dilation_angle": 0.0, "tension_cut_off": 12.0}),
    ("mohr_coulomb", {"cohesion": 0.0}),
    ("drucker_prager", {"cohesion": 0.0}),
    ("separating_mohr_coulomb", {"cohesion": 0.0, "dilation_angle": 0.0}),
    ("separating_mohr_coulomb", _SOFTENING),
    ("separating_drucker_prager", {"cohesion": 0.0}),
    ("drucker_prager", {"fit": "extension"}),
    ("drucker_prager", {"fit": "plane_strain"}),
    ("mohr_coulomb", _SOFTENING),
    ("undrained_mohr_coulomb", _SOFTENING),
    (
        "modified_cam_clay",
        {"poisson_ratio": 0.15, "shear_modulus": None, "critical_state_slope": 1.0},
    ),
    ("modified_cam_clay", {"overconsolidation_ratio": 4.0, "preconsolidation_pressure": None}),
    ("modified_cam_clay", {"preconsolidation_pressure": 100.0, "critical_state_slope": 0.7}),
    ("mohr_coulomb", {**_SOFTENING, "dilation_angle": 0.0, "tension_cut_off": 10.0}),
]  # fmt: skip
"""Laws with their typical and with other entries, for tests of a law by itself."""

AXES = "xyz"


def dimension(kind: str) -> int:
    return 3 if kind == "3d" else 2


_MATERIAL: TypeAdapter[Any] = TypeAdapter(Material)


def declared(law: str, **changed: Any) -> Any:
    """The material of a law of the core, with its typical entries or others."""
    return _MATERIAL.validate_python(material_entries(law, **changed))


def parameters(law: str, **changed: Any) -> Floats:
    """Parameters of a material in the order of the core's list, in cells of size 1."""
    material = declared(law, **changed)
    at = ParametersAt(lambda key: getattr(material, key), 1.0)
    return np.asarray(material.parameter_array(at, 1))


def initial_state(law: str, **changed: Any) -> Floats:
    """State variables of an undeformed point."""
    state = np.full((1, len(laws()[law].state_variables)), np.nan)
    stress = np.array([[start_stress(law)] * 3 + [0.0] * 3])
    assert _core.initial_state("3d", law, parameters(law, **changed), stress, state) == -1
    return np.asarray(state[0])


def start_stress(law: str) -> float:
    """Stress on all axes at the start, 0 for materials that need none."""
    return START if declared(law).needs_stress else 0.0


def start_strain(law: str, **changed: Any) -> Floats:
    """Principal elastic strain at the start."""
    state, deformation = initial_state(law, **changed)[None], np.zeros((1, 6))
    stress = np.array([[start_stress(law)] * 3 + [0.0] * 3])
    given = parameters(law, **changed)
    assert _core.elastic_deformation_of("3d", law, given, stress, state, deformation) == -1
    return np.asarray(0.5 * np.log1p(deformation[0, :3]))


def principal_update(material: str, strain: npt.ArrayLike) -> tuple[Floats, Floats]:
    """Principal Kirchhoff stress and elastic strain of a point strained in one step."""
    given = parameters(material)
    before = initial_state(material)[None]
    after = np.zeros_like(before)
    stress, elastic, tangent = np.empty((1, 3)), np.empty((1, 3)), np.empty((1, 3, 3))
    trial, good = start_strain(material) + np.asarray(strain, dtype=float)[None], np.zeros(1, bool)
    _core.principal_update(
        material, given, trial, np.zeros((1, 2)), before, after, stress, elastic, tangent, good
    )
    assert good.all()
    return stress[0], elastic[0]


def yields(material: str) -> bool:
    """Whether a law flows plastically under a large strain."""
    strain = [0.3, 0.0, -0.3]
    trial = start_strain(material) + strain
    return not np.array_equal(principal_update(material, strain)[1], trial)


def material_entries(law: str, density: float = 2.0, **changed: Any) -> dict[str, Any]:
    """The material of a law of the core as a case file would declare it."""
    model = law.removeprefix("undrained_").removeprefix("separating_")
    fluid = PORE_FLUID if law.startswith("undrained_") else {}
    voids = {"separates": True} if law.startswith("separating_") else {}
    entries = {"model": model, "density": density, **ENTRIES[model], **fluid, **voids, **changed}
    return {key: value for key, value in entries.items() if value is not None}


def initial_stress(kind: str, law: str, body: str = "block") -> dict[str, Any]:
    """Entries of the initial stress of a law that needs one, else none."""
    if not declared(law).needs_stress:
        return {}
    stress = [START] * 3 + [0.0] * (3 if kind == "3d" else 1)
    return {"initial": {"stress": [{"type": "given", "body": body, "stress": stress}]}}


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
        **initial_stress(kind, material),
    }
    return {**entries, **changed}


GRADED = {
    "x": [[0.0, 0.7], [3.0, 1.4]],
    "y": [[0.0, 1.4], [3.0, 0.7]],
    "z": [[0.0, 0.8], [3.0, 1.2]],
}
"""Cell sizes at places along the axes: from 0 to 3 there are three cells along each."""

SPACINGS = ["uniform", "graded"]


def spaced(entries: dict[str, Any], spacing: str) -> dict[str, Any]:
    """The same on a grid that is `uniform`, as it is, or with the cells of `GRADED`; in place."""
    if spacing == "graded":
        axes = AXES[: dimension(entries["analysis"]["kind"])]
        entries["grid"]["cell_size"] = {axis: GRADED[axis] for axis in axes}
    return entries


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
        return cls(kind, points, Simulation(model, points).state.grid)

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
        if self.grid.graded:
            bound_domains(self.points, self.grid)
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
    kind: str,
    basis: str,
    material: str,
    random: np.random.Generator,
    steps: int = 3,
    spacing: str = "uniform",
    method: str = "none",
) -> Laboratory:
    """A block after some random steps: general strain, partly plastic where the soil can be.

    method: against locking.
    """
    entries = block_entries(kind, basis, material)
    entries["bodies"][0]["anti_locking"] = method
    model = Model.from_dict(spaced(entries, spacing))
    points = jittered_points(model, random, 0.4)
    laboratory = Laboratory(kind, points, Simulation(model, points).state.grid)
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
