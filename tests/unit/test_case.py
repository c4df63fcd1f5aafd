# SPDX-License-Identifier: BSD-3-Clause
"""Case files: the same model as from Python, and mesh paths relative to the file."""

from pathlib import Path

from tilth.case import load_case
from tilth.model import (
    Analysis,
    Body,
    Box,
    Grid,
    HenckyElastic,
    Model,
    PlaneBoundary,
    Schedule,
)

CASE = """
format = 1
analysis.kind = "3d"
grid.cell_size = [1, 1, 0.5]
materials.soil = { model = "hencky_elastic", young_modulus = 1e6, poisson_ratio = 0.3 }
schedule.steps = 1

[[bodies]]
name = "block"
material = "soil"
shape = { type = "box", lower = [0, 0, 0], upper = [1, 1, 1] }
basis = "linear"
points_per_cell = [2, 2, 1]

[[boundaries]]
name = "base"
type = "plane"
axis = "z"
at = 0.0
condition = "prescribed"
displacement = { x = 0.1, y = 0, z = 0 }
"""


def test_a_case_file_and_python_build_the_same_model(tmp_path: Path) -> None:
    file = tmp_path / "block.toml"
    file.write_text(CASE, encoding="utf-8")
    assert load_case(file) == Model(
        analysis=Analysis(kind="3d"),
        grid=Grid(cell_size=[1, 1, 0.5]),
        materials={"soil": HenckyElastic(young_modulus=1e6, poisson_ratio=0.3)},
        bodies=[
            Body(
                name="block",
                material="soil",
                shape=Box(lower=[0, 0, 0], upper=[1, 1, 1]),
                basis="linear",
                points_per_cell=[2, 2, 1],
            )
        ],
        boundaries=[
            PlaneBoundary(
                name="base",
                axis="z",
                at=0,
                condition="prescribed",
                displacement={"x": 0.1, "y": 0, "z": 0},
            )
        ],
        schedule=Schedule(steps=1),
    )


def test_a_mesh_lies_relative_to_its_case_file(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    mesh = tmp_path / "meshes" / "block.msh"
    mesh.touch()
    file = tmp_path / "block.toml"
    box = 'type = "box", lower = [0, 0, 0], upper = [1, 1, 1]'
    text = CASE.replace(box, 'type = "mesh", file = "meshes/block.msh"')
    file.write_text(text, encoding="utf-8")
    assert Path(load_case(file).bodies[0].shape.file) == mesh.resolve()


IMPLICIT = """
[[boundaries]]
name = "wall"
type = "implicit"
geometry = { type = "GEOMETRY" }
condition = "fixed"
motion = "motions/lift.py:lift"
"""


def test_files_of_a_boundary_lie_relative_to_its_case_file(tmp_path: Path) -> None:
    (tmp_path / "motions").mkdir()
    for name in ("motions/lift.py", "blade.stl", "shape.py"):
        (tmp_path / name).touch()
    file = tmp_path / "block.toml"
    for geometry, key, given in (
        ('stl", soil = "outside", file = "blade.stl', "file", "blade.stl"),
        ('function", function = "shape.py:distance', "function", "shape.py:distance"),
    ):
        file.write_text(CASE + IMPLICIT.replace("GEOMETRY", geometry), encoding="utf-8")
        wall = load_case(file).boundaries[1]
        assert wall.motion == f"{(tmp_path / 'motions' / 'lift.py').resolve()}:lift"
        assert getattr(wall.geometry, key) == f"{tmp_path.resolve()}/{given}"
