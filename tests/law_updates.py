# SPDX-License-Identifier: BSD-3-Clause
"""Return mappings of laws at trial strains, in principal axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from small_problems import initial_state, parameters, start_strain

from tilth import _core
from tilth.arrays import Flags, Floats
from tilth.model.laws import laws

BULK = 1000.0 / (3 * (1 - 2 * 0.3))
SHEAR = 1000.0 / (2 * 1.3)


@dataclass
class Update:
    """Result of a return mapping in principal axes."""

    stress: Floats
    elastic: Floats
    tangent: Floats
    state: Floats


def updates(
    material: str, trial: Floats, plastic: Floats, before: Floats, **changed: Any
) -> tuple[Update, Flags]:
    """Return mappings of many trial strains (n, 3), and whether they succeeded."""
    n = len(trial)
    after = np.full((n, len(before)), np.nan)
    stress, elastic = np.full((n, 3), np.nan), np.full((n, 3), np.nan)
    tangent, good = np.full((n, 3, 3), np.nan), np.zeros(n, dtype=bool)
    _core.principal_update(
        material, parameters(material, **changed), np.ascontiguousarray(trial, dtype=float),
        np.column_stack([plastic, np.zeros(n)]), np.tile(before, (n, 1)), after, stress, elastic,
        tangent, good,
    )  # fmt: skip
    return Update(stress, elastic, tangent, after), good


def update(
    material: str,
    trial: Floats,
    plastic_strain: float = 0.0,
    state: Floats | None = None,
    **changed: Any,
) -> Update:
    before = initial_state(material, **changed) if state is None else state
    found, good = updates(
        material,
        np.asarray(trial, dtype=float)[None],
        np.array([plastic_strain]),
        before,
        **changed,
    )
    assert good.all()
    assert np.isfinite(found.state).all(), "a law fills all its state variables"
    return Update(found.stress[0], found.elastic[0], found.tangent[0], found.state[0])


def around_start(material: str, strain: Floats, **changed: Any) -> Floats:
    """Trial strain from the state at the start; Cam Clay's stresses double within one of 0.05."""
    scale = 1.0
    if "cam_clay" in material:  # with a Poisson's ratio its energy ends at a ratio of q to p
        scale = 0.02 if "poisson_ratio" in changed else 0.1
    return np.asarray(start_strain(material, **changed) + scale * np.asarray(strain))


def effective(material: str, found: Update) -> Floats:
    """Principal effective stress: the pore fluid dissipates nothing."""
    names = list(laws()[material].state_variables)
    if "excess_pore_pressure" not in names:
        return found.stress
    return np.asarray(found.stress + found.state[names.index("excess_pore_pressure")])


def deviator(a: Floats) -> Floats:
    return np.asarray(a - np.mean(a))
