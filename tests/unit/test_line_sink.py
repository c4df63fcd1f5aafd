# SPDX-License-Identifier: BSD-3-Clause
"""The closed form of a line sink in a layer against the one of the half plane."""

import numpy as np
import pytest
from scipy.integrate import trapezoid

from tilth_verification.closed_forms.line_sink import LineSink

X = np.array([0.0, 3.0, 11.0, 24.0])


@pytest.mark.parametrize("rough", [True, False])
def test_in_a_deep_layer_it_is_the_half_plane_with_images_of_the_walls(rough):
    """V h / (pi (x^2 + h^2)) of Sagaseta, summed over the images at x + 2 n L, in closed form."""
    sink = LineSink(lost=0.7, depth=15.0, thickness=1500.0, width=40.0, rough_base=rough)
    h, x = np.pi * np.array([15.0, 0.0]) / 40.0, np.pi * X / 40.0
    exact = 0.7 / 80.0 * np.sinh(h[0]) / (np.cosh(h[0]) - np.cos(x))
    np.testing.assert_allclose(sink.settlement(X), exact, rtol=1e-12)
    images = X + 80.0 * np.arange(-20000, 20001)[:, None]
    summed = (0.7 * 15.0 / np.pi / (images**2 + 15.0**2)).sum(axis=0)
    np.testing.assert_allclose(exact, summed, rtol=1e-4)


@pytest.mark.parametrize("rough", [True, False])
@pytest.mark.parametrize("thickness", [17.0, 30.0])
def test_the_trough_has_the_lost_area(rough, thickness):
    sink = LineSink(lost=0.7, depth=15.0, thickness=thickness, width=40.0, rough_base=rough)
    x = np.linspace(-40.0, 40.0, 4001)
    assert trapezoid(sink.settlement(x), x) == pytest.approx(0.7, rel=1e-12)


@pytest.mark.parametrize("rough", [True, False])
def test_the_base_holds_and_the_surface_is_free(rough):
    """Stresses at the surface and displacements at the base, from the modes themselves."""
    sink = LineSink(lost=0.7, depth=15.0, thickness=30.0, width=40.0, rough_base=rough)
    k, factors = sink._modes()
    for y, at_base in ((0.0, True), (30.0, False)):
        f = np.einsum("dnf,nf->dn", sink._functions(k, y), factors)
        phi = sink._potential(k, y)
        along, up = f[1] - k * phi[0], -k * f[0] + phi[1]
        shear = f[2] + k**2 * f[0] - 2.0 * k * phi[1]
        normal = (f[3] - 3.0 * k**2 * f[1]) / k + 2.0 * phi[2]
        size = np.abs(phi[1]).max()
        vanish = [up, along if rough else shear] if at_base else [shear, normal]
        for value in vanish:
            assert np.abs(value).max() < 1e-11 * size * k.max()


def test_functions_are_derivatives_of_each_other():
    sink = LineSink(lost=0.7, depth=15.0, thickness=30.0, width=40.0)
    k = np.array([0.1, 0.7, 2.0])
    for y in (3.0, 26.0):
        ahead, behind = (sink._functions(k, y + s * 1e-5) for s in (1.0, -1.0))
        found = sink._functions(k, y)
        difference = (ahead - behind)[:3] / 2e-5
        np.testing.assert_allclose(found[1:], difference, rtol=1e-6, atol=1e-9)


def test_depth_of_the_sink_moves_as_its_image_moves_it():
    """In the half plane the images move the sink by V / (4 pi h) each: the limit of a wide layer.

    Of a sink -V at 2 h above (the mirror image) V / (2 pi 2 h); the tractions that it leaves on the
    surface move it by as much again.
    """
    sink = LineSink(lost=0.7, depth=1.0, thickness=400.0, width=400.0)
    assert sink.settlement_of_sink() == pytest.approx(0.7 / (2.0 * np.pi), rel=0.02)
