# SPDX-License-Identifier: BSD-3-Clause
"""What several processes compute together, and what only one process computes so far."""

from __future__ import annotations

from collections.abc import Iterator

from tilth.errors import BadInput, Problem
from tilth.model import ImplicitBoundary, Model

REMEDY = "run it in one process, without mpiexec (--threads uses the cores of one machine)"


def require_distributed(model: Model) -> None:
    """Checks that several processes can compute a model.

    Raises:
        BadInput: it has something that they cannot.
    """
    found = list(_not_distributed(model))
    if found:
        raise BadInput.of(found)


def _not_distributed(model: Model) -> Iterator[Problem]:
    """What of a model one process alone computes."""

    def problem(key: str, what: str) -> Problem:
        return Problem(key, f"{what} by several processes together", REMEDY)

    for number, boundary in enumerate(model.boundaries):
        key = f"boundaries[{number}]"
        if isinstance(boundary, ImplicitBoundary) and boundary.contact is not None:
            yield problem(f"{key}.contact", "contact is not computed")
    if model.rigid_bodies:
        yield problem("rigid_bodies", "rigid bodies are not computed")
    if model.contact_pairs:
        yield problem("contact_pairs", "contact between bodies is not computed")
