# SPDX-License-Identifier: BSD-3-Clause
"""What is wrong between the initial state and the other entries of a model."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tilth.errors import Problem
from tilth.model.bodies import Body
from tilth.model.cam_clay import ModifiedCamClay
from tilth.model.initial import JAKY, AtRest, GivenStress, GravityStress, MaterialAtRest
from tilth.model.materials import Material
from tilth.model.problems import dotted, unknown_name
from tilth.model.soils import DruckerPrager, MohrCoulomb
from tilth.model.staging import placed_later

if TYPE_CHECKING:
    from tilth.model.declaration import Declaration


def initial_problems(model: Declaration) -> Iterator[Problem]:
    """Yields what is wrong with the initial stress, velocity and pore pressure."""
    yield from _entries(model)
    yield from _velocities(model)
    yield from _pore_pressures(model)
    later = placed_later(model)
    for i, body in enumerate(model.bodies):
        entry = model.initial.of(body.name)
        for key, name in zip(body.material_keys(), body.materials, strict=True):
            material = model.materials.get(name)
            if material is None or not material.needs_stress:
                continue
            what = f"a material of the model {material.model!r} cannot be without stress"
            if body.name in later:
                what += ", but a stage places this body, without stress"
                remedy = "place another material; exchange it for this one in a later stage"
                yield Problem(f"bodies[{i}].{key}", what, remedy, name)
            elif entry is None:
                remedy = f"add an entry [[initial.stress]] with body = {body.name!r}"
                yield Problem(f"bodies[{i}].{key}", what, remedy, name)
            elif isinstance(entry[1], GravityStress):
                remedy = 'give its body a stress of another type, such as "k0"'
                yield Problem(f"{entry[0]}.type", f"{what}, not even at first", remedy, "gravity")
    yield from _preconsolidation(model)
    if model.initial.reset_plastic_strain and not model.initial.stress:
        remedy = "leave it out, or give the bodies a stress"
        yield Problem("initial.reset_plastic_strain", "there is no [[initial.stress]]", remedy)


def _entries(model: Declaration) -> Iterator[Problem]:
    bodies = {body.name: body for body in model.bodies}
    numbers: dict[str, int] = {}
    components = 6 if model.dimension == 3 else 4
    later = placed_later(model)
    for i, entry in enumerate(model.initial.stress):
        key = f"initial.stress[{i}]"
        if entry.body not in bodies:
            yield Problem(f"{key}.body", *unknown_name("body", entry.body, bodies), entry.body)
        if numbers.setdefault(entry.body, i) != i:
            what = f"has its stress from initial.stress[{numbers[entry.body]}] already"
            yield Problem(f"{key}.body", what, "keep one entry for each body", entry.body)
        if entry.body in later:
            what = "is placed by a stage, without stress"
            remedy = "leave this entry out, or do not activate the body: it is then there at first"
            yield Problem(f"{key}.body", what, remedy, entry.body)
        if isinstance(entry, GivenStress) and len(entry.stress) != components:
            order = "xx, yy, zz, xy" + (", yz, xz" if components == 6 else "")
            what = f"has {len(entry.stress)} components, expected {components}"
            yield Problem(f"{key}.stress", what, f"give {order}", entry.stress)
        if isinstance(entry, AtRest) and entry.body in bodies:
            yield from _at_rest(model, entry, key, bodies[entry.body])
        if isinstance(entry, GravityStress) and not _is_loaded(model):
            what = "no load acts at time 0, so there is nothing to apply"
            remedy = "add a load with its whole factor from the start: factor = [[0, 1], [1, 1]]"
            yield Problem(f"{key}.type", what, remedy, "gravity")
        if isinstance(entry, GravityStress) and not model.initial.equilibrium:
            what = "gravity loading is a search for equilibrium, which is switched off"
            yield Problem("initial.equilibrium", what, "leave it out", value=False)


def _pore_pressures(model: Declaration) -> Iterator[Problem]:
    bodies = {body.name: body for body in model.bodies}
    numbers: dict[str, int] = {}
    later = placed_later(model)
    for i, entry in enumerate(model.initial.pore_pressure):
        key = f"initial.pore_pressure[{i}]"
        if model.flow is None:
            yield Problem(key, "has no meaning without [flow]", "add it, or leave this out")
        if entry.body not in bodies:
            yield Problem(f"{key}.body", *unknown_name("body", entry.body, bodies), entry.body)
            continue
        if numbers.setdefault(entry.body, i) != i:
            what = f"has its pressure from initial.pore_pressure[{numbers[entry.body]}] already"
            yield Problem(f"{key}.body", what, "keep one entry for each body", entry.body)
        materials = [model.materials.get(name) for name in bodies[entry.body].materials]
        if not any(each is None or each.conducts_water for each in materials):
            what = "no water flows through its material"
            remedy = "give the material a `hydraulic_conductivity`, or leave this entry out"
            yield Problem(f"{key}.body", what, remedy, entry.body)
        if entry.body in later:
            what = "is placed by a stage, without excess pore pressure"
            yield Problem(f"{key}.body", what, "leave this entry out", entry.body)


def _velocities(model: Declaration) -> Iterator[Problem]:
    bodies = {body.name: body for body in model.bodies}
    numbers: dict[str, int] = {}
    for i, entry in enumerate(model.initial.velocity):
        key = f"initial.velocity[{i}]"
        if model.analysis.inertia is None:
            what, remedy = "has no meaning without inertia", "add `inertia` to [analysis]"
            yield Problem(key, what, remedy)
        if entry.body not in bodies:
            yield Problem(f"{key}.body", *unknown_name("body", entry.body, bodies), entry.body)
        if numbers.setdefault(entry.body, i) != i:
            what = f"has its velocity from initial.velocity[{numbers[entry.body]}] already"
            yield Problem(f"{key}.body", what, "keep one entry for each body", entry.body)
        if model.dimension == 2 and entry.z != 0.0:
            yield Problem(f"{key}.z", "is for 3D only", "leave it out", entry.z)
        if (rotation := entry.angular_velocity) is None or entry.centre is None:
            continue
        is_vector = not isinstance(rotation, float)
        if model.analysis.kind == "axisymmetric":
            what = "is not possible in axisymmetry"
            yield Problem(f"{key}.angular_velocity", what, "leave it out", rotation)
        elif is_vector != (model.dimension == 3):
            what = f"must be {'a vector in 3D' if model.dimension == 3 else 'a number in 2D'}"
            yield Problem(f"{key}.angular_velocity", what, "", rotation)
        if len(entry.centre) != model.dimension:
            what = f"has {len(entry.centre)} coordinates, expected {model.dimension}"
            yield Problem(f"{key}.centre", what, "", entry.centre)


def _is_loaded(model: Declaration) -> bool:
    """Whether a load or water may act at time 0; a stage may have other factors."""
    return (
        bool(model.stages)
        or model.water is not None
        or any(model.load_curve(load).factor(0.0) != 0.0 for load in model.loads)
    )


def _at_rest(model: Declaration, entry: AtRest, key: str, body: Body) -> Iterator[Problem]:
    """What is wrong with the coefficients at rest of a body's materials."""
    for name in entry.materials:
        if name not in body.materials:
            known = dict.fromkeys(body.materials)
            yield Problem(f"{key}.materials", *unknown_name("material", name, known), name)
    for name in dict.fromkeys(body.materials):
        material = model.materials.get(name)
        if material is None:
            continue
        rest = at_rest_of(entry, name)
        if problem := _coefficient(rest, name, material):
            yield Problem(f"{key}{problem.key}", problem.problem, problem.remedy, problem.value)


def _coefficient(rest: RestOfMaterial, name: str, material: Material) -> Problem | None:
    """Returns what is wrong with the coefficient of a material; the key begins with a point."""
    if rest.K0 is None and rest.K0_nc is None:
        remedy = f'give a number or "{JAKY}", for the body or for this material'
        return Problem(".K0", f"missing for the material {name!r}", remedy)
    key, value = ("K0", rest.K0) if rest.K0 is not None else ("K0_nc", rest.K0_nc)
    if value == JAKY and not isinstance(material, MohrCoulomb | DruckerPrager | ModifiedCamClay):
        what = f"the material {name!r} ({material.model}) has no friction angle"
        return Problem(f"{rest.of_coefficient}.{key}", what, "give a number", JAKY)
    if rest.K0_nc is not None and rest.past is None:
        what = f"no overconsolidation of the material {name!r} is given"
        remedy = "give `overconsolidation_ratio` or `pre_overburden_pressure`, or `K0` instead"
        return Problem(f"{rest.of_coefficient}.K0_nc", what, remedy, value)
    if rest.K0_nc is not None and getattr(material, "poisson_ratio", None) is None:
        what = f"the material {name!r} has no Poisson's ratio for its unloading"
        return Problem(f"{rest.of_coefficient}.K0_nc", what, "give `K0` instead", value)
    is_number = isinstance(rest.K0, float) and not isinstance(material, ModifiedCamClay)
    if rest.past is not None and is_number:
        what = f"is of no use for the material {name!r}: its K0 is a number"
        remedy = f'leave it out, or give K0 = "{JAKY}", or `K0_nc` in place of K0'
        return Problem(f"{rest.of_past}.{rest.past_key}", what, remedy, rest.past)
    return None


@dataclass(frozen=True)
class RestOfMaterial:
    """What is declared of the stress at rest of one material of a body.

    Attributes:
        K0, K0_nc: as in `AtRest`; at most one of them.
        overconsolidation_ratio, pre_overburden_pressure: likewise, numbers or variations.
        of_coefficient, of_past: where each pair is given in the entry of the body: "" for the body,
            ".materials.NAME" for the material.
    """

    K0: float | str | None
    K0_nc: float | str | None
    overconsolidation_ratio: float | None
    pre_overburden_pressure: float | None
    of_coefficient: str
    of_past: str

    @property
    def past_key(self) -> str:
        """Which of the two tells of the past stress."""
        given = self.pre_overburden_pressure is not None
        return "pre_overburden_pressure" if given else "overconsolidation_ratio"

    @property
    def past(self) -> float | None:
        """That entry; None without one."""
        value: float | None = getattr(self, self.past_key)
        return value


def at_rest_of(entry: AtRest, material: str) -> RestOfMaterial:
    """Returns what is declared of a material of a body; its own goes before that of the body."""
    own = entry.materials.get(material)
    key = dotted(("materials", material))
    coefficient: AtRest | MaterialAtRest = entry
    past: AtRest | MaterialAtRest = entry
    if own is not None and (own.K0 is not None or own.K0_nc is not None):
        coefficient = own
    if own is not None and (
        own.overconsolidation_ratio is not None or own.pre_overburden_pressure is not None
    ):
        past = own
    return RestOfMaterial(
        coefficient.K0,
        coefficient.K0_nc,
        past.overconsolidation_ratio,
        past.pre_overburden_pressure,
        "" if coefficient is entry else f".{key}",
        "" if past is entry else f".{key}",
    )


def _preconsolidation(model: Declaration) -> Iterator[Problem]:
    """Cam Clay's preconsolidation comes either from its material or from the initial stress."""
    for i, body in enumerate(model.bodies):
        found = model.initial.of(body.name)
        for name in dict.fromkeys(body.materials):
            material = model.materials.get(name)
            if not isinstance(material, ModifiedCamClay):
                continue
            given, rest = material.has_preconsolidation, None
            if found is not None and isinstance(found[1], AtRest):
                rest = at_rest_of(found[1], name)
            past = None if rest is None else rest.past
            if given and past is not None and found is not None and rest is not None:
                what = f"the material {name!r} has a preconsolidation of its own"
                remedy = "give it here or there, not in both places"
                where = f"{found[0]}{rest.of_past}.{rest.past_key}"
                yield Problem(where, what, remedy, past)
            elif not given and past is None:
                key = dotted(("materials", name, "overconsolidation_ratio"))
                remedy = (
                    "give exactly one of `overconsolidation_ratio` and `preconsolidation_pressure`,"
                    f' or an entry [[initial.stress]] of bodies[{i}] of type "k0" with '
                    "`overconsolidation_ratio` or `pre_overburden_pressure`"
                )
                yield Problem(key, "missing", remedy)
