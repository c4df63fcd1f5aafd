# SPDX-License-Identifier: BSD-3-Clause
"""The law of contact between soil and a boundary or a rigid body."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import PlainValidator, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.fields import NotNegative, Positive, real
from tilth.model.problems import reject, rejection


def _friction(value: Any) -> float:
    if (number := real(value)) >= 0.0:
        return number
    what = "must not be negative: friction resists sliding"
    raise reject(what, "give the tangent of the angle of friction, such as 0.3, or 0 for none")


def _adhesion_factor(value: Any) -> float:
    if 0.0 <= (number := real(value)) <= 1.0:
        return number
    remedy = "give the share of the cohesion, such as 0.5, or a `shear_limit` [stress]"
    raise reject("must be between 0 and 1", remedy)


FrictionCoefficient = Annotated[float, PlainValidator(_friction)]
AdhesionFactor = Annotated[float, PlainValidator(_adhesion_factor)]

_LIMITS = ("adhesion_factor", "shear_limit")
_KEYS: dict[str, tuple[str, ...]] = {
    "smooth": (),
    "friction": ("friction", *_LIMITS),
    "adhesion": _LIMITS,
    "rough": (),
    "bonded": (),
}
"""The keys that each kind of `tangential` has."""


class Contact(Declared):
    """Law of contact between soil and a boundary or a rigid body, normal to it and along it.

    The pressure p is positive in compression. Where the soil has separated there is no stress.
    """

    normal: Literal["unilateral", "bilateral"]
    """Whether the soil can separate: "unilateral" (it opens under tension) or "bilateral" (it never
    opens: suction holds it).
    """
    tensile_strength: Positive | None = None
    """With normal = "unilateral": tension at which the contact opens [stress], > 0; it bears none
    if not given.
    """
    tangential: Literal["smooth", "friction", "adhesion", "rough", "bonded"]
    """Shear resistance r against sliding: "smooth" (none), "friction" (r = `friction` p, up to a
    limit), "adhesion" (r = the limit, whatever p), "rough" (the soil's own shear strength, r = c +
    p tan(phi), s_u of undrained clay) or "bonded" (no sliding at all). Friction of soil in which
    water flows is that of p less the excess pore pressure.
    """
    friction: FrictionCoefficient | None = None
    """With "friction", required: the coefficient mu = tan(angle) [-], >= 0."""
    adhesion_factor: AdhesionFactor | None = None
    """With "friction" or "adhesion": the limit of r is this share [-], 0 to 1, of the soil's
    cohesion c, that is of s_u in undrained clay.
    """
    shear_limit: NotNegative | None = None
    """Instead of `adhesion_factor`: the limit of r [stress], >= 0."""

    @model_validator(mode="after")
    def _keys_fit_the_law(self) -> Any:
        if problems := [*self._problems()]:
            raise rejection(problems)
        return self

    @property
    def needs_strength(self) -> bool:
        """Whether it takes the shear strength of the soil, so that the soil must have one."""
        return self.tangential == "rough" or self.adhesion_factor is not None

    def _problems(self) -> Iterator[Problem]:
        law = f'tangential = "{self.tangential}"'
        if self.normal == "bilateral" and self.tensile_strength is not None:
            what = 'has no meaning with normal = "bilateral", which never opens'
            remedy = 'leave it out, or choose normal = "unilateral"'
            yield Problem("tensile_strength", what, remedy, self.tensile_strength)
        for key in ("friction", *_LIMITS):
            value = getattr(self, key)
            if value is not None and key not in _KEYS[self.tangential]:
                fitting = " or ".join(f'"{kind}"' for kind, keys in _KEYS.items() if key in keys)
                remedy = f"leave it out, or choose tangential = {fitting}"
                yield Problem(key, f"has no meaning with {law}", remedy, value)
        if self.tangential == "friction" and self.friction is None:
            remedy = "give the coefficient of friction [-], such as friction = 0.3"
            yield Problem("friction", "missing", remedy)
        given = [key for key in _LIMITS if getattr(self, key) is not None]
        if self.tangential == "adhesion" and not given:
            remedy = "give `adhesion_factor` (share of the soil's cohesion) or `shear_limit`"
            yield Problem("adhesion_factor", "missing", remedy)
        if len(given) == 2 and "shear_limit" in _KEYS[self.tangential]:
            what = "given together with `adhesion_factor`, and both are the limit of the shear"
            yield Problem("shear_limit", what, "leave one of them out", self.shear_limit)
