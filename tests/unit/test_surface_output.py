# SPDX-License-Identifier: BSD-3-Clause
"""Tracked surfaces in results.vtkhdf: blocks of their own, which VTK reads, and nothing else."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from result_snapshots import UNITS, assert_same, make_snapshot, opened_by_vtk, write
from tracked_shapes import circle, octahedron

from tilth.output import ResultsWriter, SurfaceShape, read_results
from tilth.output.vtkhdf_layout import block_names

BLOCKS = ["points", "grid", "surface_cavity", "surface_top___side"]


def contents(path: Path) -> dict[str, Any]:
    """Every group, data set and attribute of a file."""
    found: dict[str, Any] = {}

    def take(name: str, item: Any) -> None:
        values = item[()].tobytes() if isinstance(item, h5py.Dataset) else b""
        found[name] = (values, {key: np.asarray(v).tolist() for key, v in item.attrs.items()})

    with h5py.File(path) as file:
        file.visititems(take)
    return found


@pytest.mark.parametrize("dim", [2, 3])
def test_surfaces_add_blocks_and_change_nothing_else(tmp_path: Path, dim: int) -> None:
    plain, more = tmp_path / "plain.vtkhdf", tmp_path / "more.vtkhdf"
    write(plain, range(4), dim).close()
    write(more, range(4), dim, surfaces=True).close()
    without, given = contents(plain), contents(more)
    assert not [name for name in without if "surface" in name]
    assert without["tilth"][1].keys() == {"dim", "title", "units"}
    given["tilth"][1].pop("surfaces")
    assert without.pop("tilth/checksum") != given.pop("tilth/checksum")  # of all blocks
    assert without == {name: value for name, value in given.items() if "/surface_" not in name}


def cells_of(part: Any) -> int:
    """Number of cells of a partition; VTK 9.5 and 9.6 say -1 for an empty one, others give None."""
    return 0 if part is None else max(part.GetNumberOfCells(), 0)


@pytest.mark.parametrize("information_first", [True, False])
@pytest.mark.parametrize("dim", [2, 3])
def test_vtk_reads_every_step_of_surfaces(
    tmp_path: Path, dim: int, information_first: bool, capfd: pytest.CaptureFixture[str]
) -> None:
    """Points and grid are those of a file without surfaces, see above."""
    support = pytest.importorskip("vtkmodules.util.numpy_support")
    path = tmp_path / "results.vtkhdf"
    write(path, range(5), dim, surfaces=True).close()
    reader = opened_by_vtk(path, information_first)
    for step in (3, 0, 4, 1, 2):
        expected = make_snapshot(step, dim, surfaces=True)
        reader.UpdateTimeStep(0.1 * step)
        output = reader.GetOutputDataObject(0)
        assembly = output.GetDataAssembly()
        nodes = assembly.GetChildNodes(0, False)
        assert [assembly.GetNodeName(node) for node in nodes] == BLOCKS
        sets = [list(assembly.GetDataSetIndices(node)) for node in nodes]
        assert sets == [[0], [1], [2], [3]]
        for number, shape in enumerate(expected.surfaces, start=2):
            block = output.GetPartition(number, 0)
            assert cells_of(block) == len(shape.cells)
            if len(shape.cells) == 0:
                continue
            assert block.GetNumberOfPoints() == len(shape.position)
            place = support.vtk_to_numpy(block.GetPoints().GetData())
            np.testing.assert_array_equal(place[:, :dim], shape.position)
            np.testing.assert_array_equal(place[:, dim:], 0.0)
            for i, cell in enumerate(shape.cells):
                assert block.GetCellType(i) == (3 if dim == 2 else 5)
                ids = block.GetCell(i).GetPointIds()
                assert [ids.GetId(k) for k in range(ids.GetNumberOfIds())] == list(cell)
            data = block.GetPointData()
            assert data.GetNumberOfArrays() == len(shape.fields)
            normal = support.vtk_to_numpy(data.GetArray("normal"))
            assert normal.shape[1] == 3
            np.testing.assert_array_equal(normal[:, :dim], shape.fields["normal"])
            if dim == 2:
                arc_length = support.vtk_to_numpy(data.GetArray("arc_length"))
                np.testing.assert_array_equal(arc_length, shape.fields["arc_length"])
    assert capfd.readouterr() == ("", "")  # VTK complains on stderr only


def test_vtk_allows_the_names_of_the_blocks() -> None:
    data_model = pytest.importorskip("vtkmodules.vtkCommonDataModel")
    names = ["slope", "Böschung 1", "a/b", "a.b", "a_b_2", "", "a b", "2"]
    blocks = block_names("surface_", names)
    assert list(blocks) == names
    assert blocks["slope"] == "surface_slope"
    assert len(set(blocks.values())) == len(names)
    for block in blocks.values():
        assert data_model.vtkDataAssembly.IsNodeNameValid(block)


def test_names_of_surfaces_differ_and_stay(tmp_path: Path) -> None:
    shapes = (circle("a", 4), circle("b", 4))
    path = tmp_path / "results.vtkhdf"
    twice = replace(make_snapshot(0), surfaces=(circle("a", 4), circle("a", 8)))
    with pytest.raises(ValueError, match="same name"):
        ResultsWriter(tmp_path / "twice.vtkhdf", units=UNITS).append(twice)
    writer = ResultsWriter(path, units=UNITS)
    writer.append(replace(make_snapshot(0), surfaces=shapes))
    for wrong in ((), shapes[:1], shapes[::-1], (*shapes, circle("c", 4))):
        with pytest.raises(ValueError, match="surfaces"):
            writer.append(replace(make_snapshot(1), surfaces=wrong))
    bare = SurfaceShape("b", shapes[1].position, shapes[1].cells, {})
    with pytest.raises(ValueError, match="fields"):
        writer.append(replace(make_snapshot(1), surfaces=(shapes[0], bare)))
    writer.append(replace(make_snapshot(1), surfaces=shapes))
    assert read_results(path).steps == [0, 1]
    assert_same(read_results(path).snapshot(1), replace(make_snapshot(1), surfaces=shapes))


def test_polylines_follow_the_chains() -> None:
    ring = circle("ring", 4)
    (line,) = ring.polylines
    assert line.tolist() == [0, 1, 2, 3, 0]
    cells = np.array([[5, 6], [6, 7], [0, 1], [1, 2], [2, 0]])
    both = SurfaceShape("both", np.zeros((8, 2)), cells, {})
    assert [line.tolist() for line in both.polylines] == [[5, 6, 7], [0, 1, 2, 0]]
    none = SurfaceShape("none", np.zeros((0, 2)), np.zeros((0, 2), dtype=np.int64), {})
    assert none.polylines == []


def test_triangles_have_their_normals_into_the_soil() -> None:
    shape = octahedron("ball", 1)
    corner = shape.position[shape.cells]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    assert np.all(np.einsum("ij,ij->i", normal, corner.mean(axis=1)) < 0.0)
