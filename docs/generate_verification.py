# SPDX-License-Identifier: BSD-3-Clause
"""Writes docs/verification.md: `python docs/generate_verification.py [FILE.json]...`.

The files are the output of `tilth verify [NAME]... --json` with one thread; `--processes N` says
that it was computed by N processes (`mpiexec -n N tilth verify ...`). Their problems replace those
in docs/verification.json, from which the page is written; problems that are in no file stay as they
are.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from tilth_verification.problems import PROBLEMS

PAGE = Path(__file__).parent / "verification.md"
STORED = Path(__file__).parent / "verification.json"
SHOWN = ("computed", "reference", "error", "tolerance")
KEPT = ("problem", "quantity", "unit", *SHOWN, "passed", "source")

INTRODUCTION = """\
# Verification

What `tilth verify` found: computed value, reference, error and tolerance of every comparison.
`tilth verify NAME` computes a problem again. The values were computed by one process with one
thread, or by as many processes as are named. An error is a share of the reference, a difference in
the quantity's unit, or a factor, as `src/tilth_verification` defines it for each problem. Rows
marked **missed** are out of their tolerance, which was not widened to fit. More about them:
[boundaries inside cells](decisions/0018-multiplier-space.md), the
[rigid sphere](../examples/rigid_sphere/README.md#numbers). The page is written by
`docs/generate_verification.py`.
"""


def merged(
    stored: list[dict[str, Any]], new: list[dict[str, Any]], processes: int = 1
) -> list[dict[str, Any]]:
    """Returns the rows of both in the order of the problems; new problems replace stored ones.

    The new ones were computed by this number of processes.

    Raises ValueError for a problem that there is not.
    """
    for row in new:
        if row["problem"] not in PROBLEMS:
            raise ValueError(f"{row['problem']}: no such problem")
    replaced = {row["problem"] for row in new}
    kept = [row for row in stored if row["problem"] not in replaced]
    order = {name: place for place, name in enumerate(PROBLEMS)}
    more = {"processes": processes} if processes > 1 else {}
    rows = [*kept, *({key: row[key] for key in KEPT} | more for row in new)]
    return sorted(rows, key=lambda row: order[row["problem"]])


def table(rows: list[dict[str, Any]]) -> list[str]:
    """Returns the lines of a table of comparisons."""
    lines = ["| quantity | computed | reference | error | tolerance | source |"]
    lines.append("| --- | --- | --- | --- | --- | --- |")
    for row in rows:
        quantity = row["quantity"] + (f" [{row['unit']}]" if row["unit"] else "")
        texts = [text.replace("|", "\\|").replace("*", "\\*") for text in (quantity, row["source"])]
        numbers = ["none" if row[key] is None else f"{row[key]:.4g}" for key in SHOWN]
        if not row["passed"]:
            numbers[-1] += ", **missed**"
        lines.append("| " + " | ".join([texts[0], *numbers, texts[1]]) + " |")
    return lines


def page(rows: list[dict[str, Any]]) -> str:
    """Returns the page for some rows."""
    lines = [INTRODUCTION]
    present = {row["problem"] for row in rows}
    missing = [f"[{name}](../examples/{name})" for name in PROBLEMS if name not in present]
    if missing:
        lines.append(f"Not on this page, since they take long: {', '.join(missing)}.\n")
    for name in PROBLEMS:
        if name in present:
            own = [row for row in rows if row["problem"] == name]
            processes = own[0].get("processes", 1)
            more = f", computed by {processes} processes" if processes > 1 else ""
            lines += [f"## {name}\n", f"[Example](../examples/{name}){more}\n", *table(own), ""]
    return "\n".join(lines)


def main() -> None:
    """Merges the files into the stored rows, and writes both."""
    parser = argparse.ArgumentParser()
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args()
    stored = json.loads(STORED.read_text(encoding="utf-8")) if STORED.is_file() else []
    new = [row for file in given.files for row in json.loads(file.read_text(encoding="utf-8"))]
    rows = merged(stored, new, given.processes)
    STORED.write_text("[\n" + ",\n".join(map(json.dumps, rows)) + "\n]\n", encoding="utf-8")
    PAGE.write_text(page(rows), encoding="utf-8")


if __name__ == "__main__":
    main()
