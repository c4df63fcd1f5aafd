# SPDX-License-Identifier: BSD-3-Clause
"""Stages of a random model."""

from __future__ import annotations

from metamorphic.models import CELL, Ground, Tree


def add_stages(ground: Ground, entries: Tree) -> None:
    """Divides the schedule of a model into stages in which its choice happens; in place."""
    kind = ground.choice["stages"]
    if kind == "none":
        return
    schedule = entries.pop("schedule")
    first: Tree = {"name": "first", "schedule": dict(schedule)}
    second: Tree = {
        "name": "second",
        "schedule": {**schedule, "steps": 1 if ground.dim == 3 else 2},
    }
    entries["stages"] = [first, second]
    left = ground.width - CELL
    if kind == "loads":
        entries["stages"].append({"name": "third", "schedule": {**schedule, "steps": 1}})
        if len(entries["loads"]) > 1:
            del entries["loads"][1]["factor"]
            second["activate"] = ["load"]
            entries["stages"][2]["deactivate"] = ["load"]
        else:
            second["deactivate"] = ["weight"]
    elif kind == "boundary":
        if ground.confined:
            second["deactivate"] = ["right"]
    elif kind == "excavate":
        region = ground.box(left, ground.top - CELL, ground.width + CELL, ground.top + 3 * CELL)
        second["excavate"] = [{"body": "ground", "shape": region}]
    elif kind in ("remove", "fill", "refill"):
        piece = ground.box(left, ground.top, ground.width, ground.top + 0.5 * CELL)
        entries["bodies"].append(ground.body("piece", piece))
        second["activate" if kind == "fill" else "deactivate"] = ["piece"]
        if kind == "refill":
            entries["bodies"].append(ground.body("new piece", piece))
            third = {"name": "third", "schedule": {**schedule, "steps": 1}}
            entries["stages"].append(third | {"activate": ["new piece"]})
        if kind != "fill" and "initial" in entries:
            own = {**entries["initial"]["stress"][0], "body": "piece"}
            entries["initial"]["stress"].append(own)
    elif kind == "exchange":
        second["materials"] = {"soil": "other"}
    elif kind == "grid":
        second["grid"] = {"cell_size": 0.5 * CELL}
