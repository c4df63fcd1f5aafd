# SPDX-License-Identifier: BSD-3-Clause
"""The layout of ``results.vtkhdf``: VTKHDF 2.2, temporal PartitionedDataSetCollection.

Source: VTK documentation, "VTKHDF format specification". Each block is an unstructured grid whose
arrays grow with every output; the group ``Steps`` contains, per output, where its rows begin. One
output is one part. As long as the points are the same, their vertices, ``point_id`` and ``body_id``
are written once and the outputs refer to that part. Each tracked surface, contact surface and rigid
body is a block of its own. Next to the group ``VTKHDF`` the group ``tilth`` keeps the step numbers,
the unit labels, the names of the surfaces and bodies as the user wrote them and a check sum of each
output; VTK ignores it.

The reader of VTK 9.7 reads ``Steps/NSteps`` of the root of a collection, and shows the first output
for every time if there is none, although the format has the steps in the blocks only. The link
``Steps`` to the block ``grid``, which carries ``NSteps`` for that, makes all readers since VTK 9.4
show the right output; its disadvantage is an empty last member of the collection.
"""

from __future__ import annotations

import json
import os
import re
import struct
import zlib
from collections import ChainMap
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tilth.output.snapshot import ContactShape, FieldsOnDemand, Snapshot, SurfaceShape

VTK_VERTEX, VTK_LINE, VTK_TRIANGLE, VTK_QUAD, VTK_HEXAHEDRON = 1, 3, 5, 9, 12
VERSION = (2, 2)
BLOCKS = ("points", "grid")
STATIC_FIELDS = ("point_id", "body_id")
FAMILIES = {"surfaces": "surface_", "contacts": "contact_", "rigid_bodies": "rigid_"}
"""Further blocks: how their names begin, by the attributes of a snapshot and of the file."""

Names = Mapping[str, Sequence[str]]
"""Names of the tracked surfaces, contact surfaces and rigid bodies, by the keys of `FAMILIES`, and
under `BODY_FIELDS` the numbers of the bodies' overlays where they differ."""

BODY_FIELDS = "body_fields"


class DamagedResults(ValueError):
    """The file does not contain what was written to it."""


def names_in(snapshot: Snapshot) -> Names:
    """Returns the names of the surfaces and bodies of a snapshot."""
    names = {key: [shape.name for shape in getattr(snapshot, key)] for key in FAMILIES}
    return names | {BODY_FIELDS: [str(number) for number in snapshot.body_fields]}


def create_file(file: Any, dim: int, title: str, units: Mapping[str, str], names: Names) -> None:
    """Creates the layout of empty results in the open, writable ``h5py.File``.

    Raises ``ValueError`` if two ``names`` of surfaces or bodies of a kind are equal.
    """
    import h5py

    info = file.create_group("tilth")
    info.attrs["dim"] = dim
    info.attrs["title"] = title
    info.attrs["units"] = json.dumps(dict(units))
    blocks = [*BLOCKS]
    for key, start in FAMILIES.items():
        if own := block_names(start, names.get(key, ())):
            info.attrs[key] = json.dumps(own)
            blocks += own.values()
    if fields := [int(number) for number in names.get(BODY_FIELDS, ())]:
        info.attrs[BODY_FIELDS] = json.dumps(fields)
    root = file.create_group("VTKHDF", track_order=True)
    _set_type(root, "PartitionedDataSetCollection")
    root["Steps"] = h5py.SoftLink("/VTKHDF/grid")
    for index, name in enumerate(blocks):
        block = root.create_group(name)
        _set_type(block, "UnstructuredGrid")
        block.attrs["Index"] = index
        block.create_group("PointData")
        steps = block.create_group("Steps")
        steps.attrs["NSteps"] = 0
        steps.create_group("PointDataOffsets")
    root["grid"].attrs["NSteps"] = 0
    assembly = root.create_group("Assembly", track_order=True)
    for name in blocks:
        assembly.create_group(name, track_order=True)[name] = h5py.SoftLink(f"/VTKHDF/{name}")


def block_names(start: str, names: Sequence[str]) -> dict[str, str]:
    """Returns the name of the block of each surface, in their order, beginning with ``start``.

    VTK allows letters, digits and underscores; other characters become underscores, and a number is
    appended where two blocks would have the same name. Raises ``ValueError`` if two surfaces do.
    """
    if len(set(names)) != len(names):
        raise ValueError(f"two surfaces of the same name among {list(names)}")
    blocks: dict[str, str] = {}
    for name in names:
        safe = start + re.sub(r"[^A-Za-z0-9_]", "_", name)
        block, count = safe, 1
        while block in blocks.values():
            count += 1
            block = f"{safe}_{count}"
        blocks[name] = block
    return blocks


def stored_names(file: Any) -> Names:
    """Returns the names of the surfaces and bodies in the open ``h5py.File``."""
    names = {key: tuple(_blocks_of(file, key)) for key in FAMILIES}
    return names | {BODY_FIELDS: tuple(str(number) for number in _body_fields(file))}


def _body_fields(file: Any) -> tuple[int, ...]:
    """Returns the numbers of the bodies' overlays; none if all are the same."""
    return tuple(json.loads(file["tilth"].attrs.get(BODY_FIELDS, "[]")))


def _blocks_of(file: Any, key: str) -> dict[str, str]:
    """Returns the blocks of the surfaces or bodies of a kind by their names."""
    return dict(json.loads(file["tilth"].attrs.get(key, "{}")))


def append_snapshot(file: Any, snapshot: Snapshot) -> int:
    """Appends one output to the open, writable ``h5py.File``; returns its check sum.

    Raises ``ValueError`` if its fields or surfaces are not those of the first output.
    """
    stored = stored_names(file)
    for key, names in names_in(snapshot).items():
        if names != (first := list(stored[key])):
            raise ValueError(f"{key} {names} differ from the first output's {first}")
    n = len(snapshot.position)
    numbers = {
        "point_id": np.asarray(snapshot.point_id, dtype=np.int64),
        "body_id": np.asarray(snapshot.body_id, dtype=np.int64),
    }
    # computed one after the other, if the fields are computed at access
    point_fields = ChainMap(snapshot.point_fields, numbers)  # type: ignore[arg-type]
    vertices = np.arange(n, dtype=np.int64)[:, None]
    cell_type = VTK_QUAD if snapshot.dim == 2 else VTK_HEXAHEDRON
    root = file["VTKHDF"]
    sums = [
        _append_block(
            root["points"], snapshot.time, snapshot.position, vertices, VTK_VERTEX, point_fields
        )
    ]
    sums += [
        _append_block(
            root["grid"],
            snapshot.time,
            snapshot.node_position,
            np.asarray(snapshot.cells, dtype=np.int64).reshape(-1, 2**snapshot.dim),
            cell_type,
            snapshot.node_fields,
        )
    ]
    for key in FAMILIES:
        vertices_only = key == "contacts"
        surface_type = VTK_LINE if snapshot.dim == 2 else VTK_TRIANGLE
        for shape in getattr(snapshot, key):
            sums += [
                _append_block(
                    root[_blocks_of(file, key)[shape.name]],
                    snapshot.time,
                    shape.position,
                    np.asarray(shape.cells, dtype=np.int64),
                    VTK_VERTEX if vertices_only else surface_type,
                    shape.fields,
                )
            ]
    root["grid"].attrs["NSteps"] = root["grid/Steps"].attrs["NSteps"]
    _append(file["tilth"], "step", _row(snapshot.step))
    checksum = _checksum_of_output(snapshot, sums)
    _append(file["tilth"], "checksum", _row(checksum))
    return checksum


def copy_last_snapshot(file: Any, to: Any) -> None:
    """Appends the last output of one open ``h5py.File`` to another, a field at a time.

    Raises ``DamagedResults`` if it is not as it was written.
    """
    index = len(file["tilth/step"]) - 1
    _require_checksum(file, index, append_snapshot(to, _snapshot_on_demand(file, index)))


def read_snapshot(file: Any, index: int) -> Snapshot:
    """Returns output number ``index`` of the open ``h5py.File``, exactly as it was appended.

    Raises ``DamagedResults`` if its check sum shows that it is not.
    """
    on_demand = _snapshot_on_demand(file, index)
    read: dict[str, Any] = {
        key: tuple(replace(s, fields=dict(s.fields)) for s in getattr(on_demand, key))
        for key in FAMILIES
    }
    snapshot = replace(
        on_demand,
        point_fields=dict(on_demand.point_fields),
        node_fields=dict(on_demand.node_fields),
        **read,
    )
    fields = {
        **snapshot.point_fields,
        "point_id": snapshot.point_id,
        "body_id": snapshot.body_id,
    }
    sums = [_checksum_of_block(snapshot.position, None, fields)]
    sums += [_checksum_of_block(snapshot.node_position, snapshot.cells, snapshot.node_fields)]
    sums += [
        _checksum_of_block(each.position, None if key == "contacts" else each.cells, each.fields)
        for key in FAMILIES
        for each in getattr(snapshot, key)
    ]
    _require_checksum(file, index, _checksum_of_output(snapshot, sums))
    return snapshot


def _require_checksum(file: Any, index: int, found: int) -> None:
    if found != int(file["tilth/checksum"][index]):
        raise DamagedResults(f"output {index} is not as it was written: its check sum differs")


def _checksum_of_output(snapshot: Snapshot, blocks: Sequence[int]) -> int:
    head = struct.pack("<qd", snapshot.step, snapshot.time)
    return zlib.crc32(struct.pack(f"<{len(blocks)}q", *blocks), zlib.crc32(head))


def _checksum_of_block(
    position: NDArray[np.float64],
    cells: NDArray[np.int64] | None,
    fields: Mapping[str, NDArray[Any]],
) -> int:
    """Returns the check sum of a block in memory, the same as that of :class:`_BlockSum`."""
    found = _BlockSum()
    found.add("position", position)
    if cells is not None:
        found.add("cells", cells)
    for name, values in fields.items():
        found.add(name, values)
    return found.total


class _BlockSum:
    """Check sum of the arrays of a block, added in any order."""

    def __init__(self) -> None:
        self._sums: dict[str, int] = {}

    def add(self, name: str, values: NDArray[Any]) -> None:
        self._sums[name] = zlib.crc32(np.ascontiguousarray(values).data)

    @property
    def total(self) -> int:
        return zlib.crc32(json.dumps(self._sums, sort_keys=True).encode())


def _snapshot_on_demand(file: Any, index: int) -> Snapshot:
    """Returns output number ``index`` with fields that are read at access."""
    dim = int(file["tilth"].attrs["dim"])
    points, grid = file["VTKHDF/points"], file["VTKHDF/grid"]
    position, point_fields = _read_block(points, index, dim)
    node_position, node_fields = _read_block(grid, index, dim)
    shapes: dict[str, Any] = {
        key: tuple(
            _read_shape(key, name, file["VTKHDF"][block], index, dim)
            for name, block in _blocks_of(file, key).items()
        )
        for key in FAMILIES
    }
    make = dict(point_fields.make)
    point_id, body_id = make.pop("point_id")(), make.pop("body_id")()
    return Snapshot(
        step=int(file["tilth/step"][index]),
        time=float(points["Steps/Values"][index]),
        position=position,
        point_id=point_id,
        body_id=body_id,
        point_fields=FieldsOnDemand(make),
        node_position=node_position,
        cells=_read_cells(grid, index).reshape(-1, 2**dim),
        node_fields=node_fields,
        body_fields=_body_fields(file),
        **shapes,
    )


def _read_shape(
    key: str, name: str, block: Any, index: int, dim: int
) -> SurfaceShape | ContactShape:
    position, fields = _read_block(block, index, dim)
    if key == "contacts":
        return ContactShape(name, position, fields)
    return SurfaceShape(name, position, _read_cells(block, index).reshape(-1, dim), fields)


def _append_block(
    block: Any,
    time: float,
    position: NDArray[np.float64],
    cells: NDArray[np.int64],
    cell_type: int,
    fields: Mapping[str, NDArray[Any]],
) -> int:
    """Appends one output of one block; ``cells`` has one row of node numbers per cell.

    Returns its check sum, without the vertices, which follow from the number of points.
    """
    checksum = _BlockSum()
    checksum.add("position", position)
    if cell_type != VTK_VERTEX:
        checksum.add("cells", cells)
    steps, data = block["Steps"], block["PointData"]
    index = int(steps.attrs["NSteps"])
    if index > 0 and set(data) != set(fields):
        raise ValueError(f"fields {sorted(fields)} differ from the first output's {sorted(data)}")
    reuse = index > 0 and all(name in fields for name in STATIC_FIELDS)
    if reuse:
        part = int(steps["PartOffsets"][index - 1])
        reuse = int(block["NumberOfPoints"][part]) == len(position) and all(
            np.array_equal(_static(block, name, index - 1, len(position)), fields[name])
            for name in STATIC_FIELDS
        )
    if reuse:
        cell_start = int(steps["CellOffsets"][index - 1, 0])
        connectivity_start = int(steps["ConnectivityIdOffsets"][index - 1, 0])
    else:
        part = _append(block, "NumberOfPoints", _row(len(position)))
        _append(block, "NumberOfCells", _row(len(cells)))
        _append(block, "NumberOfConnectivityIds", _row(cells.size))
        offsets = np.arange(len(cells) + 1, dtype=np.int64) * cells.shape[1]
        _append(block, "Offsets", offsets)
        cell_start = _append(block, "Types", np.full(len(cells), cell_type, dtype=np.uint8))
        connectivity_start = _append(block, "Connectivity", cells.reshape(-1))
    for name, each in fields.items():
        values = np.asarray(each)
        checksum.add(name, values)
        if reuse and name in STATIC_FIELDS:
            start = int(steps["PointDataOffsets"][name][index - 1])
        else:
            start = _append(data, name, _to_vtk(values))
        _append(steps["PointDataOffsets"], name, _row(start))
    _append(steps, "PointOffsets", _row(_append(block, "Points", _to_vtk(position))))
    _append(steps, "CellOffsets", _row(cell_start)[:, None])
    _append(steps, "ConnectivityIdOffsets", _row(connectivity_start)[:, None])
    _append(steps, "PartOffsets", _row(part))
    _append(steps, "NumberOfParts", _row(1))
    _append(steps, "Values", np.array([time], dtype=np.float64))
    steps.attrs["NSteps"] = index + 1
    return checksum.total


def _static(block: Any, name: str, index: int, count: int) -> NDArray[Any]:
    """Returns a field of a block that seldom changes, in an earlier output."""
    first = int(block["Steps/PointDataOffsets"][name][index])
    return np.asarray(block["PointData"][name][first : first + count])


def _read_block(block: Any, index: int, dim: int) -> tuple[NDArray[np.float64], FieldsOnDemand]:
    """Returns points and fields of one output of one block, shapes as in :class:`Snapshot`."""
    steps = block["Steps"]
    count = int(block["NumberOfPoints"][steps["PartOffsets"][index]])
    first = int(steps["PointOffsets"][index])
    position = _rows(block["Points"], first, count)

    def field(name: str) -> NDArray[Any]:
        first = int(steps["PointDataOffsets"][name][index])
        return _from_vtk(_rows(block["PointData"][name], first, count), dim)

    fields = FieldsOnDemand({name: partial(field, name) for name in block["PointData"]})
    return np.ascontiguousarray(position[:, :dim]), fields


def _read_cells(block: Any, index: int) -> NDArray[np.int64]:
    """Returns the vertices of all cells of one output of one block, in one row."""
    steps = block["Steps"]
    first = int(steps["ConnectivityIdOffsets"][index, 0])
    count = int(block["NumberOfConnectivityIds"][steps["PartOffsets"][index]])
    return _rows(block["Connectivity"], first, count)


def _rows(dataset: Any, first: int, count: int) -> NDArray[Any]:
    """Returns rows of a dataset; raises ``DamagedResults`` where it has none.

    A damaged file may state any numbers. Data sets are not compressed, so none is larger than the
    file.
    """
    width = int(np.prod(dataset.shape[1:])) * dataset.dtype.itemsize
    size = os.fstat(dataset.file.id.get_vfd_handle()).st_size
    if not 0 <= first <= first + count <= dataset.shape[0] or count * width > size:
        raise DamagedResults(f"{dataset.name} has no rows {first} to {first + count}")
    return np.asarray(dataset[first : first + count])


def whole_column(dataset: Any) -> list[Any]:
    """Returns a data set with one row per output as a list."""
    return list(_rows(dataset, 0, int(dataset.shape[0])).tolist())


def _to_vtk(values: NDArray[Any]) -> NDArray[Any]:
    """Returns VTK's components: plane vectors with a third component 0, matrices as rows."""
    if values.ndim == 3:
        return values.reshape(len(values), -1)
    if values.ndim == 2 and values.shape[1] == 2:
        return np.pad(values, ((0, 0), (0, 1)))
    return values


def _from_vtk(values: NDArray[Any], dim: int) -> NDArray[Any]:
    """Returns the original components, the inverse of :func:`_to_vtk`."""
    if values.ndim == 2 and values.shape[1] == 9:
        return values.reshape(-1, 3, 3)
    if values.ndim == 2 and values.shape[1] == dim * 2**dim:
        return values.reshape(-1, 2**dim, dim)
    if values.ndim == 2 and values.shape[1] == 3:
        return np.ascontiguousarray(values[:, :dim])
    return values


def _append(group: Any, name: str, rows: NDArray[Any]) -> int:
    """Appends ``rows`` to a dataset, created if absent; returns the number of the first new row."""
    if name not in group:
        chunk = 64 if len(rows) == 1 else min(max(len(rows), 1024), 65536)
        group.create_dataset(
            name,
            data=rows,
            maxshape=(None, *rows.shape[1:]),
            chunks=(chunk, *rows.shape[1:]),
        )
        return 0
    dataset = group[name]
    start = int(dataset.shape[0])
    if len(rows) > 0:
        dataset.resize(start + len(rows), axis=0)
        dataset[start:] = rows
    return start


def _row(value: int) -> NDArray[np.int64]:
    return np.array([value], dtype=np.int64)


def _set_type(group: Any, name: str) -> None:
    """Sets the attributes that VTK requires of a group; the type is a fixed-length string."""
    group.attrs["Version"] = VERSION
    group.attrs["Type"] = np.bytes_(name)
