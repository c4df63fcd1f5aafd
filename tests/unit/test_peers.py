# SPDX-License-Identifier: BSD-3-Clause
"""Input that benchmarks/peers writes for Kratos MPM: the same grid, points and conditions."""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth_verification.cases import varied

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture
def peers(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("peers.kratos_input")


@pytest.fixture
def problems(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("problems")


def sections(text: str) -> dict[str, list[list[str]]]:
    """Rows of each innermost block of an mdpa file by the words after `Begin`."""
    found: dict[str, list[list[str]]] = {}
    open_blocks: list[str] = []
    part = ""
    for line in text.splitlines():
        words = line.split()
        if words[0] == "Begin":
            open_blocks.append(words[1])
            if words[1] == "SubModelPart":
                part = words[2]
            name = f"{part}/{words[1]}" if len(open_blocks) > 1 else words[1]
            found[name] = []
        elif words[0] == "End":
            assert open_blocks.pop() == words[1]
        else:
            found[name].append(words)
    assert not open_blocks
    return found


def read(folder: Path, name: str) -> tuple[np.ndarray, np.ndarray, dict[str, list[list[str]]]]:
    """Positions of the nodes, nodes of the elements from 0, and all blocks of a file."""
    blocks = sections((folder / name).read_text())
    nodes = np.array(blocks["Nodes"], dtype=float)
    elements = np.array(blocks["Elements"], dtype=int)
    for table in (nodes, elements):
        np.testing.assert_array_equal(table[:, 0], np.arange(1, len(table) + 1))
    return nodes[:, 1:], elements[:, 2:] - 1, blocks


def volumes(position: np.ndarray, element: np.ndarray) -> np.ndarray:
    """Signed volume of each element: the Jacobian at its centre, which is constant in boxes.

    The signs of the corners are those of the order that Kratos documents, counter-clockwise and
    the lower face first.
    """
    around = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    if element.shape[1] == 4:
        jacobian = np.einsum("ka,eki->eai", around / 4, position[element][:, :, :2])
        return 4 * np.linalg.det(jacobian)
    corners = np.array([[*c, z] for z in (-1, 1) for c in around])
    return 8 * np.linalg.det(np.einsum("ka,eki->eai", corners / 8, position[element]))


def cases(problems: Any, name: str) -> tuple[Model, list[float], list[float]]:
    if name == "cantilever":
        return problems.cantilever("linear"), [0.0, -8.5], [10.25, 1.25]
    return problems.block(5), [0.0] * 3, [5.0] * 3


@pytest.mark.parametrize("name", ["cantilever", "block"])
def test_points_and_grid_are_those_of_tilth(
    peers: Any, problems: Any, name: str, tmp_path: Path
) -> None:
    model, lower, upper = cases(problems, name)
    peers.write(model, tmp_path, lower, upper, "amgcl")
    dim = model.dimension
    simulation = Simulation(model)
    points = simulation.state.points

    position, element, _ = read(tmp_path, "body.mdpa")
    centre = position[element].mean(axis=1)[:, :dim]
    ours, theirs = (p[np.lexsort(np.round(p, 9).T)] for p in (points.position, centre))
    np.testing.assert_allclose(theirs, ours, atol=1e-12)
    np.testing.assert_allclose(volumes(position, element), points.initial_volume[0], rtol=1e-9)

    position, element, _ = read(tmp_path, "grid.mdpa")
    cell = np.prod(np.asarray(model.cell_size))
    np.testing.assert_allclose(volumes(position, element), cell, rtol=1e-9)
    assert np.prod(np.subtract(upper, lower)) == pytest.approx(cell * len(element))
    active = simulation.check().position
    there = {tuple(place) for place in np.round(position[:, :dim], 9) + 0.0}
    assert {tuple(place) for place in np.round(active, 9) + 0.0} <= there


def test_conditions_of_the_block(peers: Any, problems: Any, tmp_path: Path) -> None:
    """Rollers on three faces and a plate of 1 m, which moves by half of 0.2 mm in each step."""
    model, lower, upper = cases(problems, "block")
    peers.write(model, tmp_path, lower, upper, "sparse_lu")
    position, _, blocks = read(tmp_path, "grid.mdpa")

    def places(part: str) -> np.ndarray:
        numbers = np.array(blocks[f"{part}/SubModelPartNodes"], dtype=int).ravel()
        return position[numbers - 1]

    for axis, part in enumerate(("held_x", "held_y", "held_z")):
        assert len(places(part)) == 36
        assert np.all(places(part)[:, axis] == 0.0)
    expected = [[x, y, 5.0] for y in (0.0, 1.0) for x in (0.0, 1.0)]
    np.testing.assert_allclose(places("held_plate"), expected, atol=1e-12)

    parameters = json.loads((tmp_path / "parameters.json").read_text())
    processes = parameters["processes"]["constraints_process_list"]
    plate = processes[3]["Parameters"]
    assert plate["model_part_name"] == "Background_Grid.held_plate"
    assert plate["constrained"] == [False, False, True]
    assert plate["value"] == [None, None, pytest.approx(-1e-4)]
    problem = parameters["problem_data"]
    step = parameters["solver_settings"]["time_stepping"]["time_step"]
    assert np.ceil(problem["end_time"] / step) == model.schedule.steps
    answer = json.loads((tmp_path / "task.json").read_text())["answer"]
    assert answer == {"quantity": "reaction", "component": "z", "scale": -1.0, "part": "held_plate"}


def test_force_and_answer_of_the_cantilever(peers: Any, problems: Any, tmp_path: Path) -> None:
    """The two points nearest to the end of the axis, a 48th of a metre from both."""
    model, lower, upper = cases(problems, "cantilever")
    peers.write(model, tmp_path, lower, upper, "sparse_lu")
    task = json.loads((tmp_path / "task.json").read_text())
    half = 0.25 / 6 / 2
    nearest = [[10 - half, 0.5 - half], [10 - half, 0.5 + half]]
    np.testing.assert_allclose(sorted(task["forces"][0]["places"]), nearest, atol=1e-12)
    assert task["forces"][0]["force"] == [0.0, -1e5]
    assert task["answer"]["places"] == task["forces"][0]["places"]
    soil = json.loads((tmp_path / "materials.json").read_text())["properties"][0]["Material"]
    assert soil["Variables"]["YOUNG_MODULUS"] == 12e6
    assert soil["Variables"]["POISSON_RATIO"] == 0.2


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"bodies.0.basis": "gimp"}, "linear basis"),
        ({"bodies.0.anti_locking": "f_bar"}, "no F-bar"),
        ({"bodies.0.shape.angle": 30.0}, "along the axes"),
        ({"track": None}, "tracked quantity"),
    ],
)
def test_other_models_are_refused(
    peers: Any, problems: Any, changes: dict[str, Any], what: str, tmp_path: Path
) -> None:
    model, lower, upper = cases(problems, "cantilever")
    with pytest.raises(peers.NotTranslated, match=what):
        peers.write(varied(model, changes), tmp_path, lower, upper, "amgcl")


def test_kratos_that_cannot_be_had(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """One message with what failed, and no traceback of pip's."""
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    environment = importlib.import_module("peers.environment")
    nowhere = str(tmp_path / "no_python")
    with pytest.raises(environment.NoPeer, match="no virtual environment can be made"):
        environment.kratos_environment(tmp_path / "kratos", None, nowhere)
