# SPDX-License-Identifier: BSD-3-Clause
"""What is declared of water that flows, in words."""

from __future__ import annotations

from collections.abc import Iterator

from tilth.model import Model
from tilth.model.flow import FlowBoundary, PlaneFlowBoundary, SurfaceFlowBoundary
from tilth.report.amounts import vector


def flow_texts(model: Model) -> Iterator[str]:
    """Yields the unit weight of the water, and each flow boundary; nothing if no water flows."""
    if model.flow is None:
        return
    unit = model.units
    text = f"unit weight {model.flow.unit_weight:g} {unit.force}/{unit.length}^3"
    if model.flow.bulk_modulus is not None:
        text += f", bulk modulus {model.flow.bulk_modulus:g} {unit.stress}"
    if model.flow.density is not None:
        text += f", density {model.flow.density:g} {unit.mass}/{unit.length}^3"
    yield text
    for each in model.flow.boundaries:
        what: str = each.condition
        if each.condition == "pressure":
            what = f"excess pressure {each.value:g} {unit.stress}"
        elif each.condition == "head":
            what = f"head {each.value:g} {unit.length}"
        elif each.condition == "flux":
            what = f"flux {each.value:g} {unit.length}/{unit.time} into the soil"
        yield f"{each.name}: {what} {_place(each)}"


def _place(each: FlowBoundary) -> str:
    if isinstance(each, PlaneFlowBoundary):
        ranges = (
            f", {axis} = {low:g} to {high:g}" for axis, (low, high) in (each.range or {}).items()
        )
        return f"at {each.axis} = {each.at:g}{''.join(ranges)}"
    if isinstance(each, SurfaceFlowBoundary):
        where = f" from {vector(each.start)} to {vector(each.end or ())}" if each.start else ""
        where = f" ({each.part})" if each.part else where
        return f"on the surface of {each.body}{where}"
    return f"on a geometry of type {each.geometry.type}"
