# SPDX-License-Identifier: BSD-3-Clause
"""The section of a run in space by a plane across an axis, as a state in the plane."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.errors import BadInput
from tilth.output.snapshot import Snapshot, SurfaceShape
from tilth.report.domains import corners_of_boxes
from tilth.report.fields import AXES
from tilth.report.interpolation import values_at


@dataclass(frozen=True)
class Section:
    """A plane across one axis."""

    axis: int
    place: float

    @classmethod
    def of(cls, text: str) -> Section:
        """Returns the section of a text such as ``x=1.0``; raises ``BadInput`` for any other."""
        name, _, number = text.partition("=")
        try:
            place = float(number)
        except ValueError:
            place = np.nan
        if name.strip() not in AXES or not np.isfinite(place):
            raise BadInput(
                "is not a plane across an axis", "write x=1.0", key="section", value=text
            )
        return cls(AXES.index(name.strip()), place)

    @property
    def others(self) -> list[int]:
        """The axes in the plane."""
        return [axis for axis in range(3) if axis != self.axis]


def section_of(snapshot: Snapshot, values: Floats, section: Section) -> tuple[Snapshot, Floats]:
    """Returns the state and a field's values in a plane, from those in space.

    Its points are those whose domains are cut; their values are those of linear functions through
    the points around them, in the plane. Raises ``BadInput`` if the plane cuts no soil.
    """
    axis, others = section.axis, section.others
    corners = snapshot.point_fields.get("domain_corners")
    if corners is None:
        corners = corners_of_boxes(snapshot.point_fields["domain"])
    along = snapshot.position[:, axis]
    low, high = corners[:, :, axis].min(axis=1), corners[:, :, axis].max(axis=1)
    room = 1e-9 * float(np.ptp(along)) + 1e-9 * float((high - low).max())
    cut = np.flatnonzero(
        (along + low <= section.place + room) & (section.place < along + high - room)
    )
    if len(cut) == 0:
        ends = (along + low).min(), (along + high).max()
        raise BadInput(
            "cuts no soil",
            f"the soil is from {ends[0]:.4g} to {ends[1]:.4g} along {AXES[axis]}",
            key="section",
            value=f"{AXES[axis]}={section.place:g}",
        )
    place = snapshot.position[cut].copy()
    place[:, axis] = section.place
    half = 0.5 * np.ptp(corners[cut][:, :, others], axis=1)
    state = replace(
        snapshot,
        position=place[:, others],
        point_id=snapshot.point_id[cut],
        body_id=snapshot.body_id[cut],
        point_fields={"domain": half},
        surfaces=(),
        contacts=(),
        rigid_bodies=tuple(_cut(shape, section) for shape in snapshot.rigid_bodies),
    )
    return state, values_at(snapshot.position, values, place)


def _cut(shape: SurfaceShape, section: Section) -> SurfaceShape:
    """Returns where a plane cuts a surface of triangles: segments, with the soil on their left."""
    corner = shape.position[shape.cells]
    height = corner[:, :, section.axis] - section.place
    height = np.where(
        height == 0.0, 1e-12 * max(float(np.abs(height).max(initial=0.0)), 1e-300), height
    )
    crossed = np.flatnonzero((height.min(axis=1) < 0.0) & (height.max(axis=1) > 0.0))
    corner, height = corner[crossed], height[crossed]
    ends = np.zeros((len(crossed), 2, 3))
    count = np.zeros(len(crossed), dtype=np.int64)
    for first in range(3):
        second = (first + 1) % 3
        rows = np.flatnonzero(height[:, first] * height[:, second] < 0.0)
        share = height[rows, first] / (height[rows, first] - height[rows, second])
        start, end = corner[rows, first], corner[rows, second]
        ends[rows, count[rows]] = start + share[:, None] * (end - start)
        count[rows] += 1
    segment = ends[:, :, section.others]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, section.others]
    step = segment[:, 1] - segment[:, 0]
    wrong = step[:, 0] * normal[:, 1] - step[:, 1] * normal[:, 0] < 0.0
    segment = np.where(wrong[:, None, None], segment[:, ::-1], segment)
    return _chained(shape.name, segment)


def _chained(name: str, segment: Floats) -> SurfaceShape:
    """Returns segments (n, 2, 2) as a surface whose cells are in order along its chains."""
    from tilth.report.surface_lines import chains

    cells: list[Integers] = []
    places: list[Floats] = []
    count = 0
    for chain in chains(segment):
        line = np.concatenate([segment[chain, 0], segment[chain[-1:], 1]])
        number = count + np.arange(len(chain))
        cells.append(np.column_stack([number, number + 1]))
        places.append(line)
        count += len(line)
    if not cells:
        return SurfaceShape.nowhere(name, 2)
    return SurfaceShape(name, np.concatenate(places), np.concatenate(cells), {})
