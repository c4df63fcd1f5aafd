# SPDX-License-Identifier: BSD-3-Clause
"""results.vtkhdf: what is written is read back, by us and by VTK, also after a kill."""

from __future__ import annotations

import fcntl
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
from result_snapshots import UNITS, assert_same, make_snapshot, opened_by_vtk, write

from tilth.errors import BadInput
from tilth.output import ResultsWriter, Snapshot, read_results

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("surfaces", [False, True])
@pytest.mark.parametrize("dim", [2, 3])
def test_snapshots_come_back_bit_for_bit(tmp_path: Path, dim: int, surfaces: bool) -> None:
    path = tmp_path / "results.vtkhdf"
    write(path, range(6), dim, surfaces).close()
    results = read_results(path)
    assert results.surfaces == (("cavity", "top & side") if surfaces else ())
    assert (results.title, results.units, results.dim) == ("a case", UNITS, dim)
    assert results.steps == list(range(6))
    assert results.times == [0.1 * step for step in range(6)]
    for step, snapshot in enumerate(results):
        assert_same(snapshot, make_snapshot(step, dim, surfaces=surfaces))
    assert_same(results.snapshot(-1), make_snapshot(5, dim, surfaces=surfaces))
    assert [file.name for file in tmp_path.iterdir()] == ["results.vtkhdf"]


@pytest.mark.parametrize("information_first", [True, False])
@pytest.mark.parametrize("dim", [2, 3])
def test_vtk_reads_every_step(
    tmp_path: Path, dim: int, information_first: bool, capfd: pytest.CaptureFixture[str]
) -> None:
    support = pytest.importorskip("vtkmodules.util.numpy_support")
    path = tmp_path / "results.vtkhdf"
    write(path, range(5), dim).close()
    reader = opened_by_vtk(path, information_first)
    information = reader.GetOutputInformation(0)
    key = reader.GetExecutive().TIME_STEPS()
    times = [information.Get(key, i) for i in range(information.Length(key))]
    assert times == [0.1 * step for step in range(5)]

    def array(data: object, name: str) -> np.ndarray:
        return support.vtk_to_numpy(data.GetPointData().GetArray(name))  # type: ignore[attr-defined]

    for step in (3, 0, 4, 1, 2):
        expected = make_snapshot(step, dim)
        reader.UpdateTimeStep(times[step])
        output = reader.GetOutputDataObject(0)
        assembly = output.GetDataAssembly()
        names = [assembly.GetNodeName(node) for node in assembly.GetChildNodes(0, False)]
        assert names == ["points", "grid"]
        points = output.GetPartition(0, 0)
        assert points.GetNumberOfCells() == points.GetNumberOfPoints() == 7
        assert {points.GetCellType(i) for i in range(7)} == {1}
        place = support.vtk_to_numpy(points.GetPoints().GetData())
        np.testing.assert_array_equal(place[:, :dim], expected.position)
        np.testing.assert_array_equal(place[:, dim:], 0.0)
        np.testing.assert_array_equal(array(points, "point_id"), np.arange(7))
        np.testing.assert_array_equal(array(points, "body_id"), expected.body_id)
        for name, values in expected.point_fields.items():
            read = array(points, name)
            columns = values.reshape(7, -1) if values.ndim > 1 else values
            width = columns.shape[-1]
            np.testing.assert_array_equal(read[:, :width] if values.ndim > 1 else read, columns)
            assert read.ndim == 1 or read.shape[1] in (3, 6, 9, dim * 2**dim)
        assert points.GetPointData().GetArray("cauchy_stress").GetComponentName(3) in (None, "XY")
        grid = output.GetPartition(1, 0)
        count = 0 if grid is None else grid.GetNumberOfCells()
        assert count == len(expected.cells)
        if count:
            assert {grid.GetCellType(i) for i in range(count)} == {9 if dim == 2 else 12}
            for i, cell in enumerate(expected.cells):
                ids = grid.GetCell(i).GetPointIds()
                assert [ids.GetId(k) for k in range(2**dim)] == list(cell)
                assert grid.GetCell(i).ComputeBoundingSphere([0.0] * 3) > 0.0
            for name, values in expected.node_fields.items():
                np.testing.assert_array_equal(array(grid, name)[:, :dim], values)
    assert capfd.readouterr() == ("", "")  # VTK complains on stderr only


def test_cells_of_vtk_have_positive_measure(tmp_path: Path) -> None:
    quality = pytest.importorskip("vtkmodules.vtkFiltersVerdict")
    path = tmp_path / "results.vtkhdf"
    write(path, range(3), 3).close()
    reader = opened_by_vtk(path, information_first=True)
    reader.UpdateTimeStep(0.2)
    size = quality.vtkCellSizeFilter()
    size.SetInputData(reader.GetOutputDataObject(0).GetPartition(1, 0))
    size.Update()
    volumes = size.GetOutput().GetCellData().GetArray("Volume")
    assert [volumes.GetValue(i) for i in range(2)] == pytest.approx([1.0, 1.0])


@pytest.mark.parametrize("last_step", [0, 1, 3, 5, 9])
@pytest.mark.parametrize(("dim", "surfaces"), [(2, False), (2, True), (3, True)])
def test_resume_drops_later_outputs_and_goes_on(
    tmp_path: Path, dim: int, surfaces: bool, last_step: int
) -> None:
    path = tmp_path / "results.vtkhdf"
    write(path, range(6), dim, surfaces)  # not closed: as after a kill the shadow is left behind
    writer = ResultsWriter.resume(path, last_step)
    first = min(last_step, 5) + 1
    assert read_results(path).steps == list(range(first))
    for step in range(first, first + 4):
        writer.append(make_snapshot(step, dim, surfaces=surfaces))
        assert read_results(path).steps == list(range(step + 1))
    writer.close()
    for step, snapshot in enumerate(read_results(path)):
        assert_same(snapshot, make_snapshot(step, dim, surfaces=surfaces))


def test_a_reader_that_keeps_the_file_open_is_not_disturbed(tmp_path: Path) -> None:
    path = tmp_path / "results.vtkhdf"
    writer = write(path, range(2))
    with h5py.File(path, "r") as constrained:
        for step in range(2, 6):
            writer.append(make_snapshot(step))
        assert list(constrained["tilth/step"]) == [0, 1]
        np.testing.assert_array_equal(
            constrained["VTKHDF/points/Points"][7:, :2], make_snapshot(1).position
        )
    writer.close()
    for step, snapshot in enumerate(read_results(path)):
        assert_same(snapshot, make_snapshot(step))


def test_without_hard_links_the_file_is_copied(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError("no hard links here")

    monkeypatch.setattr("os.link", refuse)
    write(tmp_path / "results.vtkhdf", range(5)).close()
    assert read_results(tmp_path / "results.vtkhdf").steps == list(range(5))


def test_an_output_that_fails_does_not_spoil_the_next(tmp_path: Path) -> None:
    path = tmp_path / "results.vtkhdf"
    writer = write(path, range(3))
    wrong = make_snapshot(3)
    with pytest.raises(ValueError, match="fields"):
        writer.append(
            Snapshot(
                3,
                0.3,
                wrong.position,
                wrong.point_id,
                wrong.body_id,
                {},
                wrong.node_position,
                wrong.cells,
                {},
            )
        )
    assert read_results(path).steps == [0, 1, 2]
    writer.append(make_snapshot(3))
    writer.close()
    for step, snapshot in enumerate(read_results(path)):
        assert_same(snapshot, make_snapshot(step))


def test_steps_must_increase(tmp_path: Path) -> None:
    writer = write(tmp_path / "results.vtkhdf", range(3))
    with pytest.raises(ValueError, match="step 2"):
        writer.append(make_snapshot(2))


def test_unreadable_files_are_bad_input(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="does not exist"):
        read_results(tmp_path / "absent.vtkhdf")
    (tmp_path / "text.vtkhdf").write_text("not HDF5")
    with pytest.raises(BadInput, match="cannot be read as HDF5"):
        read_results(tmp_path / "text.vtkhdf")
    h5py.File(tmp_path / "other.vtkhdf", "w").close()
    with pytest.raises(BadInput, match="not written by tilth"):
        read_results(tmp_path / "other.vtkhdf")
    with pytest.raises(BadInput, match="exists already"):
        ResultsWriter(tmp_path / "text.vtkhdf", units=UNITS)


CHILD = """
import sys
sys.path[:0] = sys.argv[3:]
from pathlib import Path
from result_snapshots import UNITS, make_snapshot
from tilth.output import ResultsWriter
path = Path(sys.argv[1])
start = int(sys.argv[2])
writer = ResultsWriter.resume(path, start) if start >= 0 else ResultsWriter(path, units=UNITS)
for step in range(start + 1, 100000):
    writer.append(make_snapshot(step, points=2000))
    print(step, flush=True)
"""


def test_reading_waits_for_a_program_that_writes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "results.vtkhdf"
    write(path, range(2)).close()
    with path.open("rb+") as file:
        fcntl.flock(file.fileno(), fcntl.LOCK_EX)
        threading.Timer(0.1, fcntl.flock, (file.fileno(), fcntl.LOCK_UN)).start()
        assert len(read_results(path)) == 2
        fcntl.flock(file.fileno(), fcntl.LOCK_EX)
        monkeypatch.setattr("tilth.output.vtkhdf.WAIT_FOR_WRITER", 0.0)
        with pytest.raises(BadInput, match="locked by a program that writes it"):
            read_results(path)


def test_killed_at_any_moment_the_file_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "results.vtkhdf"
    rng = np.random.default_rng(1)
    last = -1
    folders = Path(__file__).parents[:2]
    for _ in range(6):
        child = subprocess.Popen(
            [sys.executable, "-c", CHILD, str(path), str(last), *map(str, folders)],
            stdout=subprocess.PIPE,
            text=True,
        )
        assert child.stdout is not None
        promised = int(child.stdout.readline())
        deadline = time.monotonic() + rng.uniform(0.0, 0.2)
        seen = promised
        while time.monotonic() < deadline:
            steps = read_results(path).steps
            assert steps == list(range(len(steps)))
            assert steps[-1] >= seen
            seen = steps[-1]
        child.send_signal(signal.SIGKILL)
        for line in child.stdout:
            promised = int(line)
        child.wait()
        child.stdout.close()
        results = read_results(path)
        assert results.steps == list(range(len(results)))
        assert results.steps[-1] in (promised, promised + 1)
        assert_same(results.snapshot(-1), make_snapshot(results.steps[-1], points=2000))
        last = results.steps[-1]
