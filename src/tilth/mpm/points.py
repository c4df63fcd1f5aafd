# SPDX-License-Identifier: BSD-3-Clause
"""`MaterialPoints`: the state of the soil, as a structure of arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Flags, Floats, Integers
from tilth.bodies.corners import corner_signs, mean_half_edges, parallelepiped
from tilth.model.laws import PLASTIC_STRAIN, Law
from tilth.mpm.elastic_moduli import ElasticModuli
from tilth.mpm.pore_water import CONSTANT, POROSITY, Permeability

_Number = TypeVar("_Number", np.int64, np.float64)

FORGOTTEN_STRAIN, FORGOTTEN_WITH_FRICTION = 1e-6, 3e-4
"""Strain over which the elastic share before a step is forgotten [-], see `PointRange`."""


@dataclass(frozen=True)
class PointRange:
    """The points of a body, or of one of its layers: a contiguous range with one basis and law.

    The ranges of a body's layers follow each other.

    Attributes:
        name: the body's name.
        start, stop: range of the points.
        basis: name of the basis.
        anti_locking: "none" or "f_bar".
        domain_update: rule by which domains follow the deformation; None without domains.
        law: the constitutive law.
        parameters: its parameters in the order of `law.parameters`, shape (count,); None if they
            vary from point to point, see `MaterialPoints.parameters`.
        density: mass per initial volume [mass/length^3]; 0 if none was declared.
        wet_density: the same below the water; None if none was declared.
        keeps_water: whether no water leaves or enters the pores when the volume changes.
        body: number of the body in the model.
        layer: number of the layer in the body; 0 if it has none.
        overlay: number of the body's; bodies of one overlay share their nodes.
        permeability: how the conductivity of its pores changes, where water flows.
    """

    name: str
    start: int
    stop: int
    basis: str
    domain_update: str | None
    law: Law
    parameters: Floats | None
    density: float
    anti_locking: str = "none"
    body: int = 0
    layer: int = 0
    wet_density: float | None = None
    keeps_water: bool = True
    overlay: int = 0
    permeability: Permeability = CONSTANT

    @property
    def points(self) -> slice:
        """The range of the points."""
        return slice(self.start, self.stop)

    @property
    def forgotten_strain(self) -> float:
        """Strain after which the elastic share of its points is that of the last step [-].

        Soil with friction that is at rest yields in one step of next to no strain and not in the
        next one; what follows the share would move it.
        """
        frictional = {"friction_angle", "friction_slope"} & set(self.law.parameters)
        return FORGOTTEN_WITH_FRICTION if frictional else FORGOTTEN_STRAIN

    @property
    def has_corners(self) -> bool:
        """Whether the points' domains have corners (CPDI)."""
        return self.basis in _core.corner_basis_names()

    @property
    def convected_by_gradient(self) -> bool:
        """Whether the domains are parallelepipeds convected by the deformation gradient (CPDI1)."""
        return self.basis == "cpdi1"


@dataclass
class MaterialPoints:
    """State of all material points; n points, dim directions, tension positive.

    Within a body the order of the points follows the grid and changes from step to step;
    `point_id` is permanent. Symmetric tensors: xx yy zz xy yz xz, tensor components; in
    axisymmetry xx is radial, yy axial and zz the hoop component.

    Attributes:
        ranges: the ranges of the bodies and their layers.
        point_id: permanent number, shape (n,).
        position: [length], shape (n, dim).
        displacement: from the initial position [length], shape (n, dim).
        last_displacement: in the last load step [length], shape (n, dim).
        last_gradient: of that displacement [-], shape (n, dim, dim).
        initial_volume: [length^dim; length^3 per full circle in axisymmetry], shape (n,).
        deformation_gradient: true F [-], shape (n, 3, 3).
        elastic_deformation: elastic left Cauchy-Green tensor less the identity [-], shape (n, 6).
        stress: Cauchy stress [stress], shape (n, 6).
        plastic: equivalent plastic strain [-] and dissipated energy per initial volume
            [stress], shape (n, 2).
        elastic_share: share of the last load step's deviatoric strain that was elastic [-],
            shape (n,): 1 where nothing yields, 0 in steady plastic flow.
        assumed_jacobian: determinant of the assumed deformation gradient of F-bar [-], shape
            (n,); 1 without.
        state: state variables of the laws, shape (n, columns): those of a point's law fill the
            first columns, see `state_variable`.
        parameters: of the laws whose parameters vary from point to point, in their order, shape
            (n, columns); see `parameters_of`.
        initial_half_length, half_length: half the side lengths of the points' domains along
            the grid's axes [length], shape (n, dim); with the linear basis, which has no domains,
            those of a box of the point's volume. For a domain with corners `half_length` is that
            of its bounding box centred at the point; its initial half lengths are along its own
            edges.
        initial_half_edge: half the initial edges of the domains convected by F (CPDI1), an edge in
            each row [length], shape (n, dim, dim); (n, 0, dim) if no body has such domains.
        corner: corners of the points' domains relative to the point, x fastest [length], shape
            (n, 2^dim, dim); (n, 0, dim) if no body's basis has corners.
        motion: velocity [length/time], acceleration and algorithmic acceleration (the one that
            displacement and velocity follow, terms/inertia.py) [length/time^2], shape (n, 3, dim);
            (n, 0, dim) without inertia.
        water: of pores in which it flows: its volume per initial volume [-], its excess pressure
            [stress], the porosity [-] and the conductivity at the start [length^4/(force time)],
            and the velocity q of the flow [length/time], shape (n, 4 + dim), with order 2 in time
            the changes of the first two in the last step, (n, 6 + dim), zeros where no water
            enters; (n, 0) in a model without.
        varying: values of the material parameters that vary from place to place, by the keys of the
            case file, in the order of the permanent numbers, shape (n,); "not a number" where the
            material has no such parameter. Only of whole sets of points; it does not change.
    """

    ranges: list[PointRange]
    point_id: Integers
    position: Floats
    displacement: Floats
    last_displacement: Floats
    last_gradient: Floats
    initial_volume: Floats
    deformation_gradient: Floats
    elastic_deformation: Floats
    stress: Floats
    plastic: Floats
    elastic_share: Floats
    assumed_jacobian: Floats
    state: Floats
    parameters: Floats
    initial_half_length: Floats
    half_length: Floats
    initial_half_edge: Floats
    corner: Floats
    motion: Floats
    water: Floats
    varying: Mapping[str, Floats] = field(default_factory=dict)

    @classmethod
    def undeformed(
        cls,
        ranges: list[PointRange],
        position: Floats,
        initial_volume: Floats,
        half_length: Floats,
        corner: Floats | None = None,
        parameters: Mapping[int, Floats] | None = None,
        varying: Mapping[str, Floats] | None = None,
    ) -> MaterialPoints:
        """Returns undeformed, stress-free points numbered in the order given.

        parameters: of the ranges that have none, by the numbers of the ranges, shape (points of
            the range, count).
        varying: as the attribute.
        corner: as the attribute, for all points if any body has domains with corners; those of
            CPDI1 must be parallelepipeds. None for boxes with the half lengths.
        """
        n, dim = position.shape
        if not any(range_.has_corners for range_ in ranges):
            corner = np.zeros((n, 0, dim))
        elif corner is None:
            corner = corner_signs(dim) * half_length[:, None]
        convected = any(range_.convected_by_gradient for range_ in ranges)
        points = cls(
            ranges=ranges,
            point_id=np.arange(n),
            position=np.array(position, dtype=np.float64, order="C"),
            displacement=np.zeros_like(position),
            last_displacement=np.zeros_like(position),
            last_gradient=np.zeros((n, position.shape[1], position.shape[1])),
            initial_volume=np.array(initial_volume, dtype=np.float64, order="C"),
            deformation_gradient=np.tile(np.eye(3), (n, 1, 1)),
            elastic_deformation=np.zeros((n, 6)),
            stress=np.zeros((n, 6)),
            plastic=np.zeros((n, 2)),
            elastic_share=np.ones(n),
            assumed_jacobian=np.ones(n),
            state=np.zeros((n, max((len(r.law.state_variables) for r in ranges), default=0))),
            parameters=_varying_parameters(ranges, parameters or {}, n),
            initial_half_length=np.array(half_length, dtype=np.float64, order="C"),
            half_length=np.array(half_length, dtype=np.float64, order="C"),
            initial_half_edge=mean_half_edges(corner) if convected else np.zeros((n, 0, dim)),
            corner=np.array(corner, dtype=np.float64, order="C"),
            motion=np.zeros((n, 0, dim)),
            water=np.zeros((n, 0)),
            varying=varying or {},
        )
        points.update_bounding_boxes()
        for range_ in ranges:
            points.part(range_).start_with(np.zeros((range_.stop - range_.start, 6)))
        return points

    def start_with(self, stress: Floats, variables: Mapping[str, Floats] | None = None) -> int:
        """Gives points of one body, without deformation, a stress and the state that belongs to it.

        stress: effective Cauchy stress, tension positive, shape (n, 6).
        variables: state variables of the law by name, shape (n,) each, NaN for those that the law
            gives; others are not used.

        Returns the first point whose law cannot have its stress, -1 if all can.
        """
        (range_,) = self.ranges
        parameters = self.parameters_of(range_)
        law, tensors = range_.law.core, self.tensors
        failed = _core.initial_state(tensors, law, parameters, stress, self.state)
        for column, name in enumerate(range_.law.state_variables):
            given = (variables or {}).get(name)
            if failed < 0 and given is not None:
                known = ~np.isnan(given)
                self.state[known, column] = given[known]
        if failed < 0:
            failed = _core.elastic_deformation_of(
                tensors, law, parameters, stress, self.state, self.elastic_deformation
            )
        self.stress[:] = stress
        return failed

    def parameters_of(self, range_: PointRange) -> Floats:
        """Returns the parameters of a range's law, shape (count,) or (its points, count)."""
        if range_.parameters is not None:
            return range_.parameters
        first = self.ranges[0].start  # not 0 in a part
        s = slice(range_.start - first, range_.stop - first)
        return np.ascontiguousarray(self.parameters[s, : len(range_.law.parameters)])

    def update_bounding_boxes(self) -> None:
        """Sets the half lengths of domains with corners to those of their bounding boxes."""
        for range_ in self.ranges:
            if range_.has_corners:
                part = self.part(range_)
                part.half_length[:] = np.abs(part.corner).max(axis=1)

    def convected_corners(self) -> Floats:
        """Returns the corners of the initial parallelepipeds convected by F, (n, 2^dim, dim)."""
        dim = self.position.shape[1]
        gradient = self.deformation_gradient[:, :dim, :dim]
        return parallelepiped(np.einsum("nij,nkj->nki", gradient, self.initial_half_edge))

    def all_corners(self) -> Floats | None:
        """Returns the corners of all domains relative to the points [length], (n, 2^dim, dim).

        A domain without corners is the box with its half lengths. None if no body's basis has
        corners.
        """
        if self.corner.shape[1] == 0:
            return None
        corners = self.corner.copy()
        for range_ in self.ranges:
            if not range_.has_corners:
                s = slice(range_.start, range_.stop)
                corners[s] = corner_signs(self.position.shape[1]) * self.half_length[s, None]
        return corners

    def __len__(self) -> int:
        return len(self.point_id)

    @classmethod
    def array_names(cls) -> list[str]:
        """Returns the names of the per-point arrays."""
        return [f.name for f in fields(cls) if f.name not in ("ranges", "varying")]

    def arrays(self) -> dict[str, npt.NDArray[np.generic]]:
        """Returns the per-point arrays by name: with `ranges` they are the state to store."""
        return {name: getattr(self, name) for name in self.array_names()}

    def part(self, range_: PointRange) -> MaterialPoints:
        """Returns the points of a range: views of the arrays, no copies."""
        views = {name: array[range_.start : range_.stop] for name, array in self.arrays().items()}
        return MaterialPoints(ranges=[range_], **views)  # type: ignore[arg-type]

    def permute(self, range_: PointRange, order: Integers) -> None:
        """Reorders the points of a range: the point with index `order[i]` moves to index i."""
        for array in self.arrays().values():
            array[range_.points] = array[range_.points].take(order, axis=0)

    @property
    def body_id(self) -> Integers:
        """Number of each point's body, shape (n,)."""
        return self._of_ranges(np.array([range_.body for range_ in self.ranges]))

    @property
    def layer(self) -> Integers:
        """Number of each point's layer in its body, shape (n,)."""
        return self._of_ranges(np.array([range_.layer for range_ in self.ranges]))

    def overlays_of(self, chosen: Integers) -> Integers | int:
        """Returns the overlay of points by their indices, shape (k,); 0 if all are 0."""
        if all(range_.overlay == 0 for range_ in self.ranges):
            return 0
        return self._of_ranges(np.array([range_.overlay for range_ in self.ranges]))[chosen]

    def overlay_of_body(self, name: str) -> int:
        """Returns the overlay of the body with this name; 0 if it is not there."""
        return next((range_.overlay for range_ in self.ranges if range_.name == name), 0)

    def _of_ranges(self, values: npt.NDArray[_Number]) -> npt.NDArray[_Number]:
        """Returns the value of each point's range, shape (n,)."""
        return np.repeat(values, [range_.stop - range_.start for range_ in self.ranges])

    def whole_bodies(self) -> list[tuple[PointRange, slice]]:
        """Returns the first range of each body, and the points of all its ranges, in order."""
        number = [range_.body for range_ in self.ranges]
        firsts = [
            range_ for i, range_ in enumerate(self.ranges) if i == 0 or number[i - 1] != range_.body
        ]
        ends = [body.start for body in firsts[1:]] + [len(self)]
        return [(body, slice(body.start, end)) for body, end in zip(firsts, ends, strict=True)]

    def of_body(self, name: str) -> slice:
        """Returns the range of the points of the body with this name, all its layers.

        It is empty if the body is not there.
        """
        found = (points for body, points in self.whole_bodies() if body.name == name)
        return next(found, slice(0, 0))

    @property
    def mass(self) -> Floats:
        """Mass of each point [mass, per unit length or full circle in 2D], shape (n,)."""
        density = self._of_ranges(np.array([range_.density for range_ in self.ranges]))
        return np.asarray(density * self.initial_volume)

    @property
    def volume(self) -> Floats:
        """Current volume of each point, det F times the initial one, shape (n,)."""
        return np.asarray(_core.current_volumes(self.deformation_gradient, self.initial_volume))

    @property
    def has_flow(self) -> bool:
        """Whether water flows in the model."""
        return bool(self.water.shape[1] > 0)

    @property
    def conducts(self) -> Flags:
        """In which points water flows, in a model with flow, shape (n,)."""
        return np.asarray(self.water[:, POROSITY] > 0.0)

    @property
    def stress_jacobian(self) -> Floats:
        """Kirchhoff over Cauchy stress: det F, with F-bar that of the assumed F [-], shape (n,)."""
        jacobian = self.volume / self.initial_volume
        for range_ in self.ranges:
            if range_.anti_locking == "f_bar":
                jacobian[range_.points] = self.assumed_jacobian[range_.points]
        return jacobian

    def state_variables(self) -> list[str]:
        """Returns the names of the state variables of all bodies' laws."""
        names = [name for range_ in self.ranges for name in range_.law.state_variables]
        return list(dict.fromkeys([PLASTIC_STRAIN, *names]))

    def state_variable(self, name: str) -> Floats:
        """Returns a state variable of the points, shape (n,); NaN where the law does not have it.

        Units: `tilth.Model.state_units`.
        """
        if name == PLASTIC_STRAIN:
            return self.plastic[:, 0]
        values = np.full(len(self), np.nan)
        for range_ in self.ranges:
            own = list(range_.law.state_variables)
            if name in own:
                s = slice(range_.start, range_.stop)
                values[s] = self.state[s, own.index(name)]
        return values

    def elastic_moduli(self) -> ElasticModuli:
        """Returns the tangent elastic moduli at the points' states."""
        bulk, shear, young = (np.empty(len(self)) for _ in range(3))
        for range_ in self.ranges:
            s = slice(range_.start, range_.stop)
            _core.elastic_moduli(
                self.tensors, range_.law.core, self.parameters_of(range_),
                self.elastic_deformation[s], self.state[s], bulk[s], shear[s], young[s],
            )  # fmt: skip
        return ElasticModuli(bulk, shear, young)

    def stored_energy(self) -> float:
        """Returns the elastic strain energy of all points [force length]."""
        total = 0.0
        for range_ in self.ranges:
            s = slice(range_.start, range_.stop)
            density = np.empty(range_.stop - range_.start)
            _core.stored_energy(
                self.tensors, range_.law.core, self.parameters_of(range_),
                self.elastic_deformation[s], self.state[s], density,
            )  # fmt: skip
            total += float(density @ self.initial_volume[s])
        return total

    def kinetic_energy(self, mass: Floats) -> float:
        """Returns the kinetic energy of all points [force length]; mass: theirs [mass], (n,)."""
        return 0.5 * float(mass @ (self.motion[:, :1] ** 2).sum(axis=(1, 2)))

    @property
    def elastic_strain(self) -> Floats:
        """Elastic logarithmic strain [-], half the logarithm of that tensor, shape (n, 6)."""
        strain = np.empty_like(self.elastic_deformation)
        _core.elastic_strain(self.tensors, self.elastic_deformation, strain)
        return strain

    @elastic_strain.setter
    def elastic_strain(self, strain: Floats) -> None:
        _core.elastic_deformation(self.tensors, strain, self.elastic_deformation)

    @property
    def tensors(self) -> str:
        """A kind of analysis whose tensors have the same components."""
        return "3d" if self.position.shape[1] == 3 else "plane_strain"

    def index_of(self, point_ids: Integers) -> Integers:
        """Returns the current indices of points by their permanent numbers; -1 where not there."""
        greatest = max(int(ids.max(initial=-1)) for ids in (self.point_id, point_ids))
        where = np.full(greatest + 1, -1)
        where[self.point_id] = np.arange(len(self))
        return where[point_ids]

    @property
    def in_order(self) -> Integers:
        """Current indices of the points in the order of their permanent numbers, shape (n,)."""
        return np.argsort(self.point_id)

    def selected(self, kept: Flags) -> MaterialPoints:
        """Returns copies of the points with a flag, shape (n,), in their order.

        Ranges without points are left out.
        """
        arrays = {name: array[kept] for name, array in self.arrays().items()}
        counts = [int(kept[range_.points].sum()) for range_ in self.ranges]
        ranges = _ranges_of(self.ranges, counts)
        return MaterialPoints(ranges=ranges, varying=self.varying, **arrays)  # type: ignore[arg-type]

    def joined(self, other: MaterialPoints) -> MaterialPoints:
        """Returns the points of both, whose ranges are of different bodies or layers.

        The ranges are in the order of the bodies and their layers, and the arrays have the same
        columns. `varying` is that of `self`.
        """
        found = sorted(
            ((range_, each) for each in (self, other) for range_ in each.ranges),
            key=lambda pair: (pair[0].body, pair[0].layer),
        )
        arrays = {
            name: np.concatenate([getattr(each, name)[range_.points] for range_, each in found])
            for name in self.array_names()
        }
        ranges = _ranges_of([b for b, _ in found], [b.stop - b.start for b, _ in found])
        return MaterialPoints(ranges=ranges, varying=self.varying, **arrays)


def _ranges_of(ranges: list[PointRange], counts: list[int]) -> list[PointRange]:
    """Returns ranges with other numbers of points that follow each other; empty ones left out."""
    ends = np.cumsum(counts).tolist()
    return [
        replace(range_, start=end - count, stop=end)
        for range_, count, end in zip(ranges, counts, ends, strict=True)
        if count
    ]


def _varying_parameters(
    ranges: list[PointRange], parameters: Mapping[int, Floats], points: int
) -> Floats:
    """Returns the parameters of the ranges that have none, shape (points, columns)."""
    columns = max((array.shape[1] for array in parameters.values()), default=0)
    values = np.zeros((points, columns))
    for number, array in parameters.items():
        range_ = ranges[number]
        values[range_.start : range_.stop, : array.shape[1]] = array
    return values
