# SPDX-License-Identifier: BSD-3-Clause
"""Exported numbers and times are those of the results, read back by other programs' readers."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree import ElementTree

import numpy as np
import pytest
from result_snapshots import UNITS, make_snapshot

from tilth.export.run import export_run
from tilth.output import ResultsWriter, Snapshot, read_results
from tilth.output.snapshot import ContactShape, SurfaceShape

BODIES = ["soft clay", "sand"]


def state(step: int, dim: int) -> Snapshot:
    """Two bodies, surfaces, a contact and a rigid body; the second body comes at output 1."""
    made = make_snapshot(step, dim, surfaces=True)
    rows = made.body_id <= (0 if step == 0 else 1)
    fields = {name: values[rows] for name, values in made.point_fields.items()}
    rigid = SurfaceShape("pipe", 1.0 + step + np.eye(dim), np.arange(dim)[None], {})
    contact = ContactShape.empty("pipe", dim) if step == 0 else contact_of(dim)
    fields["cohesion"] = np.where(made.body_id[rows] == 1, np.nan, 5.0)
    return replace(
        made,
        position=made.position[rows],
        point_id=made.point_id[rows],
        body_id=made.body_id[rows],
        point_fields=fields,
        rigid_bodies=(rigid,),
        contacts=(contact,),
    )


def contact_of(dim: int) -> ContactShape:
    rng = np.random.default_rng(5)
    empty = ContactShape.empty("pipe", dim).fields
    fields = {name: rng.random((3, *values.shape[1:])) for name, values in empty.items()}
    for flag in ("in_contact", "sliding"):
        fields[flag] = np.array([1, 0, 1], dtype=np.int8)
    return ContactShape("pipe", rng.random((3, dim)), fields)


@cache
def results_file(dim: int) -> bytes:
    with TemporaryDirectory() as folder:
        file = Path(folder) / "results.vtkhdf"
        writer = ResultsWriter(file, title="two", units={**UNITS, "time": "d"})
        for step in range(3):
            writer.append(state(step, dim))
        writer.close()
        return file.read_bytes()


def run_at(folder: Path, dim: int, kind: str = "plane_strain") -> Path:
    folder.mkdir()
    (folder / "results.vtkhdf").write_bytes(results_file(dim))
    model = {
        "bodies": [{"name": name} for name in BODIES],
        "analysis": {"kind": kind},
        "output": {"colour_by": "cauchy_stress_yy"},
    }
    (folder / "model.json").write_text(json.dumps(model))
    return folder


def collection(path: Path) -> list[tuple[float, Path]]:
    """Times and files of a collection."""
    sets = ElementTree.parse(path).getroot().iter("DataSet")
    return [(float(each.attrib["timestep"]), path.parent / each.attrib["file"]) for each in sets]


def flat(values: np.ndarray) -> np.ndarray:
    """As VTK has them: plane vectors in space, matrices as rows."""
    rows = values.reshape(len(values), int(np.prod(values.shape[1:])))
    plane = values.ndim == 2 and values.shape[1] == 2
    return np.pad(rows, ((0, 0), (0, 1))) if plane else rows


@pytest.mark.slow
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("show", ["domains", "points"])
def test_vtk_reads_every_output_to_the_last_bit(tmp_path: Path, dim: int, show: str) -> None:
    pyvista = pytest.importorskip("pyvista")
    run = run_at(tmp_path / "run", dim)
    files = export_run(run, "vtk", tmp_path / "out", times="all", show=show)
    assert sorted(files) == sorted(path for path in (tmp_path / "out").rglob("*") if path.is_file())
    results = read_results(run / "results.vtkhdf")
    for number, name in enumerate(("soft_clay", "sand")):
        outputs = collection(tmp_path / "out" / f"{name}.pvd")
        assert [time for time, _ in outputs] == results.times
        for (_, file), stored in zip(outputs, results, strict=True):
            mesh, of_body = pyvista.read(file), stored.body_id == number
            assert (
                mesh.n_cells
                == of_body.sum()
                == (0 if (number, stored.step) == (1, 0) else 4 - number)
            )
            if mesh.n_cells == 0:
                continue
            data = mesh.cell_data if show == "domains" else mesh.point_data
            place = data["position"] if show == "domains" else mesh.points
            np.testing.assert_array_equal(place, flat(stored.position[of_body]))
            np.testing.assert_array_equal(data["point_id"], stored.point_id[of_body])
            assert set(stored.point_fields) - set(data.keys()) == {"domain_corners"}
            for field in set(stored.point_fields) - {"domain_corners"}:
                values = stored.point_fields[field][of_body]
                np.testing.assert_array_equal(data[field].reshape(len(values), -1), flat(values))
            if show == "domains":
                corners = stored.position[:, None] + stored.point_fields["domain_corners"]
                assert {tuple(row) for row in mesh.points[:, :dim].tolist()} == {
                    tuple(row) for row in corners[of_body].reshape(-1, dim).tolist()
                }
    together = collection(tmp_path / "out" / "bodies.pvd")
    assert [time for time, _ in together] == [time for time in results.times for _ in BODIES]
    for index, stored in enumerate(results):
        files_then = [file for time, file in together if time == stored.time]
        assert sum(pyvista.read(file).n_cells for file in files_then) == len(stored.position)
        for family, shapes in (
            ("surface", stored.surfaces),
            ("rigid", stored.rigid_bodies),
            ("contact", stored.contacts),
        ):
            for shape in shapes:
                file = collection(next((tmp_path / "out").glob(f"{family}_{shape.name[:3]}*.pvd")))
                mesh = pyvista.read(file[index][1])
                np.testing.assert_array_equal(mesh.points, flat(shape.position))
                assert mesh.n_cells == len(shape.cells)
                if len(shape.cells):
                    corners = mesh.cell_connectivity.reshape(shape.cells.shape)
                    np.testing.assert_array_equal(corners, shape.cells)
                    for name, values in shape.fields.items():
                        found = mesh.point_data[name].reshape(len(values), -1)
                        np.testing.assert_array_equal(found, flat(values))


def test_domains_have_the_volume_of_boxes_in_the_right_order(tmp_path: Path) -> None:
    """A cell whose corners were in a wrong order would have another, or a negative, volume."""
    pyvista = pytest.importorskip("pyvista")
    for dim in (2, 3):
        stored = state(1, dim)
        fields = {k: v for k, v in stored.point_fields.items() if k != "domain_corners"}
        (tmp_path / f"{dim}").mkdir()
        writer = ResultsWriter(tmp_path / f"{dim}" / "results.vtkhdf", units=UNITS)
        writer.append(replace(stored, point_fields=fields))
        writer.close()
        export_run(tmp_path / f"{dim}", "vtk", tmp_path / f"{dim}out")
        mesh = pyvista.read(tmp_path / f"{dim}out" / "body_1" / "0000.vtu")
        sizes = mesh.compute_cell_sizes()["Area" if dim == 2 else "Volume"]
        box = np.prod(2.0 * fields["domain"][stored.body_id == 1], axis=1)
        np.testing.assert_allclose(sizes, box, rtol=1e-12)


@pytest.mark.parametrize(("dim", "kind"), [(2, "plane_strain"), (2, "axisymmetric"), (3, "")])
def test_tables_have_all_digits_and_units(tmp_path: Path, dim: int, kind: str) -> None:
    run = run_at(tmp_path / "run", dim, kind)
    export_run(run, "csv", tmp_path / "out", times="all")
    results = read_results(run / "results.vtkhdf")
    outputs = table(tmp_path / "out" / "outputs.csv")
    assert [float(time) for time in outputs["time [d]"]] == results.times
    assert [int(step) for step in outputs["step"]] == results.steps
    for index, stored in enumerate(results):
        points = table(tmp_path / "out" / f"points_{index:04d}.csv")
        assert points["body"] == [BODIES[body] for body in stored.body_id]
        np.testing.assert_array_equal(numbers(points, "point_id"), stored.point_id)
        for axis, column in zip("xyz", stored.position.T, strict=False):
            np.testing.assert_array_equal(numbers(points, f"{axis} [m]"), column)
        stress = stored.point_fields["cauchy_stress"]
        for part, column in zip(("xx", "yy", "zz", "xy", "yz", "xz"), stress.T, strict=True):
            np.testing.assert_array_equal(numbers(points, f"cauchy_stress_{part} [Pa]"), column)
        gradient = stored.point_fields["deformation_gradient"]
        np.testing.assert_array_equal(numbers(points, "deformation_gradient_xy"), gradient[:, 0, 1])
        for name in ("plastic_strain", "displacement_y [m]", "cohesion [Pa]"):
            column = stored.point_fields[name.split(" [")[0].removesuffix("_y")]
            expected = column[:, 1] if column.ndim == 2 else column
            np.testing.assert_array_equal(numbers(points, name), expected)
    area = {"plane_strain": "area [m^2/m]", "axisymmetric": "area [m^2]", "": "area [m^2]"}
    pipe = table(tmp_path / "out" / "contact_pipe_0002.csv")
    contact = results.snapshot(2).contacts[0]
    heading = area[kind] if kind else "area"
    np.testing.assert_array_equal(numbers(pipe, heading), contact.fields["area"])
    np.testing.assert_array_equal(
        numbers(pipe, "shear_stress_y [Pa]"), contact.fields["shear_stress"][:, 1]
    )
    for name, unit in (("normal_stress", "Pa"), ("gap", "m")):
        np.testing.assert_array_equal(numbers(pipe, f"{name} [{unit}]"), contact.fields[name])
    np.testing.assert_array_equal(numbers(pipe, "sliding"), contact.fields["sliding"])
    for shape in results.snapshot(1).surfaces:
        (file,) = (tmp_path / "out").glob(f"surface_{shape.name[:3]}*_0001.csv")
        np.testing.assert_array_equal(numbers(table(file), "x [m]"), shape.position[:, 0])
        np.testing.assert_array_equal(
            numbers(table(file), "normal_y"), shape.fields["normal"][:, 1]
        )


def table(path: Path) -> dict[str, list[str]]:
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    return {heading: [row[i] for row in rows[1:]] for i, heading in enumerate(rows[0])}


def numbers(columns: dict[str, list[str]], heading: str) -> np.ndarray:
    return np.array([float(cell) for cell in columns[heading]])
