# SPDX-License-Identifier: BSD-3-Clause
"""Rows of `tilth verify` that miss their tolerance (decision 18), each with a bound of its own.

The tolerances stay, and `tilth verify` says that these rows fail. Their errors may not grow.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from tilth_verification.run import Row

MARGIN = 1.1
"""Largest error over the measured one."""

LIST = "tests/verification/missed.py"


@dataclass(frozen=True)
class Missed:
    """A row that misses its tolerance.

    Attributes:
        problem: name of the reference problem.
        quantity: of the row; `*` stands for a number that is computed.
        error: measured with one thread, defined as in `Comparison`.
        short, long: whether `tilth verify` has the row without and with `--long`.
    """

    problem: str
    quantity: str
    error: float
    short: bool = True
    long: bool = True

    @property
    def bound(self) -> float:
        """The largest error that is accepted."""
        return MARGIN * self.error

    def means(self, problem: str, quantity: str) -> bool:
        """Whether it is the entry of this row."""
        before, star, after = self.quantity.partition("*")
        if not star:
            return (problem, quantity) == (self.problem, self.quantity)
        number = quantity.removeprefix(before).removesuffix(after)
        whole = f"{before}{number}{after}"
        return (problem, quantity) == (self.problem, whole) and _is_number(number)


def _short(problem: str, quantity: str, error: float) -> Missed:
    return Missed(problem, quantity, error, long=False)


def _long(problem: str, quantity: str, error: float) -> Missed:
    return Missed(problem, quantity, error, short=False)


TIP = "largest distance of the tip over the length"
OVER_HEIGHT = "RMS distance of the points over the height"
MOMENT = "its moment against the weight's, relative"
PEAK = "peak of the pressure at the centre, gimp"
DEEPEST = "deepest point behind the block's face"
APART = "force at * m, the farthest apart from 0.1 D on, rough"
ROUGHNESS = "RMS of the second difference of the force over its mean"

MISSED = (
    _long("end_loaded_cantilever", f"{TIP}, h 0.125 m, grid shifted by 0.37 cells", 3.57676e-4),
    _long("collapse", f"{OVER_HEIGHT}, h 0.5 m, turned by 45 degrees", 0.0167408),
    _long("collapse", "largest RMS distance of a turned copy, h 1 over 0.5 m", 0.403302),
    Missed("cube_on_inclined_plane", f"{MOMENT}, linear", 4.07621e-5),
    Missed("cube_on_inclined_plane", f"{MOMENT}, gimp", 1.70289e-5),
    _short("rigid_footing_elastic", f"{DEEPEST}, h 0.1 m, in cells", 0.151840),
    Missed("pressurised_ring", "its spread along the face, plane strain, 5 cells", 0.0110037),
    _short("rigid_sphere", f"{APART}, h D/8 and D/12", 0.202725),
    _long("rigid_sphere", f"{APART}, h D/8 and D/20", 0.200875),
    _long("rigid_sphere", f"{ROUGHNESS}, 3D, h D/10", 0.013),
    _long("spudcan_sand_over_clay", "drop of the resistance after its peak, h D/16", 0.00528552),
    _long("spudcan_sand_over_clay", "peak resistance, h D/8", 0.218243),
    _long("cone_penetration", f"{ROUGHNESS}, 3D", 0.0207119),
    _long("cryer", f"{PEAK}, h = a/15.9", 0.00404),
    _long("cryer", f"{PEAK}, h = a/16.6", 0.00420),
    _long("cone_penetration", "force at * m, the farthest apart, 3D and axisymmetric", 0.158933),
    Missed("undrained_limit", "fall of P from its peak to the end, friction, h 0.125 m", 0.0557929),
    _long("undrained_limit", "greatest P / s_u, friction, h 0.0625 m", 0.0487756),
    _long("undrained_limit", "fall of P from its peak to the end, friction, h 0.0625 m", 0.0736234),
    _long("undrained_limit", "difference of the greatest P / s_u, friction, h 0.0625 m", 0.303136),
)
"""In the order of the problems; decision 18 says why."""


def failures(problem: str, rows: Iterable[Row], missed: Iterable[Missed] = MISSED) -> list[str]:
    """Returns a sentence for each row that fails, is worse than listed, or passes though listed.

    rows: of one problem, all or some of them.
    """
    listed, found = tuple(missed), []
    for row in rows:
        c = row.comparison
        entry = next((each for each in listed if each.means(problem, c.quantity)), None)
        named = f"row {c.quantity!r} of problem {problem}"
        if entry is None:
            if not c.passed:
                found.append(
                    f"{named}: {c.computed:.6g}, not {c.reference:.6g} (error {c.error:.3g}, "
                    f"tolerance {c.tolerance:.3g}; {c.source})"
                )
        elif c.passed:
            found.append(
                f"{named} passes now (error {c.error:.3g}, tolerance {c.tolerance:.3g}): take it "
                f"from the list {LIST} and from the table of decision 18"
            )
        elif not c.error <= entry.bound:
            found.append(
                f"{named} misses its tolerance of {c.tolerance:.3g} by more than it did: error "
                f"{c.error:.3g}, {entry.bound:.3g} at most ({LIST})"
            )
    return found


def gone(
    problem: str, rows: Iterable[Row], *, long: bool, missed: Iterable[Missed] = MISSED
) -> list[str]:
    """Returns a sentence for each entry that no row has any more.

    None if an analysis has failed, after which there are no more rows.

    rows: all rows that `tilth verify` has of a problem. long: with `--long`.
    """
    quantities = [row.comparison.quantity for row in rows]
    if any(quantity.startswith("finished: ") for quantity in quantities):
        return []
    return [
        f"no row of problem {problem} is called {entry.quantity!r} any more: take it from the list "
        f"{LIST} and from the table of decision 18, or correct its name"
        for entry in missed
        if entry.problem == problem
        and (entry.long if long else entry.short)
        and not any(entry.means(problem, quantity) for quantity in quantities)
    ]


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
