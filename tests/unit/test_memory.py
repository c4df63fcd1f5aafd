# SPDX-License-Identifier: BSD-3-Clause
"""The memory that a run needs, the memory that there is, and the refusal of what does not fit."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tilth import BadInput, Model
from tilth.analysis.memory import memory_of, require_memory
from tilth.analysis.simulation import Simulation
from tilth.available_memory import available_memory, parse_size, size_text
from tilth.solvers.fill import factor_blocks
from tilth.solvers.protocol import Matrix
from tilth.solvers.superlu import SuperLU


def entries(kind: str = "3d", cells: float = 4, **body: Any) -> dict[str, Any]:
    """A body of unit size under its own weight, two points per cell and direction."""
    dim = 3 if kind == "3d" else 2
    axes = "xyz"[:dim]
    shape = {"type": "box", "lower": [0.0] * dim, "upper": [1.0] * dim}
    return {
        "analysis": {"kind": kind},
        "grid": {"cell_size": 1.0 / cells},
        "materials": {
            "soil": {"model": "hencky_elastic", "young_modulus": 1e6, "poisson_ratio": 0.2}
        },
        "bodies": [
            {"name": "soil", "material": "soil", "basis": "gimp", "points_per_cell": 2}
            | {"shape": shape}
            | body
        ],
        "boundaries": [
            {"type": "plane", "name": axis, "axis": axis, "at": 0, "condition": "fixed"}
            for axis in axes
        ],
        "schedule": {"steps": 1},
    }


SHAPES = {
    "box": {"type": "box", "lower": [0.0, 0.0, 0.0], "upper": [1.0, 0.5, 2.0]},
    "turned": {
        "type": "box", "lower": [0.5, 0.5, 0.5], "upper": [1.5, 1.0, 2.0], "angle": 20.0,
        "axis": "z",
    },
    "cylinder": {
        "type": "cylinder", "centre": [0.0, 0.0, 0.0], "radius": 1.0, "axis": "z", "height": 1.0,
        "inner_radius": 0.5, "sides": ["x+", "y+"],
    },
    "sphere": {"type": "sphere", "centre": [0.0, 0.0, 0.0], "radius": 1.0, "sides": ["x+", "z+"]},
}  # fmt: skip
SHAPES_2D: dict[str, dict[str, Any]] = {
    "polygon": {"type": "polygon", "vertices": [[0.0, 0.0], [3.0, 0.0], [1.0, 2.0], [0.0, 2.0]]},
    "circle": {"type": "circle", "centre": [2.0, 0.0], "radius": 1.0},
    "ball": {"type": "circle", "centre": [0.0, 0.0], "radius": 1.0},
}


@pytest.mark.parametrize("name", [*SHAPES, *SHAPES_2D])
def test_size_from_the_shape_is_that_of_the_points(name: str) -> None:
    kind = "axisymmetric" if name == "ball" else "plane_strain" if name in SHAPES_2D else "3d"
    shape = (SHAPES | SHAPES_2D)[name]
    model = Model.from_dict(entries(kind, 16 if kind != "3d" else 12, shape=shape))
    simulation = Simulation(model)
    declared = memory_of(model)
    active = simulation.prepare(0.0, 1.0).active
    found = memory_of(model, simulation.state.points, active)
    # only the surface is not resolved: a layer of half a cell of it, relative to the volume
    assert declared.points == pytest.approx(found.points, rel=0.06)
    assert declared.cells == pytest.approx(found.cells, rel=0.2)
    assert declared.unknowns == pytest.approx(found.unknowns, rel=0.2)
    assert declared.total == pytest.approx(found.total, rel=0.15)


def test_fill_grows_as_nested_dissection() -> None:
    side = 1000  # n log n in 2D, n^(4/3) in 3D (George 1973)
    in_plane, in_space = (
        factor_blocks([2 * side] * dim, 1) / factor_blocks([side] * dim, 1) for dim in (2, 3)
    )
    assert in_plane == pytest.approx(4.0 * np.log2(4 * side**2) / np.log2(side**2), rel=0.03)
    assert in_space == pytest.approx(2.0**4, rel=0.03)


def test_fill_of_a_slender_body_is_proportional_to_its_length() -> None:
    short, long = 2**3 * 51 - 1, 2**6 * 51 - 1  # separators, one node thick, give the same leaves
    ratio = factor_blocks([4, 4, long], 1) / factor_blocks([4, 4, short], 1)
    assert ratio == pytest.approx(long / short, rel=0.03)


@pytest.mark.parametrize(("kind", "dim", "cells"), [("plane_strain", 2, 40), ("3d", 3, 9)])
def test_fill_is_that_of_superlu(
    kind: str, dim: int, cells: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []
    setup = SuperLU.setup

    def counted(solver: SuperLU, matrix: Matrix, near_null_space: Any = None) -> None:
        setup(solver, matrix)
        found.append(solver._factors.nnz)

    monkeypatch.setattr(SuperLU, "setup", counted)
    declared = entries(kind, cells, basis="linear")
    declared["analysis"]["solver"] = "superlu"
    declared["materials"]["soil"]["density"] = 1.0
    declared["loads"] = [{"type": "body_force", "acceleration": [1.0] * dim}]
    Simulation(Model.from_dict(declared)).advance(0.0, 1.0)
    # L and U of dim x dim blocks; the nodes of the fixed sides are not among the unknowns
    assert 2 * dim**2 * factor_blocks([cells] * dim, 1) == pytest.approx(found[0], rel=0.15)


def test_a_thousand_million_points_are_refused_at_once() -> None:
    model = Model.from_dict(entries("3d", 490))  # 941 million points
    start = time.perf_counter()
    with pytest.raises(BadInput, match=r"needs about \d.* TB.*points.*unknowns.*(memory|limit)"):
        require_memory(memory_of(model))
    assert time.perf_counter() - start < 2.0


def test_limit_given_replaces_what_is_available() -> None:
    large, small = (memory_of(Model.from_dict(entries("3d", n))) for n in (490, 4))
    require_memory(large, "5000TB")
    with pytest.raises(BadInput, match="the memory limit given is 10 MB"):
        require_memory(small, 10_000_000)
    with pytest.raises(BadInput, match="is not a size of memory") as caught:
        require_memory(small, "much")
    assert caught.value.key == "memory_limit"


def test_sizes_are_read_and_written() -> None:
    read = {"64GB": 64e9, "500MiB": 500 * 2**20, "1.5 g": 1.5e9, "2TiB": 2**41, "1000": 1000.0}
    assert {text: parse_size(text) for text in read} == read
    assert [size_text(size) for size in (5e7, 3.21e9, 4e12)] == ["50 MB", "3.21 GB", "4 TB"]
    for text in ("", "GB", "-1GB", "0", "3 apples", "1.2.3"):
        with pytest.raises(BadInput):
            parse_size(text)


def write(root: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    return root


MACHINE = {
    "proc/meminfo": "MemTotal: 16000000 kB\nMemFree: 1 kB\nMemAvailable: 8000000 kB\n",
    "proc/self/status": "VmSize:\t200000 kB\nVmRSS:\t100000 kB\nVmData:\t120000 kB\n",
}


def test_memory_of_the_machine(tmp_path: Path) -> None:
    found = available_memory(write(tmp_path, MACHINE))
    assert found is not None
    assert found.source == "memory of the machine"
    assert (found.available, found.total) == (8100000 * 1024, 16000000 * 1024)


def test_limit_of_a_control_group_of_version_2(tmp_path: Path) -> None:
    group = "sys/fs/cgroup/slice/job"
    found = available_memory(
        write(
            tmp_path,
            MACHINE
            | {
                "proc/self/cgroup": "0::/slice/job\n",
                f"{group}/memory.max": "max\n",
                f"{group}/memory.current": "1000000\n",
                "sys/fs/cgroup/slice/memory.max": "1000000000\n",
                "sys/fs/cgroup/slice/memory.current": "400000000\n",
                "sys/fs/cgroup/slice/memory.stat": "anon 3\ninactive_file 100000000\n",
            },
        )
    )
    assert found is not None
    assert "control group" in str(found)
    # limit less what is in use and cannot be released, and the process's own part of that
    assert found.available == 1e9 - (4e8 - 1e8) + 100000 * 1024
    assert found.total == 1e9


def test_limit_of_a_container_with_control_groups_of_version_1(tmp_path: Path) -> None:
    own = "sys/fs/cgroup/memory"  # the path outside is not visible in the container
    found = available_memory(
        write(
            tmp_path,
            MACHINE
            | {
                "proc/self/cgroup": "5:cpu,cpuacct:/a\n4:memory:/docker/0123\n0::/\n",
                f"{own}/memory.limit_in_bytes": "2000000000\n",
                f"{own}/memory.usage_in_bytes": "500000000\n",
                f"{own}/memory.stat": "cache 7\ntotal_inactive_file 0\n",
            },
        )
    )
    assert found is not None
    assert found.available == 1.5e9 + 100000 * 1024


def test_no_limit_of_a_control_group(tmp_path: Path) -> None:
    files = {
        "proc/self/cgroup": "4:memory:/\n",
        "sys/fs/cgroup/memory/memory.limit_in_bytes": "9223372036854771712\n",
        "sys/fs/cgroup/memory/memory.usage_in_bytes": "500000000\n",
    }
    found = available_memory(write(tmp_path, MACHINE | files))
    assert found is not None
    assert found.source == "memory of the machine"
