# SPDX-License-Identifier: BSD-3-Clause
"""Domains that tile keep a uniform stress balanced: inner nodes, left free, follow the outer ones.

The points cross cells on their way, so that every relation of domains and grid comes up.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mesh_bodies import DIMENSION, distorted_mesh
from scipy.linalg import expm
from small_problems import affine, block_entries

from tilth import Model
from tilth.analysis.march import march
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.boundaries.affine import outer_nodes
from tilth_verification.closed_forms import full_deformation_gradient, hencky_cauchy_stress
from tilth_verification.homogeneous import stress_error

CELLS = {"plane_strain": 8, "3d": 6}


def motion(kind: str) -> Floats:
    """Half a radian of turn with stretch and shear, about skew axes in 3D."""
    rate = np.array([[0.1, -0.6, 0.4], [0.5, 0.0, -0.6], [-0.3, 0.5, -0.15]])
    dim = 3 if kind == "3d" else 2
    return np.asarray(expm(rate[:dim, :dim]))


def error_with_free_nodes(kind: str, basis: str, shape: dict[str, Any] | None = None) -> float:
    """Largest relative stress error after a motion whose inner nodes were free in every step.

    shape: of the body, a square or cube of cells around the origin if not given.
    """
    cells, end = CELLS[kind], motion(kind)
    entries = block_entries(kind, basis, cells=cells, schedule={"steps": 4, "adaptive": False})
    entries["analysis"]["predictor"] = False
    middle = 0.5 * cells
    entries["bodies"][0]["shape"] = shape or {
        "type": "box",
        "lower": [-middle] * len(end),
        "upper": [middle] * len(end),
    }
    entries["boundaries"] = [affine(end, "exponential") | {"nodes": "outer"}]
    model = Model.from_dict(entries)
    free = []

    def after_step(simulation: object, result: StepResult, time: float) -> None:
        free.append(int((~outer_nodes(result.active)).sum()))

    points = march(model, after_step).state.points
    assert min(free) >= 1
    exact = hencky_cauchy_stress(full_deformation_gradient(end, kind), model.materials["soil"])
    return stress_error(points, exact)


@pytest.mark.parametrize("basis", ["cpdi1", "cpdi2"])
@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_domains_with_corners_stay_in_balance(kind: str, basis: str) -> None:
    assert error_with_free_nodes(kind, basis) < 1e-8


@pytest.mark.parametrize("basis", ["linear", "gimp"])
def test_the_motion_tells_domains_that_do_not_tile(basis: str) -> None:
    assert error_with_free_nodes("plane_strain", basis) > 1e-3


def error_of_a_mesh(folder: Path, element: str, basis: str) -> float:
    """The same for a distorted mesh of the square or cube, whose edges the grid's lines cut."""
    pytest.importorskip("meshio")
    kind = "3d" if DIMENSION[element] == 3 else "plane_strain"
    middle = 0.5 * CELLS[kind]
    file = distorted_mesh(folder / "body.msh", element, CELLS[kind] - 1, -middle, middle)
    return error_with_free_nodes(kind, basis, {"type": "mesh", "file": str(file)})


@pytest.mark.parametrize("element", list(DIMENSION))
def test_domains_of_distorted_meshes_stay_in_balance(tmp_path: Path, element: str) -> None:
    """Quadrilaterals and hexahedra whose corners neighbours share."""
    assert error_of_a_mesh(tmp_path, element, "cpdi2") < 1e-9


@pytest.mark.parametrize("basis", ["gimp", "cpdi1"])
@pytest.mark.parametrize("element", ["triangle", "quad"])
def test_boxes_and_parallelograms_of_distorted_meshes_do_not(
    tmp_path: Path, element: str, basis: str
) -> None:
    """They have the right volumes, but not the shapes of the pieces."""
    assert error_of_a_mesh(tmp_path, element, basis) > 1e-2
