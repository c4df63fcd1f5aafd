# SPDX-License-Identifier: BSD-3-Clause
"""Snapshots to write into a results file, and what comes back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tracked_shapes import with_surfaces

from tilth.output import ResultsWriter, Snapshot

UNITS = {"length": "m", "force": "N", "stress": "Pa", "mass": "kg", "time": ""}


def make_snapshot(step: int, dim: int = 2, points: int = 7, surfaces: bool = False) -> Snapshot:
    """A snapshot whose numbers depend on the step, with a grid (and surfaces) that change size."""
    rng = np.random.default_rng(step)
    corners = np.array(np.meshgrid(*[[0.0, 1.0]] * dim, indexing="ij")).reshape(dim, -1).T
    order = [0, 2, 3, 1] if dim == 2 else [0, 4, 6, 2, 1, 5, 7, 3]
    count = step % 3
    shift = np.zeros(dim)
    nodes, cells = [], []
    for cell in range(count):
        shift[0] = 2.0 * cell + step
        nodes.append(corners + shift)
        cells.append(np.array(order) + cell * 2**dim)
    node_position = np.concatenate(nodes) if nodes else np.zeros((0, dim))
    snapshot = Snapshot(
        step=step,
        time=0.1 * step,
        position=rng.random((points, dim)),
        point_id=np.arange(points, dtype=np.int64),
        body_id=np.arange(points, dtype=np.int64) % 2,
        point_fields={
            "displacement": rng.random((points, dim)),
            "cauchy_stress": rng.random((points, 6)),
            "plastic_strain": rng.random(points),
            "volume": rng.random(points),
            "domain": rng.random((points, dim)),
            "domain_corners": rng.random((points, 2**dim, dim)),
            "deformation_gradient": rng.random((points, 3, 3)),
        },
        node_position=node_position,
        cells=np.array(cells, dtype=np.int64).reshape(-1, 2**dim),
        node_fields={
            "displacement": rng.random((len(node_position), dim)),
            "reaction": rng.random((len(node_position), dim)),
        },
    )
    return with_surfaces(snapshot) if surfaces else snapshot


def assert_same(a: Snapshot, b: Snapshot) -> None:
    assert (a.step, a.time) == (b.step, b.time)
    for name in ("position", "body_id", "node_position", "cells"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), strict=True)
    for x, y in ((a.point_fields, b.point_fields), (a.node_fields, b.node_fields)):
        assert x.keys() == y.keys()
        for name in x:
            np.testing.assert_array_equal(x[name], y[name], strict=True)
    assert [surface.name for surface in a.surfaces] == [surface.name for surface in b.surfaces]
    for one, other in zip(a.surfaces, b.surfaces, strict=True):
        np.testing.assert_array_equal(one.position, other.position, strict=True)
        np.testing.assert_array_equal(one.cells, other.cells, strict=True)
        assert one.fields.keys() == other.fields.keys()
        for name in one.fields:
            np.testing.assert_array_equal(one.fields[name], other.fields[name], strict=True)


def write(path: Path, steps: range, dim: int = 2, surfaces: bool = False) -> ResultsWriter:
    writer = ResultsWriter(path, title="a case", units=UNITS)
    for step in steps:
        writer.append(make_snapshot(step, dim, surfaces=surfaces))
    return writer


def opened_by_vtk(path: Path, information_first: bool) -> Any:
    """VTK's reader of a file; skips the test where there is no VTK."""
    reader = pytest.importorskip("vtkmodules.vtkIOHDF").vtkHDFReader()
    reader.SetFileName(str(path))
    if information_first:  # as ParaView does
        reader.UpdateInformation()
    else:
        reader.Update()
    return reader
