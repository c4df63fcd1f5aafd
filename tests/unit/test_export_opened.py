# SPDX-License-Identifier: BSD-3-Clause
"""Exports that Gmsh and ParaView open, and those that are refused."""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest.mock import MagicMock

import numpy as np
import pytest
from gmsh_session import gmsh_session
from test_export import run_at

import tilth
from tilth.errors import AnalysisFailed, BadInput
from tilth.export import vtk_files
from tilth.export.files import FileNames
from tilth.export.run import export_run
from tilth.output import read_results

SQUARE = [[0, 3, 5], [3, 1, 4], [5, 4, 2]]


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("show", ["domains", "points"])
def test_meshio_reads_the_views_of_gmsh(tmp_path: Path, dim: int, show: Any) -> None:
    meshio = pytest.importorskip("meshio")
    run = run_at(tmp_path / "run", dim)
    fields = ["displacement", "cauchy_stress", "plastic_strain", "cauchy_stress_mean"]
    export_run(run, "gmsh", tmp_path / "out", times=[0.0, 0.2], fields=fields, show=show)
    for index in (0, 2):
        stored = read_results(run / "results.vtkhdf").snapshot(index)
        mesh = meshio.read(tmp_path / "out" / f"output_{index:04d}.msh")
        order = np.argsort(stored.body_id, kind="stable")
        count = len(order)

        def of_soil(name: str, mesh: Any = mesh, count: int = count) -> np.ndarray:
            values = np.concatenate(mesh.cell_data[name])
            assert np.isnan(values[count:]).all()
            return values[:count]

        moved = stored.point_fields["displacement"][order]
        np.testing.assert_array_equal(of_soil("displacement [m]")[:, :dim], moved)
        stress = stored.point_fields["cauchy_stress"][order]
        square = of_soil("cauchy_stress [Pa]").reshape(-1, 3, 3)
        np.testing.assert_array_equal(square, stress[:, SQUARE])
        np.testing.assert_array_equal(
            of_soil("cauchy_stress_mean [Pa]"), stress[:, :3].mean(axis=1)
        )
        np.testing.assert_array_equal(
            of_soil("plastic_strain"), stored.point_fields["plastic_strain"][order]
        )
        assert {"soft_clay", "rigid_pipe"} <= set(mesh.field_data)
        assert ("sand" in mesh.field_data) == (index == 2)
    assert not (tmp_path / "out" / "output_0001.msh").exists()


def test_gmsh_opens_a_view_of_each_field_at_its_time(tmp_path: Path) -> None:
    run = run_at(tmp_path / "run", 2)
    export_run(run, "gmsh", tmp_path / "out", fields=["plastic_strain", "displacement"])
    with gmsh_session() as gmsh:
        gmsh.option.setNumber("General.Verbosity", 0)
        gmsh.open(str(tmp_path / "out" / "output_0002.msh"))
        groups = {gmsh.model.getPhysicalName(*group) for group in gmsh.model.getPhysicalGroups()}
        assert {"soft_clay", "sand", "rigid_pipe", "surface_cavity"} <= groups
        first, second = gmsh.view.getTags()
        _, elements, data, time, width = gmsh.view.getModelData(first, 0)
        stored = read_results(run / "results.vtkhdf").snapshot(2)
        assert (time, width) == (stored.time, 1)
        strain = stored.point_fields["plastic_strain"][np.argsort(stored.body_id, kind="stable")]
        values = dict(zip(elements.tolist(), np.concatenate(data).tolist(), strict=True))
        assert [values[each] for each in range(1, len(strain) + 1)] == strain.tolist()
        assert gmsh.view.option.getNumber(first, "Max") == strain.max()
        assert gmsh.view.option.getString(second, "Name") == "displacement [m]"
        assert gmsh.view.option.getNumber(first, "Visible") == 1
        assert gmsh.view.option.getNumber(second, "Visible") == 0
        assert gmsh.option.getNumber("Mesh.SurfaceEdges") == 0


@pytest.mark.parametrize("field", [None, "displacement", "displacement_y", "plastic_strain"])
def test_all_that_the_view_names_is_in_the_results(tmp_path: Path, field: str | None) -> None:
    """The script runs against recording objects; its blocks and arrays are found by VTK itself."""
    hdf = pytest.importorskip("vtkmodules.vtkIOHDF")
    extract = pytest.importorskip("vtkmodules.vtkFiltersExtraction")
    run = run_at(tmp_path / "run", 3)
    chosen = None if field is None else [field]
    (file,) = export_run(run, "paraview", tmp_path / "out", times=[0.1], fields=chosen)
    simple = MagicMock()
    names: dict[str, Any] = {}
    paraview = ModuleType("paraview")
    paraview.simple = simple  # type: ignore[attr-defined]
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "paraview", paraview)
        patch.setattr(sys, "argv", [str(file)])
        exec(compile(file.read_text(encoding="utf-8"), str(file), "exec"), names)
    simple.OpenDataFile.assert_called_once_with(str((run / "results.vtkhdf").resolve()))
    assert names["scene"].AnimationTime == 0.1
    reader = hdf.vtkHDFReader()
    reader.SetFileName(names["RESULTS"])
    reader.UpdateInformation()
    reader.SetStep(1)
    for selectors in (["/Root/points"], [f"/Root/{name}" for name in names["SURFACES"]]):
        filter_ = extract.vtkExtractBlockUsingDataAssembly()
        filter_.SetInputConnection(reader.GetOutputPort())
        filter_.SetAssemblyName("Hierarchy")
        for selector in selectors:
            filter_.AddSelector(selector)
        filter_.Update()
        found = filter_.GetOutputDataObject(0)
        assert found.GetNumberOfPartitionedDataSets() == len(selectors)
        assert found.GetNumberOfPoints() > 0
        if selectors == ["/Root/points"]:
            array = found.GetPartition(0, 0).GetPointData().GetArray(names["FIELD"])
            assert (
                array.GetNumberOfComponents()
                == {"": 1, "Y": 3, "Magnitude": 3, "YY": 6}[names["COMPONENT"]]
            )
    label = {
        None: "cauchy stress, yy [Pa]",
        "displacement": "displacement, magnitude [m]",
        "displacement_y": "displacement, y [m]",
        "plastic_strain": "plastic strain",
    }[field]
    assert names["LABEL"] == names["bar"].Title == label
    every = [s.point_fields for s in read_results(run / "results.vtkhdf")]
    if field == "plastic_strain":
        strains = np.concatenate([fields["plastic_strain"] for fields in every])
        assert names["RANGE"] == (strains.min(), strains.max())
    if field is None:
        stresses = np.concatenate([fields["cauchy_stress"][:, 1] for fields in every])
        assert names["RANGE"] == (stresses.min(), stresses.max())


def test_what_cannot_be_exported_is_refused(tmp_path: Path) -> None:
    run = run_at(tmp_path / "run", 2)
    (tmp_path / "empty").mkdir()
    out = tmp_path / "out"
    for ask, said in (
        (lambda: export_run(tmp_path / "nowhere", "csv", out), "there is no such folder"),
        (lambda: export_run(tmp_path / "empty", "csv", out), "does not exist"),
        (lambda: export_run(run, "csv", out, fields=["plastic"]), "did you mean plastic_strain"),
        (lambda: export_run(run, "csv", out, times=[0.05]), "choose from 0, 0.1, 0.2"),
        (lambda: export_run(run, "csv", out, times=[]), "no time is given"),
        (lambda: export_run(run, "xls", out), "choose from vtk, csv"),  # type: ignore[arg-type]
        (lambda: export_run(run, "csv", run), "is not empty"),
        (lambda: export_run(run, "csv", run / "results.vtkhdf"), "is a file"),
        (lambda: export_run(run, "paraview", out, fields=["cauchy_stress_mean"]), "not stored"),
        (lambda: export_run(run, "paraview", out, fields=["volume", "domain"]), "one field"),
    ):
        with pytest.raises(BadInput) as error:
            ask()
        assert said in str(error.value)
        assert not out.exists()
    assert sorted(path.name for path in run.iterdir()) == ["model.json", "results.vtkhdf"]


def test_without_meshio_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = run_at(tmp_path / "run", 2)
    monkeypatch.setitem(sys.modules, "meshio", None)
    with pytest.raises(BadInput, match=r"tilth\[mesh\]"):
        export_run(run, "vtk", tmp_path / "out")
    assert not (tmp_path / "out").exists()
    assert export_run(run, "csv", tmp_path / "out")


def test_a_full_disk_leaves_nothing_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = run_at(tmp_path / "run", 2)
    (tmp_path / "out").mkdir()

    written: list[Path] = []

    def full(_: Any, path: Path) -> None:
        path.write_bytes(b"part of a file")
        written.append(path)
        if len(written) == 3:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(vtk_files, "_write", full)
    with pytest.raises(AnalysisFailed, match="the disk is full"):
        export_run(run, "vtk", tmp_path / "out", times="all")
    assert len(written) == 3
    assert list((tmp_path / "out").iterdir()) == []


def test_names_of_files_are_safe_and_differ() -> None:
    names = FileNames()
    given = [
        ("", "a/b"),
        ("", "a b"),
        ("", "A_B"),
        ("", ".."),
        ("", "a/b"),
        ("surface_", "Erdböschung"),
    ]
    found = [names.of(*each) for each in given]
    assert FileNames(["bodies"]).of("", "Bodies") == "Bodies_2"
    assert found == ["a_b", "a_b_2", "A_B_3", "_", "a_b", "surface_Erdb_schung"]


def test_an_open_run_exports_itself(tmp_path: Path) -> None:
    run = tilth.open(run_at(tmp_path / "run", 2))
    files = run.export("csv", times=run.times)
    assert files[0].parent == tmp_path / "run_csv"
    assert len([file for file in files if file.name.startswith("points_")]) == len(run.times)
