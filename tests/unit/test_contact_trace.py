# SPDX-License-Identifier: BSD-3-Clause
"""Displacement of soil where a surface meets it, its share of the surface, and small patches."""

from __future__ import annotations

import numpy as np
import pytest
from contact_terms import DRIVEN, next_contact, pressed
from small_problems import dimension

from tilth.arrays import Floats
from tilth.bodies.corners import corner_signs
from tilth.boundaries.contact.law import ContactLaw, respond
from tilth.boundaries.contact.surface import AWAY, NEVER
from tilth.boundaries.surfaces.measure import (
    DENSE,
    EVEN,
    Coordinates,
    SurfaceParts,
    covered,
    measure,
    part_samples,
)
from tilth.boundaries.surfaces.patches import SLIVER, is_sliver, without_small
from tilth.boundaries.surfaces.trace import trace_of_domains
from tilth.geometry.quadrature import _tributary_parts
from tilth.grid.background import Grid
from tilth.model.laws import laws
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.mpm.points import MaterialPoints, PointRange
from tilth.mpm.quadrature import find_cells, locate_in_cells, points_in_cells


def domains(corner: Floats, overlays: int = 1) -> tuple[MaterialPoints, ActiveGrid]:
    """Points of CPDI2 at (2, 2, ...) with these corners (n, 2^dim, dim), and the grid they use.

    overlays: number of bodies, of equal numbers of points, with an overlay each.
    """
    count, _, dim = corner.shape
    law, parameters, each = laws()["hencky_elastic"], np.array([1.0, 0.0]), count // overlays
    bodies = [
        PointRange(str(i), i * each, (i + 1) * each, "cpdi2", None, law, parameters, 0.0, overlay=i)
        for i in range(overlays)
    ]
    position = np.full((count, dim), 2.0)
    points = MaterialPoints.undeformed(bodies, position, np.ones(count), np.ones((count, dim)))
    points.corner[:] = corner
    return points, locate(points, Grid(np.zeros(dim), np.ones(dim)), Buffers())


def interpolated(active: ActiveGrid, position: Floats, overlay: int, nodal: Floats) -> Floats:
    """Nodal values (nodes, k) at positions (n, dim) by the functions of their cells."""
    order, at = locate_in_cells(active, position, overlay)
    found = np.empty((len(position), nodal.shape[1]))
    found[order] = at.interpolate(nodal)
    return found


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("overlays", [1, 2])
def test_trace_of_distorted_domains(dim: int, overlays: int) -> None:
    """At places in them, also at their corners and a little outside, and the mean of two places.

    Outside of the core: sum_c w_c u(x_c) with the weights from which the places were made.
    """
    random = np.random.default_rng(4)
    corner = 0.4 * (corner_signs(dim) + random.uniform(-0.2, 0.2, (300, 2**dim, dim)))
    xi = random.uniform(-1.2, 1.2, (300, dim))
    xi[:50] = np.sign(xi[:50])
    weight = (0.5 * (1.0 + corner_signs(dim) * xi[:, None])).prod(axis=2)
    position = 2.0 + np.einsum("nc,nci->ni", weight, corner)
    points, active = domains(corner, overlays)
    nodal = np.column_stack([active.position, random.uniform(size=active.nodes)])
    exact = np.empty((300, dim + 1))
    for own in range(300):
        of_corners = interpolated(active, 2.0 + corner[own], own // (300 // overlays), nodal)
        exact[own] = weight[own] @ of_corners
    np.testing.assert_allclose(exact[:, :dim], position, atol=1e-12)
    sample = random.permutation(300)
    cells = points_in_cells(active, *find_cells(active, np.full((150, dim), 2.3)))
    trace = trace_of_domains(
        active, points, cells, np.tile(np.arange(150), 2), position[sample], sample
    )
    mean = exact[sample].reshape(2, 150, -1).mean(axis=0)
    np.testing.assert_allclose(trace.interpolate(nodal), mean, atol=1e-11)
    assert (np.diff(trace.place) >= 0).all()


def test_places_far_from_a_domain_and_flat_domains_have_the_trace_of_their_cells() -> None:
    corner = np.tile(0.4 * corner_signs(2), (4, 1, 1))
    corner[1, :, 1] *= 1e-12
    points, active = domains(corner)
    offset = 0.4 * np.array([[0.3, 1.7], [0.0, 0.5], [0.3, 1.2]])
    at = points_in_cells(active, *find_cells(active, np.full((4, 2), 2.3)))
    trace = trace_of_domains(active, points, at, np.arange(3), 2.0 + offset, np.arange(3))
    expected = [[2.3, 2.3], [2.3, 2.3], [2.12, 2.48], [2.3, 2.3]]  # none of the last place's
    np.testing.assert_allclose(trace.interpolate(active.position), expected, rtol=1e-13)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("coordinates", [EVEN, DENSE])
def test_samples_of_all_parts_fill_the_piece(dim: int, coordinates: Coordinates) -> None:
    """A segment, a triangle: means of linear functions and of squares, over all variants."""
    piece = np.array([[0.0, 0.0], [3.0, 1.0]]) if dim == 2 else np.eye(3)
    parts = _tributary_parts(np.tile(piece, (16, 1, 1)))
    weight = np.linalg.norm(parts[:, 1], axis=1) if dim == 2 else np.ones(len(parts))
    zero = np.zeros((len(parts), dim))
    places = part_samples(SurfaceParts(zero, zero, parts), coordinates)
    mean = np.einsum("n,nsi->i", weight, places) / weight.sum() / places.shape[1]
    even = coordinates is EVEN
    np.testing.assert_allclose(mean, piece.mean(axis=0), rtol=1e-12 if even else 1e-3)
    square = np.einsum("n,nsi->i", weight, places**2) / weight.sum() / places.shape[1]
    exact = np.array([3.0, 1.0 / 3.0]) if dim == 2 else np.full(3, 1.0 / 6.0)
    np.testing.assert_allclose(square, exact, rtol=0.05 if even else 2e-3)


@pytest.mark.parametrize("coordinates", [EVEN, DENSE])
def test_samples_fill_parallelograms(coordinates: Coordinates) -> None:
    edges = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 1.0], [0.0, 1.0, 3.0]])
    zero = np.zeros((16, 3))
    parts = SurfaceParts(zero, zero, np.tile(edges, (16, 1, 1)), whole=True)
    mean = part_samples(parts, coordinates).mean(axis=(0, 1))
    np.testing.assert_allclose(mean, [1.0, 0.5, 2.0], rtol=1e-3)


def test_a_line_divides_dense_samples_as_it_does_the_area() -> None:
    """Half planes through a triangle: of all 16 variants together, and of each of them."""
    random = np.random.default_rng(8)
    parts = _tributary_parts(np.tile(np.eye(3), (16, 1, 1)))
    zero = np.zeros((len(parts), 3))
    places = part_samples(SurfaceParts(zero, zero, parts), DENSE)
    for _ in range(50):
        low = random.uniform(0.05, 0.95)
        found = (places[:, :, 0] < low).mean(axis=1).reshape(16, 3).mean(axis=1)
        exact = 1.0 - (1.0 - low) ** 2
        assert np.abs(found - exact).max() < 0.02
        assert found.mean() == pytest.approx(exact, abs=2e-3)


def test_what_soil_ends_in_is_measured() -> None:
    """Soil from 0 to 1 opposite pieces of uneven lengths; beside small pieces the end of a large
    one has no neighbours beyond the soil."""
    ends = np.array([-0.3, 0.9, 0.95, 0.97, 0.99, 1.6])
    piece = np.stack([np.stack([ends[:-1], 0.0 * ends[1:]], axis=1),
                      np.stack([ends[1:], 0.0 * ends[1:]], axis=1)], axis=1)  # fmt: skip
    tributary = _tributary_parts(piece)
    share = 0.5 * (1.0 + np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)]))
    position = (piece[:, :1] + share[:, None] * (piece[:, 1:] - piece[:, :1])).reshape(-1, 2)
    tributary[:, 0] -= position

    def gap(place: np.ndarray, normal: np.ndarray, widening: float) -> tuple[np.ndarray, ...]:
        found = (place[:, 0] > -widening) & (place[:, 0] < 1.0 + widening)
        return np.where(found, 0.0, np.inf), np.where(found, 7, -1)

    normal = np.tile([0.0, 1.0], (len(position), 1))
    measured = measure(SurfaceParts(position, normal, tributary), gap)
    length = np.linalg.norm(tributary[:, 1], axis=1)
    assert measured.share @ length == pytest.approx(1.0, abs=3e-3)
    assert (measured.point[measured.share > 0.0] == 7).all()


def test_cracks_count_in_the_plane_but_not_what_is_beyond_the_soil() -> None:
    found = np.array([[0, 1, 0, 1, 0], [0, 0, 0, 0, 0], [1, 1, 0, 0, 0]], dtype=bool)
    np.testing.assert_array_equal(covered(found, 2).sum(axis=1), [3, 0, 2])
    np.testing.assert_array_equal(covered(found, 3), found)


def test_slivers_are_supports_and_not_points() -> None:
    owner = np.array([0, 0, 0, 1, 1])
    weight = SLIVER * 0.25 * np.array([0.5, 0.4, 0.2, 0.5, 0.4])
    found = is_sliver(owner, weight, np.full((len(owner), 2), 0.25))
    np.testing.assert_array_equal(found, [False, False, False, True, True])


@pytest.mark.parametrize("more", [0.0, 1e-15, -1e-15, 2e-3, -2e-3])
def test_hairs_of_soil_do_not_decide_which_supports_join(more: float) -> None:
    """Two small patches beside a large one: the same of both first, and to the same side."""
    owner = np.array([0, 0, 1, 2])
    position = np.array([[0.0, 0.0], [0.5 - 1e-7 * more, 0.0], [1.0, 0.0], [1.5, 0.0]])
    weight = np.array([0.5, 0.25, 0.25, 0.25 + more])
    joined = without_small(owner, position, np.full((4, 2), [0.0, 1.0]), weight, np.ones((4, 2)))
    np.testing.assert_array_equal(joined, [0, 0, 0, 0])


def test_what_turned_round_beyond_its_strength_is_told() -> None:
    one = np.ones(3)
    law = ContactLaw(2.0 * one, 0.0 * one, np.inf * one, 0.0 * one, np.ones(3, dtype=bool))
    trial = np.array([[-1.0, 3.0], [-1.0, 3.0], [-1.0, 1.0]])
    slip = np.array([[-1.0], [1.0], [-1.0]])
    response = respond(law, trial, np.ones((3, 2)), slip)
    np.testing.assert_array_equal(response.turned, [True, False, False])
    np.testing.assert_array_equal(response.sliding, [False, True, False])


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_no_equilibrium_is_accepted_beyond_the_strength(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where patches stick because they turned round, they slide from the revision on."""
    simulation = pressed(kind, "held adhesion", DRIVEN)
    simulation.advance(0.0, 0.25)
    balance, term = next_contact(simulation, 0.25, 0.5, monkeypatch)
    still = np.zeros((balance.active.nodes, dimension(kind)))
    unknowns = np.zeros_like(term.scale)
    term.forces(still, unknowns)
    for patch, _, each in term._each():
        patch.slip = -each.response.slip
    term.forces(still, unknowns)
    assert any(each.response.turned.any() for _, _, each in term._each())
    assert term.revise(balance.at(still))
    term.forces(still, unknowns)
    for patch, _, each in term._each():
        size = np.linalg.norm(each.response.traction[:, 1:], axis=1)
        strength, _ = patch.law.strength(-each.response.traction[:, 0])
        present = patch.area > 0.0
        assert (size[present] <= strength[present] * (1.0 + 1e-12)).all()


def test_a_surface_that_all_soil_has_left_remembers_that_it_touched() -> None:
    """Soil that comes back is in contact again if it overlaps, without a gap to be wished away."""
    simulation = pressed("plane_strain", "friction", DRIVEN)
    simulation.advance(0.0, 0.25)
    touched = [surface.carried[:, 2].copy() for surface in simulation.state.contact_surfaces]
    assert any((each == 1.0).any() for each in touched)
    for surface, before in zip(simulation.state.contact_surfaces, touched, strict=True):
        surface.leave()
        after = surface.carried[:, 2]
        np.testing.assert_array_equal(after, np.where(before == NEVER, NEVER, AWAY))
        assert not surface.carried[:, [0, 1, 3, 4, 5]].any()
