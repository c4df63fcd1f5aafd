# SPDX-License-Identifier: BSD-3-Clause
"""Element tests of soils: a law's own pore fluid, starting stresses, softening, large strains."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tilth import BadInput, ElementCase, element
from tilth.element_tests.result import ElementResult

SAND = {
    "model": "mohr_coulomb",
    "young_modulus": 2e4,
    "poisson_ratio": 0.3,
    "cohesion": 10.0,
    "friction_angle": 30.0,
    "dilation_angle": 0.0,
}
CLAY = {
    "model": "modified_cam_clay",
    "compression_index": 0.1,
    "swelling_index": 0.02,
    "critical_state_slope": 1.0,
    "shear_modulus": 3000.0,
    "overconsolidation_ratio": 1.2,
}
FLUID = {"pore_fluid_bulk_modulus": 2e6}
TRIAXIAL = {
    "type": "triaxial", "drainage": "undrained", "direction": "compression", "axial_strain": 0.1,
}  # fmt: skip


def made(material: dict[str, Any], **test: Any) -> ElementResult:
    common = {"name": "test", "material": "soil", "start": {"isotropic": 100.0}, "steps": 40}
    entries = {"materials": {"soil": material}, "tests": [{**common, **TRIAXIAL, **test}]}
    (result,) = element(ElementCase.from_dict(entries))
    return result


@pytest.mark.parametrize("material", [SAND, CLAY], ids=lambda entries: entries["model"])
@pytest.mark.parametrize("direction", ["compression", "extension"])
def test_a_stiff_pore_fluid_holds_the_volume(material: dict[str, Any], direction: str) -> None:
    """Total lateral stress remains; effective stress and pore pressure are those without fluid."""
    held = made(material, direction=direction)
    fluid = made({**material, **FLUID}, direction=direction)
    total = fluid["stress_xx"] + fluid["excess_pore_pressure"]
    np.testing.assert_allclose(total, 100.0, rtol=1e-9)
    assert np.abs(fluid["volumetric_strain"]).max() < 1e-4
    for column in ("p", "q", "excess_pore_pressure"):
        np.testing.assert_allclose(fluid[column], held[column], rtol=0, atol=0.02 * 100.0)
    assert np.abs(held["excess_pore_pressure"]).max() > 10.0
    assert "elastic_volumetric_strain" in fluid.columns


def test_simple_shear_of_a_pore_fluid_keeps_the_total_vertical_stress() -> None:
    shear = {"type": "simple_shear", "shear_strain": 0.2, "direction": None, "axial_strain": None}
    test = {key: value for key, value in {**TRIAXIAL, **shear}.items() if value is not None}
    common = {"name": "test", "material": "soil", "start": {"isotropic": 100.0}, "steps": 40}
    entries = {"materials": {"soil": {**CLAY, **FLUID}}, "tests": [{**common, **test}]}
    (result,) = element(ElementCase.from_dict(entries))
    total = result["stress_yy"] + result["excess_pore_pressure"]
    np.testing.assert_allclose(total, 100.0, rtol=1e-9)
    assert result["excess_pore_pressure"][-1] > 5.0


def test_a_pore_fluid_is_not_drained() -> None:
    for key, value in (("drainage", "drained"), ("consolidation", {"isotropic": 200.0})):
        with pytest.raises(BadInput, match="cannot leave") as error:
            made({**SAND, **FLUID}, **{key: value})
        assert error.value.key == f"tests[0].{key}"


def test_cam_clay_has_no_state_without_stress() -> None:
    with pytest.raises(BadInput, match="no state with this stress") as error:
        made(CLAY, start={"isotropic": 0.0})
    assert error.value.key == "tests[0].start"


def test_a_start_outside_the_yield_surface_is_refused() -> None:
    with pytest.raises(BadInput) as error:
        made(SAND, start={"vertical": 1000.0, "K0": 0.1})
    assert error.value.key == "tests[0].start"


def test_softening_of_a_point_has_the_strain_that_is_declared() -> None:
    """The strain of a band of the declared width: whatever this width is."""
    softening = {"residual_cohesion": 2.0, "softening_strain": 0.05}
    ends = [
        made({**SAND, **softening, "softening_length": width}, drainage="drained")["q"]
        for width in (0.01, 3.0)
    ]
    np.testing.assert_allclose(ends[0], ends[1], rtol=1e-10)
    assert ends[0][-1] < 0.95 * ends[0].max()


def test_a_parameter_that_varies_is_refused() -> None:
    by_depth = {"depth": [[0.0, 5e3], [10.0, 2e4]], "surface": 0.0}
    with pytest.raises(BadInput) as error:
        made({**SAND, "young_modulus": by_depth})
    assert error.value.key == "materials.soil.young_modulus"
