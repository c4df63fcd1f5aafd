# SPDX-License-Identifier: BSD-3-Clause
"""Faults that are known and not yet mended: what they look like, and why they are left."""

from __future__ import annotations

from dataclasses import dataclass

from metamorphic.choices import Choice


@dataclass(frozen=True)
class KnownFault:
    """A fault that is not reported.

    Attributes:
        reason: why it is there.
        text: part of what is reported.
        values: of the choices that have it; any if there are none.
    """

    reason: str
    text: str = ""
    values: tuple[tuple[str, tuple[str, ...]], ...] = ()

    def is_this(self, choice: Choice, fault: str) -> bool:
        """Whether a fault of a choice's model is this one."""
        return self.text in fault and all(choice[name] in some for name, some in self.values)


KNOWN = (
    KnownFault(
        "energy radiated in a few steps is far too high, and falls with their number",
        "balance: energy",
        (("base", ("absorbing", "absorbing_implicit")),),
    ),
    KnownFault(
        "the fields of unpaired bodies follow their order; the message says how to list them",
        "they would pass through eac",
        (("relation", ("order",)),),
    ),
)  # fmt: skip


def is_known(choice: Choice, fault: str) -> bool:
    return any(known.is_this(choice, fault) for known in KNOWN)
