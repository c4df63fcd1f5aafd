# SPDX-License-Identifier: BSD-3-Clause
"""Set-ups and snapshots to draw."""

from __future__ import annotations

import numpy as np

from tilth.output import Snapshot
from tilth.report.setup import Condition, Load, Setup

UNITS = {"length": "m", "force": "kN", "stress": "kPa", "mass": "t", "time": "d"}


def lattice(counts: tuple[int, ...], spacing: float) -> np.ndarray:
    axes = [spacing * (np.arange(count) + 0.5) for count in counts]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(counts))


def make_setup(counts: tuple[int, ...], spacing: float = 0.5) -> Setup:
    dim = len(counts)
    position = lattice(counts, spacing)
    corners = np.zeros((3, dim))
    corners[:, 0] = [0.0, spacing, 2 * spacing]
    constrained = np.zeros((3, dim), dtype=bool)
    constrained[:, -1] = True
    push = np.zeros((3, dim))
    push[:, -1] = -0.2
    force = np.zeros((1, dim))
    force[0, 0] = 7.0
    return Setup(
        title="Test set-up",
        dim=dim,
        length_unit="m",
        position=position,
        half_lengths=np.full_like(position, spacing / 2),
        body_id=np.zeros(len(position), dtype=np.int64),
        body_names=["clay"],
        cell_size=np.full(dim, 2 * spacing),
        origin=np.zeros(dim),
        conditions=[
            Condition("base", "roller", corners, constrained),
            Condition("corner", "fixed", corners[:1], np.ones((1, dim), dtype=bool)),
            Condition("plate", "prescribed", corners + 1.0, constrained, push),
        ],
        loads=[Load("pull", position[-1:], force)],
        body_force=np.eye(dim)[-1] * -9.81,
        force_unit="kN",
    )


def snapshot(dim: int = 2, step: int = 1) -> Snapshot:
    position = lattice((6, 4, 3)[:dim], 1.0)
    n = len(position)
    stress = np.zeros((n, 6))
    stress[:, 1] = -10.0 * step * (1.0 + position[:, 1])
    stress[:, 3] = 3.0 * step * (position[:, 0] - 3.0)
    displacement = 0.1 * step * position
    return Snapshot(
        step=step,
        time=0.25 * step,
        position=position + displacement,
        point_id=np.arange(n),
        body_id=np.zeros(n, dtype=np.int64),
        point_fields={
            "displacement": displacement,
            "cauchy_stress": stress,
            "plastic_strain": np.zeros(n),
            "volume": np.ones(n),
            "domain": np.full((n, dim), 0.5),
            "deformation_gradient": np.tile(1.1 * np.eye(3), (n, 1, 1)),
        },
        node_position=np.zeros((0, dim)),
        cells=np.zeros((0, 2**dim), dtype=np.int64),
        node_fields={"displacement": np.zeros((0, dim)), "reaction": np.zeros((0, dim))},
    )
