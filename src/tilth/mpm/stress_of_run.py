# SPDX-License-Identifier: BSD-3-Clause
"""Stress and state variables of points from the results of another run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.errors import BadInput
from tilth.model import Model
from tilth.model.initial import StressOfRun
from tilth.model.laws import EXCESS_PORE_PRESSURE
from tilth.model.problems import unknown_name
from tilth.model.settings import DARCY_VELOCITY
from tilth.output.folder import RESULTS, read_declared
from tilth.output.snapshot import Snapshot
from tilth.output.vtkhdf import Results, read_results
from tilth.variation.tables import place_text

SAME_PLACE = 1e-9
"""Distance, over the size of a domain, up to which a point is at the place of another one."""

WATER = "pore_pressure"
"""Field of the pressure of water, at rest and flowing, which is part of the Cauchy stress of
results."""

REACH = 1.5
"""Distance from the nearest point of the other run, in sizes of its domain, up to which a point
is within its soil."""

SAME_TIME = 1e-9
"""Difference of two times that are the same, over the time of the last output."""


@dataclass(frozen=True)
class StateOfRun:
    """What another run gives.

    Attributes:
        stress: Cauchy stress without the pore pressure of water at rest and of that which flows,
            tension positive, (n, 6).
        variables: state variables by name, shape (n,) each; "not a number" where the other run's
            law has none, and in soil through which water flows there the excess pore pressure.
    """

    stress: Floats
    variables: dict[str, Floats]


def state_of_run(model: Model, key: str, entry: StressOfRun, position: Floats) -> StateOfRun:
    """Returns the state of another run at positions (n, dim).

    Raises:
        BadInput: there is no such run, body or time, it has another dimension, or a position lies
            outside its soil.
    """
    folder = Path(entry.folder)
    try:
        declared, results = read_declared(folder), read_results(folder / RESULTS)
    except BadInput as error:
        raise BadInput(
            f"is not the folder of a finished run: {error.problem}",
            "name the folder with the results of `tilth run`",
            key=f"{key}.folder",
            value=entry.folder,
        ) from None
    if results.dim != model.dimension or _kind(declared) != model.analysis.kind:
        raise BadInput(
            f"is a run of the kind {_kind(declared)!r}, this one is {model.analysis.kind!r}",
            "name a run of the same kind",
            key=f"{key}.folder",
            value=entry.folder,
        )
    output = results.snapshot(_output(results, key, entry))
    own = output.body_id == _body(declared, key, entry)
    return _mapped(output, own, key, entry, position)


def _kind(declared: dict[str, Any]) -> str:
    analysis = declared.get("analysis")
    return str(analysis.get("kind", "")) if isinstance(analysis, dict) else ""


def _output(results: Results, key: str, entry: StressOfRun) -> int:
    if entry.time is None:
        return len(results) - 1
    times = np.array(results.times)
    nearest = int(np.abs(times - entry.time).argmin())
    if abs(times[nearest] - entry.time) <= SAME_TIME * max(times[-1], 1e-300):
        return nearest
    listed = ", ".join(f"{time:g}" for time in times[:20]) + (", ..." if len(times) > 20 else "")
    raise BadInput(
        f"that run has no output at this time, only at {listed}",
        "choose one of these, or leave it out for the last one",
        key=f"{key}.time",
        value=entry.time,
    )


def _body(declared: dict[str, Any], key: str, entry: StressOfRun) -> int:
    listed = declared.get("bodies")
    bodies = listed if isinstance(listed, list) else []
    names = [str(body.get("name", "")) for body in bodies if isinstance(body, dict)]
    wanted = entry.body if entry.source is None else entry.source
    if wanted in names:
        return names.index(wanted)
    problem, remedy = unknown_name("body", wanted, names)
    raise BadInput(f"{problem} in that run", remedy, key=f"{key}.source", value=wanted)


def _mapped(
    output: Snapshot, own: Flags, key: str, entry: StressOfRun, position: Floats
) -> StateOfRun:
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import Delaunay, QhullError, cKDTree

    there, size = output.position[own], 2.0 * output.point_fields["domain"][own]
    distance, nearest = cKDTree(there).query(position)
    beyond = np.abs(position - there[nearest]) > REACH * size[nearest]
    if beyond.any():
        worst = int(np.where(beyond.any(axis=1), distance, -1.0).argmax())
        raise BadInput(
            f"the point at {place_text(position[worst])} lies outside the soil of that run, whose "
            f"nearest point is at {place_text(there[nearest[worst]])}",
            "start the body with the stress of a run whose soil contains it",
            key=f"{key}.folder",
            value=entry.folder,
        )
    names = [
        name
        for name, values in output.point_fields.items()
        if values.ndim == 1 and name not in ("volume", "layer", WATER)
    ]
    stress = output.point_fields["cauchy_stress"][own].copy()
    if WATER in output.point_fields:
        stress[:, :3] += output.point_fields[WATER][own][:, None]
    columns = [stress]
    columns += [output.point_fields[name][own][:, None] for name in names]
    values = np.concatenate(columns, axis=1).astype(np.float64)
    if DARCY_VELOCITY in output.point_fields:  # there the pressure is no state of the law
        flows = ~np.isnan(output.point_fields[DARCY_VELOCITY][own, 0])
        values[flows, 6 + names.index(EXCESS_PORE_PRESSURE)] = np.nan
    found = values[nearest]
    other = np.flatnonzero(distance > SAME_PLACE * size[nearest].min(axis=1))
    if len(other):
        try:
            mesh = Delaunay(there / size.mean(axis=0))
        except (QhullError, ValueError):  # all points on a line
            mesh = None
        if mesh is not None:
            between = LinearNDInterpolator(mesh, values)(position[other] / size.mean(axis=0))
            found[other] = np.where(np.isnan(between), found[other], between)
    return StateOfRun(found[:, :6], {name: found[:, 6 + i] for i, name in enumerate(names)})
