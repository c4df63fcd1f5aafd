# SPDX-License-Identifier: BSD-3-Clause
"""Tracked surfaces in results.vtkhdf: what is written is read back, by us and by VTK."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from test_results_file import UNITS, assert_same, make_snapshot
from tracked_shapes import circle, octahedron, with_surfaces

from tilth.output import ResultsWriter, Snapshot, SurfaceShape, read_results
from tilth.output.vtkhdf_layout import surface_blocks

BLOCKS = ["points", "grid", "surface_cavity", "surface_top___side"]


def make(step: int, dim: int) -> Snapshot:
    return with_surfaces(make_snapshot(step, dim))


def write(path: Path, steps: range, dim: int) -> ResultsWriter:
    writer = ResultsWriter(path, title="a case", units=UNITS)
    for step in steps:
        writer.append(make(step, dim))
    return writer


def assert_same_surfaces(a: Snapshot, b: Snapshot) -> None:
    assert [s.name for s in a.surfaces] == [s.name for s in b.surfaces]
    for x, y in zip(a.surfaces, b.surfaces, strict=True):
        np.testing.assert_array_equal(x.position, y.position, strict=True)
        np.testing.assert_array_equal(x.cells, y.cells, strict=True)
        assert x.fields.keys() == y.fields.keys()
        for name in x.fields:
            np.testing.assert_array_equal(x.fields[name], y.fields[name], strict=True)


@pytest.mark.parametrize("dim", [2, 3])
def test_surfaces_come_back_bit_for_bit(tmp_path: Path, dim: int) -> None:
    path = tmp_path / "results.vtkhdf"
    write(path, range(6), dim).close()
    results = read_results(path)
    assert results.surfaces == ("cavity", "top & side")
    for step, snapshot in enumerate(results):
        assert_same(snapshot, make(step, dim))
        assert_same_surfaces(snapshot, make(step, dim))


@pytest.mark.parametrize("last_step", [0, 3, 5, 9])
@pytest.mark.parametrize("dim", [2, 3])
def test_resume_keeps_surfaces(tmp_path: Path, dim: int, last_step: int) -> None:
    path = tmp_path / "results.vtkhdf"
    write(path, range(6), dim)  # not closed: as after a kill the shadow is left behind
    writer = ResultsWriter.resume(path, last_step)
    first = min(last_step, 5) + 1
    assert read_results(path).steps == list(range(first))
    for step in range(first, first + 3):
        writer.append(make(step, dim))
    writer.close()
    for step, snapshot in enumerate(read_results(path)):
        assert_same_surfaces(snapshot, make(step, dim))


def contents(path: Path) -> dict[str, Any]:
    """Every group, data set and attribute of a file."""
    found: dict[str, Any] = {}

    def take(name: str, item: Any) -> None:
        values = item[()].tobytes() if isinstance(item, h5py.Dataset) else b""
        found[name] = (values, {key: np.asarray(v).tolist() for key, v in item.attrs.items()})

    with h5py.File(path) as file:
        file.visititems(take)
    return found


def test_surfaces_add_blocks_and_change_nothing_else(tmp_path: Path) -> None:
    plain, more = tmp_path / "plain.vtkhdf", tmp_path / "more.vtkhdf"
    writer = ResultsWriter(plain, title="a case", units=UNITS)
    for step in range(4):
        writer.append(make_snapshot(step))
    writer.close()
    write(more, range(4), 2).close()
    without, given = contents(plain), contents(more)
    assert not [name for name in without if "surface" in name]
    assert without["tilth"][1].keys() == {"dim", "title", "units"}
    assert read_results(plain).surfaces == ()
    assert read_results(plain).snapshot(2).surfaces == ()
    given["tilth"][1].pop("surfaces")
    assert without == {name: value for name, value in given.items() if "/surface_" not in name}


def cells_of(part: Any) -> int:
    """Number of cells of a partition; VTK 9.5 and 9.6 say -1 for an empty one, others give None."""
    return 0 if part is None else max(part.GetNumberOfCells(), 0)


@pytest.mark.parametrize("information_first", [True, False])
@pytest.mark.parametrize("dim", [2, 3])
def test_vtk_reads_every_step_of_surfaces(
    tmp_path: Path, dim: int, information_first: bool, capfd: pytest.CaptureFixture[str]
) -> None:
    io_hdf = pytest.importorskip("vtkmodules.vtkIOHDF")
    support = pytest.importorskip("vtkmodules.util.numpy_support")
    path = tmp_path / "results.vtkhdf"
    write(path, range(5), dim).close()
    reader = io_hdf.vtkHDFReader()
    reader.SetFileName(str(path))
    if information_first:  # as ParaView does
        reader.UpdateInformation()
    else:
        reader.Update()
    for step in (3, 0, 4, 1, 2):
        expected = make(step, dim)
        reader.UpdateTimeStep(0.1 * step)
        output = reader.GetOutputDataObject(0)
        assembly = output.GetDataAssembly()
        nodes = assembly.GetChildNodes(0, False)
        assert [assembly.GetNodeName(node) for node in nodes] == BLOCKS
        sets = [list(assembly.GetDataSetIndices(node)) for node in nodes]
        assert sets == [[0], [1], [2], [3]]
        place = output.GetPartition(0, 0).GetPoints().GetData()
        np.testing.assert_array_equal(support.vtk_to_numpy(place)[:, :dim], expected.position)
        grid = output.GetPartition(1, 0)
        assert cells_of(grid) == len(expected.cells)
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
    blocks = surface_blocks(names)
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
    assert_same_surfaces(read_results(path).snapshot(1), replace(twice, surfaces=shapes))


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
