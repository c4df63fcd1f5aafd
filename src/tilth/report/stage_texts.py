# SPDX-License-Identifier: BSD-3-Clause
"""Stages in words: what changes at the start of each, and what acts in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from tilth.model import BodyForce, ImplicitBoundary, Model, PointForce
from tilth.model.grading import along_axes, largest, smallest
from tilth.model.loads import Load
from tilth.model.stages import Stage
from tilth.model.staging import moves
from tilth.output.safety_files import whose_text
from tilth.report.amounts import cells_text, elevation, shape_text, vector


def load_name(number: int, load: Load) -> str:
    """Returns the name of a load, or what it is."""
    if load.name is not None:
        return load.name
    if isinstance(load, BodyForce):
        return "body force"
    kind = "point force" if isinstance(load, PointForce) else "load on the surface"
    return f"{kind} of loads[{number}]"


def changes(model: Model) -> list[str]:
    """Returns what changes at the start of a stage, in a few words each.

    model: of the stage.
    """
    stage = model.stage.declared
    assert stage is not None
    bodies = {body.name for body in model.bodies}
    loads = {load.name for load in model.loads}
    found = []
    for key, words in (("activate", "{} acts"), ("deactivate", "{} ends")):
        names = getattr(stage, key)
        soil = [name for name in names if name in bodies]
        if soil:
            found.append(f"{'new' if key == 'activate' else 'removed'}: {', '.join(soil)}")
        found += [words.format(name) for name in names if name not in bodies and name in loads]
        found += [words.format(name) for name in names if name not in bodies | loads]
    if stage.excavate:
        of = dict.fromkeys(region.body for region in stage.excavate)
        found.append(f"excavated: part of {', '.join(of)}")
    found += [f"{old} becomes {new}" for old, new in stage.materials.items()]
    if stage.water is not None:
        found.append(f"water to {elevation(stage.water.level, model.units.length)}")
    if stage.grid is not None:
        found.append(f"grid: {_cells(stage.grid.cell_size, model)}")
    if stage.reset:
        found.append(f"reset: {', '.join(each.replace('_', ' ') for each in stage.reset)}")
    return found


def brings_soil(model: Model) -> bool:
    """Returns whether a stage begins with soil that was not there before, or of other materials."""
    stage = model.stage.declared
    if stage is None or model.stage.number == 0:
        return True
    return bool(stage.materials) or any(body.name in stage.activate for body in model.bodies)


def stage_rows(model: Model) -> Iterator[tuple[str, str]]:
    """Yields headings and texts of the stages of a model, for a table."""
    for each in model.of_stages:
        stage = each.stage.declared
        assert stage is not None
        heading = f"stage {each.stage.index + 1}"
        schedule, start = stage.schedule, each.stage.start
        steps, outputs = schedule.number_of_steps, len(schedule.times_of_output())
        yield (
            heading,
            f"{stage.name}: {steps} step{'' if steps == 1 else 's'} from time {start:g} to "
            f"{start + schedule.end:g}, {'adaptive' if schedule.adaptive else 'of fixed size'}; "
            f"{outputs} output{'' if outputs == 1 else 's'}",
        )
        for text in _rows_of(each, stage):
            yield heading, text
        for index, reduction in each.stage.reductions:
            yield (
                f"stage {index + 1}",
                f"{reduction.name}: factor of safety by strength reduction, to "
                f"{reduction.tolerance:g}{whose_text(reduction.davis)}",
            )


def _rows_of(model: Model, stage: Stage) -> Iterator[str]:
    for key in ("activate", "deactivate"):
        if names := getattr(stage, key):
            yield f"{key}s {', '.join(f'{_kind(name, model)} {name}' for name in names)}"
    for region in stage.excavate:
        yield f"excavates a {shape_text(region.shape)} of {region.body}"
    for old, new in stage.materials.items():
        yield f"exchanges the material {old} for {new}"
    if stage.water is not None:
        yield f"moves the water to the level {elevation(stage.water.level, model.units.length)}"
    if stage.grid is not None:
        origin = "" if stage.grid.origin is None else f", a node at {vector(stage.grid.origin)}"
        yield f"has a grid with {_cells(stage.grid.cell_size, model)}{origin}"
    if stage.reset:
        yield f"resets {' and '.join(each.replace('_', ' ') for each in stage.reset)} to 0"
    factors = [*_factors(model)]
    if factors:
        yield f"factors: {'; '.join(factors)}"
    if stage.release is not None:
        yield f"releases forces that are out of balance by the shares {_table(stage.release)}"


def _kind(name: str, model: Model) -> str:
    if any(body.name == name for body in model.bodies):
        return "the body"
    return "the load" if any(load.name == name for load in model.loads) else "the boundary"


def _factors(model: Model) -> Iterator[str]:
    """Yields the factors of what acts or moves: constant, or those of the table's rows."""
    items = [(load_name(number, load), load) for number, load in model.acting_loads()]
    items += [(each.name, each) for each in model.boundaries if moves(each)]  # type: ignore[misc]
    for name, item in items:
        table = model.load_curve(item).table
        if len({factor for _, factor in table}) == 1:
            yield f"{name} {table[0][1]:g}"
        elif len(table) == 2:
            yield f"{name} {table[0][1]:g} to {table[1][1]:g}"
        else:
            yield f"{name} {_table(table)}"


def _table(rows: Sequence[Sequence[float]]) -> str:
    """Returns the rows of a table, the first and the last of many."""
    texts = [f"{value:g} at {time:g}" for time, value in rows]
    if len(texts) > 6:
        texts = [*texts[:3], "...", texts[-1]]
    return ", ".join(texts)


def _cells(cell_size: Any, model: Model) -> str:
    if not isinstance(cell_size, Mapping) and not isinstance(cell_size, tuple):
        return f"cells of {cell_size:g} {model.units.length}".rstrip()
    sizes = along_axes(cell_size, model.dimension)
    return cells_text([(smallest(s), largest(s)) for s in sizes], model.units.length)


def boundary_names(model: Model) -> tuple[str, ...]:
    """Returns the names of all boundaries and rigid bodies: on grid lines, implicit, rigid."""
    ordered = sorted(model.boundaries, key=lambda each: isinstance(each, ImplicitBoundary))
    return tuple(each.name for each in (*ordered, *model.rigid_bodies))
