"""Kernels of tilth: flat arrays in, flat arrays out, no hidden state."""

from typing import Annotated, overload

import numpy
from numpy.typing import NDArray


def set_threads(threads: int) -> None:
    """Number of threads of all following kernels, 1 to 1024."""

def threads() -> int:
    """Number of threads in use."""

def set_parallel_from(points: int) -> None:
    """Number of points from which loops use more than one thread."""

def parallel_from() -> int:
    """Number of points from which loops use more than one thread."""

class Checked:
    """What the core has checked of an object."""

    def __init__(self) -> None: ...

    def __reduce__(self) -> tuple[type[Checked], tuple[()]]: ...

def basis_names() -> list[str]:
    """Names of the bases, in the order of basis/list.hpp."""

def support_keys(basis: str, position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], half_length: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: object, keys: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu')]) -> int:
    """
    Fills the support key of each point; returns how many are out of range (key -1).
    """

def group_points(dim: int, keys: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)]) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64], NDArray[numpy.int32]]:
    """
    Groups of sorted keys: start (g+1), first node (g,3), nodes per direction (g,3).
    """

def active_nodes(first: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], count: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)]) -> NDArray[numpy.int64]:
    """Sorted keys of all nodes of the groups."""

def lattice(keys: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)]) -> NDArray[numpy.int64]:
    """Lattice indices (n,3) of node keys."""

def node_keys(indices: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)]) -> NDArray[numpy.int64]:
    """Keys of lattice indices (n,3); -1 for an index out of range."""

def group_nodes(first: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], count: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], keys: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], node_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)]) -> NDArray[numpy.int32]:
    """Node numbers of each group, x fastest."""

def basis_factors(basis: str, start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], first: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], count: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], value_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], half_length: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: object, factors: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Fills the factors of all points' basis, direction by direction."""

def basis_values(stencil: object, value: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], gradient: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Fills basis values, then gradients (dim, nodes), point after point."""

def colour_groups(first: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], count: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)]) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64], NDArray[numpy.int64]]:
    """Order of parallel assembly: colour_start, slab_start, order."""

def corner_basis_names() -> list[str]:
    """Names of the bases whose points' domains have corners."""

def corner_supports(position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], corner: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: object) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64], int]:
    """
    Key (-1: out of range, -2: too wide) and codes of each support; number of failures.
    """

def group_corner_points(dim: int, keys: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], codes: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)]) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64], NDArray[numpy.int32], NDArray[numpy.int64], NDArray[numpy.int64], NDArray[numpy.int64], NDArray[numpy.int64]]:
    """
    Groups of sorted supports: start, first, count, cell_start, cell keys, node_start, node keys.
    """

def corner_basis_values(start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], node_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], node_keys: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], value_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], corner: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: object, value: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Fills basis values and gradients of all points."""

def move_corners(position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], corner: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], node_keys: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], displacement: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: object, axisymmetric: bool, moved: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], shift: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> int:
    """
    Fills the moved corners and the points' displacements; first folded domain or -1.
    """

def share_corner_domains(stencil: object, position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], corner: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], weight: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: object, cell_keys: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], axisymmetric: bool) -> tuple[NDArray[numpy.int32], NDArray[numpy.int32], NDArray[numpy.int64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64]]:
    """
    Cells and their nodes' indices in the groups, shares, moments of the cells, and those of the hoop (see f_bar.py).
    """

def response_size(kind: str) -> int:
    """Number of doubles per point in the response of stress_update."""

def elastic_deformation(kind: str, strain: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], deformation: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Fills exp(2 strain) - 1, six components per point."""

def elastic_strain(kind: str, deformation: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], strain: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Fills log(1 + deformation) / 2, six components per point."""

def volumetric_strains(deformation: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
    """Traces of log(1 + deformation) / 2, one per point."""

def stress_update(kind: str, material: object, parameters: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], stencil: object, displacement: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], elastic_before: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], plastic_before: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], state_before: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], elastic: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], plastic: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], state: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], response: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], centres: object | None, torn_off: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu', writable=False)], kept: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu')], interval: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> tuple[int, int]:
    """
    Stress update of all points; returns (point, status): (-1, 0) or the first failure (status 1: inverted, 2: return mapping). Points that are torn_off may keep their shape; it fills kept. Both are empty if none is. interval (3,): the time at the start of the step in the stage and in total, and its size.
    """

def internal_force(kind: str, stencil: object, volume: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], response: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], force: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], centres: object | None) -> None:
    """Adds the internal force to force (nodes, dim)."""

def stiffness(kind: str, stencil: object, block_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], block_position: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], volume: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], response: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], matrix: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], centres: object | None) -> None:
    """Adds the consistent stiffness to the blocks (entries, dim, dim)."""

def add_mass(stencil: object, block_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], block_position: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], mass: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], matrix: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Adds the points' consistent mass to the blocks (entries)."""

def fill_cells(stencil: object, position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], half_length: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], volume: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], weight: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: object, cell_keys: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], filled: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    Adds volume and volume times weight of the points to filled (cells, 2).
    """

def share_among_cells(stencil: object, position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], half_length: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], weight: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: object, cell_keys: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], axisymmetric: bool) -> tuple[NDArray[numpy.int64], NDArray[numpy.int32], NDArray[numpy.int64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64]]:
    """
    Cells of each group, shares of each point, moments of the cells, and those of the hoop (see f_bar.py).
    """

def update_centres(kind: str, node: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], gradient: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], hoop_gradient: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], displacement: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], volume_change: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], trace: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], hoop_change: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    Fills volume_change, trace and hoop_change of F-bar's cells for a nodal displacement (see f_bar.py).
    """

def smooth_strains(group_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], centres: object, cells: int, strain: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], volume: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], fraction: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
    """
    Increments of the points' volumetric strains towards their cells' mean (see f_bar.py).
    """

def add_predictions(stencil: object, node_position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], displacement: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], gradient: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], volume: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], sum: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    Adds weights and weighted displacements of the points' fields to sum (nodes, 1+dim).
    """

def current_volumes(deformation_gradient: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], initial_volume: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
    """det F times the initial volume of each point."""

@overload
def advance(kind: str, stencil: object, displacement: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], response: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], plastic_before: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], plastic_after: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], last_gradient: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], deformation_gradient: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], cauchy: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], elastic_share: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], forgotten_strain: float, kept: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu', writable=False)]) -> None:
    """
    Updates the points' arrays after a converged step with this displacement.
    """

@overload
def advance(length: float, p: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], q: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], x: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], r: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> float:
    """
    Adds length p to x, subtracts length q from r; returns r . r, as `inner`.
    """

def stretch_domains(kind: str, rule: str, deformation_gradient: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], initial_half_length: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], half_length: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Half lengths of domains from the deformation gradient."""

def move_domain_faces(position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], node_keys: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], displacement: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: object, half_length: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Half lengths of domains from their moved faces."""

def step_inverses(kind: str, stencil: object, displacement: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], determinant: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], inverse: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    Fills determinants (n) and inverses (n, 3, 3) of the points' deformation gradients of the step.
    """

def add_force_derivative(stencil: object, block_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], block_position: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], by_displacement: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], by_gradient: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], matrix: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    Adds the derivative of forces S_a f of the points by their displacement (n, dim, dim) and its gradient (n, dim, dim, dim) to the blocks (entries, dim, dim).
    """

def scatter(stencil: object, vector: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], nodal: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Adds sum_p S_a vector_p to nodal."""

def interpolate(stencil: object, nodal: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], vector: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Fills the points' interpolated vectors."""

def scatter_gradient(stencil: object, flux: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], nodal: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    Adds sum_p flux_p grad S_a, flux (n, components, dim), to nodal (nodes, components); 1 or dim components.
    """

def interpolate_gradient(stencil: object, nodal: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], gradient: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    Fills the points' gradients (n, components, dim) of nodal (nodes, components); 1 or dim components.
    """

def add_point_blocks(stencil: object, block_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], block_position: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], point_matrix: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], matrix: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    Adds sum_p S_a D_p S_b with S = (value, gradient) and the points' matrices D (n, r, 1+dim, c, 1+dim) to the blocks (entries, r, c); r and c are 1 or dim.
    """

def materials() -> dict[str, tuple[list[str], list[tuple[str, str]], bool]]:
    """
    Name -> (parameter names, names and units of state variables, symmetric tangent).
    """

def initial_state(kind: str, material: object, parameters: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], kirchhoff: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], state: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> int:
    """
    Fills the state variables of points with Kirchhoff stresses (n, 6) at the start; returns the first point whose law cannot have its stress, else -1.
    """

def elastic_moduli(kind: str, material: object, parameters: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], deformation: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], state: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], bulk: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], shear: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], young: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Fills the bulk, shear and Young's modulus of each point."""

def stored_energy(kind: str, material: object, parameters: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], deformation: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], state: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], energy: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Fills the stored energy per unit initial volume of each point."""

def elastic_deformation_of(kind: str, material: object, parameters: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], kirchhoff: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], state: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], deformation: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> int:
    """
    Elastic deformation of Kirchhoff stresses (n, 6); returns the first point whose law has none, else -1.
    """

def return_to_law(kind: str, material: object, parameters: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], trial: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], plastic_before: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], state_before: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], elastic: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], plastic: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], state: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], kirchhoff: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], admissible: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu')]) -> None:
    """Return mapping of elastic deformations (n, 6) taken as trial states."""

def update_of_gradients(kind: str, material: object, parameters: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], gradient: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], elastic_before: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], plastic_before: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], state_before: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], elastic: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], plastic: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], state: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], kirchhoff: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], tangent: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], interval: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> tuple[int, int]:
    """
    Stress update for the step's displacement gradients (n, 3, 3); fills also the Kirchhoff stress (n, 6) and its derivative (n, 6, 9). Returns as stress_update.
    """

def principal_update(material: object, parameters: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], trial: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], plastic_before: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], state_before: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], state: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], kirchhoff: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], elastic: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], tangent: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')], admissible: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu')]) -> None:
    """Return mapping of points (n, 3) in principal axes."""

def block_pattern(nodes: int, node_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], node: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)]) -> tuple[NDArray[numpy.int64], NDArray[numpy.int32]]:
    """Rows and sorted columns of all pairs of nodes that share a group."""

def block_positions(node_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], node: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], row_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], column: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)]) -> tuple[NDArray[numpy.int64], NDArray[numpy.int32]]:
    """Positions of each group's blocks in the pattern."""

def restrict_to_free(components: int, row_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], column: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], order: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], constrained: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu', writable=False)]) -> tuple[NDArray[numpy.int64], NDArray[numpy.int32], NDArray[numpy.int32], NDArray[numpy.int64]]:
    """
    Matrix of the free unknowns: unknown, column starts, rows, indices in the blocks.
    """

def gather(source: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], block: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], value: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Fills value[i] = block[source[i]]."""

def nested_dissection(lattice: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], coupling_distance: int) -> NDArray[numpy.int64]:
    """Node numbers in a fill-reducing order of elimination."""

def connected_parts(row_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], column: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)]) -> NDArray[numpy.int64]:
    """Number of the connected component of each row of a symmetric pattern."""

def project(row_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], column: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], value: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], shift: float, known: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu', writable=False)], tolerance: float, limit: int, scale: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], right: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> bool:
    """
    Replaces right sides (rows, 4, 8 or 12) by the solutions for a symmetric matrix, zero where known; returns whether conjugate gradients converged to the tolerance times scale.
    """

def symmetric_product(row_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], column: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], value: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], x: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], product: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Fills the product of a matrix with 2 or 3 columns x."""

def column_product(start: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], row: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], value: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], x: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], product: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Fills the product A x of a square matrix in compressed columns."""

class BandFactors:
    """LU factors of matrices in compressed columns; pattern fixed."""

    def __init__(self, start: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], row: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)]) -> None: ...

    def widths(self) -> list[int]:
        """Widths of the factors' band below and above the diagonal."""

    def factorise(self, value: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> bool:
        """
        Factorises a matrix with these values; returns whether no pivot is zero.
        """

    def solve(self, right: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], solution: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
        """Fills the solution for one right side."""

def add_element_forces(elements: object, force: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], nodal: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    Adds the elements' forces (entries, components) to nodal (nodes, components).
    """

def add_dense_products(elements: object, matrix: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], vector: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], magnitude: bool, product: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    Adds the elements' matrices (e, n, n, components, components), or those of their entries' magnitudes, times vector to product.
    """

def add_dense_blocks(elements: object, matrix: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], blocks: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    Adds the elements' matrices (e, n, n, components, components) to the node-block matrix.
    """

def add_scaled_products(elements: object, weight: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], unit: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], which: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], free: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu', writable=False)], vector: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], magnitude: bool, product: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    As add_dense_products for matrices weight_e unit_ab of each free component; which: the unit (units, n, n) of each element.
    """

def add_scaled_blocks(elements: object, weight: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], unit: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], which: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], free: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu', writable=False)], blocks: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    As add_dense_blocks for matrices weight_e unit_ab of each free component; which: the unit (units, n, n) of each element.
    """

def add_row_products(elements: object, row: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], vector: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], magnitude: bool, product: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    As add_dense_products for matrices that are a row's product with itself.
    """

def add_row_blocks(elements: object, row: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], blocks: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """As add_dense_blocks for matrices that are a row's product with itself."""

def add_outer_blocks(elements: object, column: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], row: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], blocks: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """
    As add_dense_blocks for matrices that are the product of a column and a row.
    """

def cut_simplices(corner: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: object) -> tuple[NDArray[numpy.float64], NDArray[numpy.int64]]:
    """
    Segments or triangles (n,dim,dim) cut at the grid: pieces, and the facet of each.
    """

def find_contact(start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], normal: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], part: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], centre: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], half_length: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], edge: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], inverse: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], around: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], reach: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: object) -> tuple[NDArray[numpy.int64], NDArray[numpy.float64]]:
    """
    Number of the nearest material point in contact with each quadrature point, -1 without contact, and the fraction of its tributary area in contact.
    """

def boundary_penalty(normal: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], projector: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], moduli: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], square: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
    """Stress per slip (n,dim,dim) of a boundary's quadrature points."""

def measure_gap(position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], normal: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], behind: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], reach: float, centre: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], half_length: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], corner: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: object, widening: float) -> tuple[NDArray[numpy.float64], NDArray[numpy.int64]]:
    """
    Distances along normals (n,dim) from surface points to the material points' domains, and the material point whose domain is entered; -1 and +-inf without an entry.
    """

def multiplier_space(start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], node: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], local: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], normal: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], lattice: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], grid: object, first_cell: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], end_cell: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], first_direction: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], direction: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], constrained: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu', writable=False)]) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64], NDArray[numpy.int64], NDArray[numpy.float64]]:
    """
    Vertices of a step's boundaries: the owner of each direction of each point, and of each vertex the family, the nearest point and the position in cells.
    """

def exterior_nodes(start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], node: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], local: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], normal: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], lattice: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], grid: object) -> tuple[NDArray[numpy.int64], NDArray[numpy.float64]]:
    """
    Sorted keys of exterior nodes and their depth along each axis (nodes,dim,2).
    """

def multiplier_means(multipliers: int, owner: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], point: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], cell: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], node: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], weight: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], direction: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], penalty: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], value: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.int64], NDArray[numpy.int32], NDArray[numpy.float64]]:
    """
    Areas, penalties, and ragged rows (starts, nodes, coefficients) of the multipliers.
    """

def locate_in_cells(position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: object, cell_keys: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)]) -> tuple[NDArray[numpy.int64], NDArray[numpy.float64]]:
    """
    Keys of the cells with soil in or nearest to which points (n,dim) lie, and the points' local coordinates (n,dim), in cells.
    """

def shape_values(local: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
    """
    Shape functions (n,2^dim) at local coordinates (n,dim) in a cell, x fastest.
    """

def shape_functions(local: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], size: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64]]:
    """
    Shape functions (n,2^dim) and their gradients (n,2^dim,dim) at local coordinates in cells of the sizes (n,dim).
    """

def interpolate_in_cells(start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], node: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], value: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], nodal: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
    """sum_a N_a nodal_a at the points of each cell."""

def scatter_in_cells(start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], node: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], value: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], vector: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], nodal: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Adds sum_q N_qa vector_q to nodal."""

def trace_of_domains(start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], position: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], owner: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], shift: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], centre: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], corner: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], grid: object, cell_keys: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], keys: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], cell_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], node: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], value: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64], NDArray[numpy.float64]]:
    """
    Displacements at places by those of nodes, the mean over each place's samples on domains with corners: number of nodes of each place, nodes and shares.
    """

class Multigrid:
    """Geometric multigrid over an integer lattice of nodes; pattern fixed."""

    def __init__(self, dim: int, components: int, lattice: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], row_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], column: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], constrained: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu', writable=False)]) -> None: ...

    def begin(self) -> None:
        """
        Discards all matrices; later results are identical to those of a new object.
        """

    def fill(self, blocks: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> None:
        """Sets the values of the matrix."""

    def cycle(self, residual: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], approximate: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
        """Fills `approximate` with one V-cycle for `residual`."""

    def sizes(self) -> list[int]:
        """Nodes and blocks of each level, the finest first."""

    def bytes(self) -> int:
        """Memory of all levels [byte]."""

class CoarsePart:
    """What chosen rows of a matrix give to that of the next coarser level."""

    def __init__(self, dim: int, components: int, lattice: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], row_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], column: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], constrained: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu', writable=False)], chosen: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu', writable=False)]) -> None: ...

    def pattern(self) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64], NDArray[numpy.int32]]:
        """Lattice indices (n, 3), row starts and columns of that level."""

    def blocks(self, blocks: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
        """Returns its blocks, from those of the matrix."""

    def restricted(self, fine: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
        """
        Returns what the chosen rows of a residual give, (coarse nodes, components).
        """

    def interpolated(self, coarse: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
        """
        Returns interpolated values, zero where constrained, (nodes, components).
        """

def block_product(components: int, row_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], column: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], blocks: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], constrained: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu', writable=False)], x: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], product: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Fills the product A x, zero where constrained."""

def asymmetry(components: int, row_start: Annotated[NDArray[numpy.int64], dict(order='C', device='cpu', writable=False)], column: Annotated[NDArray[numpy.int32], dict(order='C', device='cpu', writable=False)], blocks: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], constrained: Annotated[NDArray[numpy.bool_], dict(order='C', device='cpu', writable=False)], u: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], v: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> list[float]:
    """Returns A v . A v, u . A v and v . A u."""

def inner(a: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], b: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> float:
    """Inner product, identical for any number of threads."""

def two_inner(a: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], b: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], c: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)]) -> list[float]:
    """Inner products a . b and a . c, as `inner`."""

def combine(a: float, x: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu', writable=False)], b: float, y: Annotated[NDArray[numpy.float64], dict(order='C', device='cpu')]) -> None:
    """Replaces y by a x + b y."""

class UserCode:
    """
    Context of code of the user. If it ends the process, this is said with the name; the working folder is that of before at the end.
    """

    def __init__(self, name: str) -> None: ...

    def __enter__(self) -> None: ...

    def __exit__(self, *args: object) -> None: ...

def set_user_code_note(kept: str = '', file: int = -1) -> None:
    """
    Sets what is said of the results when code of the user ends the process, and a file that gets a line, -1 for none.
    """
