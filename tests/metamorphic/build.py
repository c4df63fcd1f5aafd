# SPDX-License-Identifier: BSD-3-Clause
"""The entries of the model of a choice, section by section."""

from __future__ import annotations

from random import Random
from typing import Any

from small_problems import AXES

from metamorphic.choices import Choice
from metamorphic.models import CELL, DENSITY, GRAVITY, TOLERANCE, Ground, Tree, material
from metamorphic.staging import add_stages

WATER = 1.0
"""Unit weight of water."""
INERTIA: dict[str, Tree] = {
    "newmark": {"scheme": "newmark"},
    "generalised_alpha": {"scheme": "generalised_alpha", "spectral_radius": 0.6},
    "damped": {"scheme": "newmark", "damping": {"mass": 1.0, "stiffness": 0.002}},
    "pic": {"scheme": "generalised_alpha", "spectral_radius": 0.8, "velocity_update": "pic"},
}  # fmt: skip


def entries_of(choice: Choice, seed: str) -> Tree:
    """Returns the entries of the model of a choice; seed: of sizes and amounts."""
    ground = Ground(choice, Random(seed))
    entries: Tree = {
        "title": "metamorphic",
        "units": {"time": "s"} if ground.dynamic else {},
        "analysis": _analysis(ground),
        "grid": _grid(ground),
        "materials": _materials(ground),
        "bodies": _bodies(ground),
        "boundaries": [*_base(ground), *_sides(ground), *_driving_boundary(ground)],
        "rigid_bodies": _rigid_bodies(ground),
        "contact_pairs": _pairs(ground),
        "loads": _loads(ground),
        "initial": _initial(ground),
        "water": _water(ground),
        "schedule": {"steps": ground.steps, "end": ground.end, "minimum_step": 0.25},
        "output": {"report": False},
    }
    entries = {key: value for key, value in entries.items() if value}
    add_stages(ground, entries)
    return entries


def _analysis(ground: Ground) -> Tree:
    analysis = {
        "kind": ground.kind, "tolerance": TOLERANCE, "maximum_iterations": 15,
        "solver": ground.choice["solver"],
    }  # fmt: skip
    inertia = INERTIA.get(ground.choice["inertia"])
    return analysis | ({} if inertia is None else {"inertia": inertia})


def _grid(ground: Ground) -> Tree:
    """The grid, with a line along each plane that has a condition."""
    if ground.has("grid", "follow"):
        return {"cell_size": CELL, "follow": {
            "boundary": "driver", "place": ground.place(0.5 * ground.width, ground.crest),
            "axes": [ground.up],
        }}  # fmt: skip
    size: Any = CELL
    origin = ground.vector(0.0, ground.origin_up)
    if ground.has("grid", "graded"):
        rows = [[0.0, 0.9 * CELL], [(3 if ground.dim == 3 else 4) * CELL, 1.1 * CELL]]
        size = {axis: rows if axis == "x" else CELL for axis in ground.axes}
    elif ground.has("grid", "shifted"):
        origin = ground.vector(-CELL, ground.origin_up - 3 * CELL, CELL)
    return {"cell_size": size, "origin": origin} if any(origin) else {"cell_size": size}


def _materials(ground: Ground) -> Tree:
    law, found = ground.choice["law"], {}
    if law == "layers":
        found = {"soil": material("von_mises"), "lower": material("mohr_coulomb")}
    elif law == "varying":
        depth = {"depth": [[-1.0, 800.0], [5.0, 2000.0]], "surface": ground.crest}
        found = {"soil": {**material("hencky_elastic"), "young_modulus": depth}}
    else:
        found = {"soil": material(law)}
    if law == "modified_cam_clay" and ground.has("initial", "K0", "1-sin_phi"):
        del found["soil"]["preconsolidation_pressure"]
        found["soil"]["overconsolidation_ratio"] = 2.0
    if ground.has("stages", "exchange"):
        found["other"] = material("hencky_elastic" if law == "layers" else "von_mises")
        found["other"]["young_modulus"] = 1300.0
    if not ground.has("water", "none"):
        for each in found.values():
            each["saturated_density"] = DENSITY + 0.2
    return found


def _bodies(ground: Ground) -> list[Tree]:
    surface: Tree = {}
    if ground.has("load", "pressure", "traction") and ground.upper == "ground":
        surface = {"surface": {}}
    layers: Tree = {}
    if ground.has("law", "layers"):
        layers = {"layers": [
            {"material": "soil", "bottom": 0.5 * ground.height + 0.01}, {"material": "lower"},
        ]}  # fmt: skip
    shape = ground.box(0.0, 0.0, ground.width, ground.top)
    body = ground.body("ground", shape, **surface, **layers)
    if layers:
        del body["material"]
    found = [body]
    if not ground.has("second_body", "none"):
        above = ground.box(ground.start, ground.top, ground.right, ground.crest)
        found.append(ground.body("above", above, surface={"spacing": 2 * CELL}))
    return found


def _plane(name: str, axis: str, at: float, condition: str = "roller", **more: Any) -> Tree:
    return {"name": name, "type": "plane", "axis": axis, "at": at, "condition": condition, **more}


def _flat(ground: Ground, height: float, up: float) -> Tree:
    point = ground.place(0.5 * ground.width, height)
    return {"type": "plane", "point": point, "normal": ground.vector(0.0, up)}


def _base(ground: Ground) -> list[Tree]:
    base, up = ground.choice["base"], ground.up
    if base in ("rollers", "fixed"):
        return [_plane("base", up, 0.0, "roller" if base == "rollers" else "fixed")]
    if base == "absorbing":
        return [_plane("base", up, 0.0, "absorbing")]
    found: Tree = {"name": "base", "type": "implicit", "geometry": _flat(ground, 0.0, 1.0)}
    if base == "contact":
        return [found | {"contact": ground.contact, "wished_in_place": True}]
    condition = base.removeprefix("implicit_").removesuffix("_implicit")
    return [found | {"condition": condition}]


def _sides(ground: Ground) -> list[Tree]:
    found = []
    if ground.kind != "axisymmetric":
        found.append(_plane("left", "x", 0.0))
    if ground.kind == "3d":
        found.append(_plane("front", "y", 0.0))
        if ground.regular:
            found.append(_plane("back", "y", ground.depth))
    if ground.confined:
        found.append(_plane("right", "x", ground.width))
    return found


def _driving_boundary(ground: Ground) -> list[Tree]:
    way = -ground.amount(0.01, 0.03) * (0.2 if ground.dynamic else 1.0)
    moved = {"displacement": {ground.up: way}, "factor": ground.growing}
    if ground.has("driver", "prescribed_plane"):
        ends = [0.0, CELL]
        return [_plane("driver", ground.up, ground.crest, "prescribed", range={"x": ends}, **moved)]
    if ground.has("driver", "footing"):
        width = 1.2 * CELL
        geometry = {
            "type": "footing", "centre": ground.place(ground.start + CELL, ground.crest),
            "normal": ground.vector(0.0, -1.0),
            "width": width if ground.dim == 2 else [width, 0.9 * ground.depth],
        }  # fmt: skip
        if ground.dim == 3:
            geometry["along"] = [1.0, 0.0, 0.0]
        if ground.kind == "axisymmetric":
            geometry["centre"], geometry["width"] = [0.0, ground.crest], 2 * width
        entry = {"name": "driver", "type": "implicit", "geometry": geometry, "condition": "fixed"}
        return [entry | moved]
    return []


def _rigid_bodies(ground: Ground) -> list[Tree]:
    if not ground.has("driver", "rigid"):
        return []
    radius = 0.8 * CELL
    x = 0.0 if ground.kind == "axisymmetric" else ground.start + CELL
    gap = 0.0 if ground.regular else 0.003
    centre = ground.place(x, ground.crest + radius + gap)
    shape = "sphere" if ground.dim == 3 else "circle"
    up, weight = ground.up, 2.0 if ground.kind == "plane_strain" else 1.0
    body: Tree = {
        "name": "driver", "centre": centre, "contact": ground.contact,
        "geometry": {"type": shape, "centre": centre, "radius": radius, "soil": "outside"},
    }  # fmt: skip
    others = [axis for axis in ground.axes if axis != up and ground.kind != "axisymmetric"]
    still = dict.fromkeys(others, 0.0)
    turning: Tree = {} if ground.kind == "axisymmetric" else {
        "rotation": dict.fromkeys(AXES, 0.0) if ground.dim == 3 else 0.0
    }  # fmt: skip
    if ground.has("driver", "rigid_prescribed"):
        aside = dict.fromkeys(others[:1], 0.005)
        down = {up: -ground.amount(0.01, 0.03), **still, **aside}
        return [body | turning | {"displacement": down, "factor": ground.growing}]
    if ground.dynamic:
        body["mass"] = weight / GRAVITY
    body |= {"force": {up: -weight}, "force_factor": ground.growing}
    held = {"displacement": still} if still else {}
    if ground.has("driver", "rigid_springs"):
        springs = {up: 20.0} | dict.fromkeys(others[:1], 30.0)
        held = {"displacement": dict.fromkeys(others[1:], 0.0)} if others[1:] else {}
        return [body | turning | held | {"springs": springs}]
    return [body | turning | held]


def _pairs(ground: Ground) -> list[Tree]:
    if not ground.has("second_body", "pair"):
        return []
    return [
        {"name": "pair", "bodies": ["above", "ground"], "contact": ground.contact,
         "wished_in_place": True}
    ]  # fmt: skip


def _loads(ground: Ground) -> list[Tree]:
    weight = ground.constant if ground.at_once else ground.growing
    found = [
        {"name": "weight", "type": "body_force", "acceleration": ground.vector(0.0, -GRAVITY),
         "factor": weight}
    ]  # fmt: skip
    load, amount = ground.choice["load"], ground.amount(4.0, 8.0)
    x, factor = ground.start, ground.growing
    entry: Tree = {"name": "load", "factor": factor}
    if load in ("pressure", "traction"):
        entry |= {"type": "surface", "body": ground.upper}
        if ground.dim == 3:
            entry["part"] = "z+"
        else:
            entry |= {"start": [x + CELL, ground.crest], "end": [x, ground.crest]}
        aside = 0.0 if ground.kind == "axisymmetric" else 0.3 * amount
        across = 0.1 * amount
        push = {"traction": ground.vector(aside, -amount, across)}
        found.append(entry | ({"pressure": amount} if load == "pressure" else push))
    elif load == "point_force":
        force = ground.vector(0.0 if ground.kind == "axisymmetric" else 0.5, -2.0)
        at = ground.place(x + 0.6 * CELL, ground.crest - 0.1)
        found.append(entry | {"type": load, "body": ground.upper, "at": at, "force": force})
    elif load == "line_force":
        ends = [[x + 0.6 * CELL, at, ground.crest - 0.1] for at in (0.1, 0.35)]
        found.append(entry | {
            "type": load, "body": ground.upper, "start": ends[0], "end": ends[1],
            "force": [0.5, 0.2, -3.0],
        })  # fmt: skip
    elif load == "seismic":
        aside = 0.0 if ground.kind == "axisymmetric" else 0.1
        found.append(entry | {"type": load, "coefficient": ground.vector(aside, 0.05)})
    return found


def _initial(ground: Ground) -> Tree:
    kind = ground.choice["initial"]
    names = ["ground"] if ground.has("second_body", "none") else ["ground", "above"]
    if kind == "none":
        return {}
    own: Tree
    if kind in ("K0", "1-sin_phi"):
        own = {"type": "k0", "K0": 0.6 if kind == "K0" else kind}
    elif kind == "gravity":
        own = {"type": "gravity", "steps": 2}
    elif kind == "given":
        three = [-20.0, -30.0, -20.0] if ground.dim == 2 else [-20.0, -20.0, -30.0]
        own = {"type": "given", "stress": three + [0.0] * (3 if ground.dim == 3 else 1)}
    else:
        rows = [[-1.0, 5.0], [0.0, 5.0], [5.0, 5.0 + 5.0 * DENSITY * GRAVITY]]
        own = {
            "type": "table",
            "K0": 0.6,
            "vertical_pressure": {"depth": rows, "surface": ground.crest},
        }
    return {"stress": [{**own, "body": name} for name in names]}


def _water(ground: Ground) -> Tree:
    level = round(0.7 * ground.height, 3)
    if ground.has("water", "level"):
        return {"level": level, "unit_weight": WATER}
    if ground.has("water", "falling"):
        return {"level": level - 0.3, "initial_level": level, "unit_weight": WATER}
    return {}
