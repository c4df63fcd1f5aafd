# SPDX-License-Identifier: BSD-3-Clause
"""The same bits for any number of threads, and from one run to the next."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from small_problems import (
    BASES,
    CORNER_BASES,
    Laboratory,
    assert_same_bits,
    block_entries,
    material_entries,
    plane,
    rollers,
    weight,
)

from tilth import BadInput, Model, _core
from tilth.analysis.simulation import Simulation
from tilth.environment import set_environment
from tilth.model.fields import count_of

pytestmark = pytest.mark.usefixtures("every_loop_in_parallel")


CELLS = {"plane_strain": 12, "axisymmetric": 12, "3d": 5}


def entries_of(kind: str, basis: str, material: str) -> dict[str, Any]:
    """A block of many cells that is squeezed until points have crossed cells."""
    cells = CELLS[kind]
    entries = block_entries(
        kind, basis, material, cells=1, loads=[weight(kind, 2.0)],
        boundaries=[*rollers(kind, sides=False), plane(
            "top", "z" if kind == "3d" else "y", 1.0, condition="prescribed",
            displacement={"z" if kind == "3d" else "y": -0.25},
        )],
    )  # fmt: skip
    entries["grid"]["cell_size"] = 1.0 / cells
    entries["materials"]["soil"] = material_entries(
        material, **({"yield_stress": 25.0} if material == "von_mises" else {})
    )
    entries["analysis"]["tolerance"] = 1e-6
    return entries


def final_state(
    threads: int, entries: dict[str, Any], steps: int
) -> tuple[Simulation, list[np.ndarray]]:
    _core.set_threads(threads)
    assert _core.threads() == threads
    simulation = Simulation(Model.from_dict(entries))
    solutions = []
    for k in range(steps):
        result = simulation.advance(0.05 * k, 0.05 * (k + 1))
        solutions += [result.equilibrium.displacement, result.equilibrium.reaction]
    return simulation, solutions


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "basis", "material", "steps"),
    [
        ("plane_strain", "gimp", "von_mises", 5),
        ("axisymmetric", "gimp", "von_mises", 3),
        ("3d", "linear", "hencky_elastic", 2),
        ("3d", "gimp", "von_mises", 3),
        *((kind, basis, "von_mises", 2) for kind in CELLS for basis in CORNER_BASES),
    ],
)
def test_same_bits_for_any_number_of_threads(
    kind: str, basis: str, material: str, steps: int
) -> None:
    entries = entries_of(kind, basis, material)
    one, solution = final_state(1, entries, steps)
    for threads in (1, 2, 3):
        other, again = final_state(threads, entries, steps)
        assert_same_bits(one.state.points, other.state.points)
        for first, second in zip(solution, again, strict=True):
            assert first.tobytes() == second.tobytes()
    if material == "von_mises":
        assert one.state.points.plastic[:, 0].max() > 1e-3
    if kind == "plane_strain":  # points have changed cells: they were sorted anew on the way
        assert not np.array_equal(one.state.points.point_id, np.sort(one.state.points.point_id))


@pytest.mark.parametrize("kind", CELLS)
@pytest.mark.parametrize("basis", BASES)
def test_kernels_give_the_same_bits(kind: str, basis: str) -> None:
    """Force, stiffness and scatter of irregular points, many groups to a node."""
    results = []
    for threads in (1, 2, 4):
        _core.set_threads(threads)
        random = np.random.default_rng(0)
        laboratory = Laboratory.of(kind, basis, "von_mises", random, cells=CELLS[kind])
        u = laboratory.random_displacement(random, 0.05)
        force = laboratory.internal_force(u)
        matrix = laboratory.stiffness(u)
        nodal = laboratory.soil.scatter(laboratory.points.position)
        results.append((force.tobytes(), matrix.data.tobytes(), nodal.tobytes()))
    assert results[0] == results[1] == results[2]


@pytest.mark.parametrize(
    ("given", "policy", "spins", "layer"),
    [
        ({}, "passive", "10000", "GNU"),
        ({"GOMP_SPINCOUNT": "7"}, "passive", "7", "GNU"),
        ({"OMP_WAIT_POLICY": "active"}, "active", None, "GNU"),
        ({"MKL_THREADING_LAYER": "TBB"}, "passive", "10000", "TBB"),
    ],
)
def test_the_command_says_how_threads_wait(
    given: dict[str, str], policy: str, spins: str | None, layer: str
) -> None:
    """What the user has set stays as it is."""
    environment = dict(given)
    set_environment(environment)
    assert environment.pop("OMP_WAIT_POLICY") == policy
    assert environment.pop("GOMP_SPINCOUNT", None) == spins
    assert environment.pop("MKL_THREADING_LAYER") == layer
    assert environment == {}


@pytest.mark.slow
def test_the_command_sets_it_before_the_core_is_loaded() -> None:
    """GNU's OpenMP reads it then; `import tilth`, of all modules, leaves the process alone."""
    ask = """
import os, pkgutil, sys
import tilth, tilth.cli
assert "tilth._core" not in sys.modules, "too late"
before = dict(os.environ)
for module in pkgutil.walk_packages(tilth.__path__, "tilth."):
    if not module.name.endswith(("__main__", "_abaqus")):  # a library that is no module
        __import__(module.name)
assert dict(os.environ) == before
"""
    subprocess.run([sys.executable, "-c", ask], check=True)


@pytest.mark.parametrize("wrong", [0, -1, 2.5, "2", True])
def test_a_wrong_number_of_threads(wrong: Any) -> None:
    with pytest.raises(BadInput, match=r"threads = .*: must be (at least 1|a whole number)\n"):
        count_of("threads", wrong, 4)


def test_no_number_of_threads_is_the_default() -> None:
    assert (count_of("threads", None, 4), count_of("threads", np.int64(3), 4)) == (4, 3)
