# SPDX-License-Identifier: BSD-3-Clause
"""The command `python -m tests.metamorphic`: runs the models and tells what fails, by cause."""

from __future__ import annotations

import argparse
import re
import sys
import time
import traceback
from collections import Counter, defaultdict
from pathlib import Path

from fuzz.toml_text import toml_text

from metamorphic.build import entries_of
from metamorphic.choices import PLAIN, Choice
from metamorphic.covering import Covering
from metamorphic.known import is_known
from metamorphic.models import Tree
from metamorphic.processes import processes
from metamorphic.relations import faults
from metamorphic.smaller import smaller
from metamorphic.subject import Subject
from tilth import Model
from tilth.errors import BadInput


def _arguments(given: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.metamorphic", description=__doc__)
    add = parser.add_argument
    add("--seed", type=int, default=1, help="of the models (default 1)")
    add("--models", type=int, default=300, help="number of models (default 300)")
    add("--smaller", action="store_true", help="the fewest lines of each kind of fault")
    add("--pairs", action="store_true", help="all pairs of values that were left out, and why")
    add("--replay", metavar="NAME", help="one model again, such as 1-17")
    add("--processes", action="store_true", help="runs of two and three processes, too")
    add("--keep", type=Path, default=Path("metamorphic_failures"), help="folder of failures")
    return parser.parse_args(given)


def main(given: list[str] | None = None) -> int:
    """Runs what the arguments ask for; returns 1 if a fault was found."""
    options = _arguments(given)
    start = time.process_time()
    covering = Covering(options.seed, refused)
    causes: dict[str, list[str]] = defaultdict(list)
    codes: Counter[int] = Counter()
    count = 0
    for name, choice in covering.choices(options.models):
        if options.replay and name != options.replay:
            continue
        count += 1
        if count % 100 == 0:
            print(f"{count} models after {time.process_time() - start:.0f} s", file=sys.stderr)
        subject = Subject(entries_of(choice, name), choice, name)
        found = [
            text for text in found_faults(subject, options.processes) if not is_known(choice, text)
        ]
        codes[subject.run.exit_code] += 1
        for fault in found:
            causes[cause_of(fault)].append(name)
        if found:
            text = toml_text({"format": 1, **subject.entries})
            if options.smaller and len(causes[cause_of(found[0])]) == 1:
                text = reduced(subject, cause_of(found[0]))
            _keep(options.keep / f"{name}.toml", choice, found, text)
        if found or options.replay:
            print(name, *(fault[:300] for fault in found), _short(choice), sep="\n  ", flush=True)
    _tell(covering, causes, codes, options.pairs)
    print(f"{count} models, {time.process_time() - start:.0f} s of processor time, ", end="")
    print(f"{len(causes)} kinds of faults")
    return 1 if causes else 0


def refused(choice: Choice, name: str) -> str:
    """The message with which the model of a choice is refused as it is declared."""
    try:
        Model.from_dict(entries_of(choice, name))
    except BadInput as error:
        return error.message
    return ""


def found_faults(subject: Subject, several: bool = False) -> list[str]:
    """All faults of a model; an exception that is none of tilth's is one.

    several: whether several processes compute it, too.
    """
    try:
        found = faults(subject)
        if several and subject.run.exit_code == 0:
            found += [f"processes: {text}" for text in processes(subject)]
        return found
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        return [f"exception: {type(error).__name__}: {error} in {place.filename}:{place.name}"]


def cause_of(fault: str) -> str:
    """A fault without its numbers."""
    return re.sub(r"[-+]?[0-9][0-9.e+-]*", "#", fault)[:120]


def reduced(subject: Subject, cause: str) -> str:
    """The fewest lines of a model that have a fault of the same cause."""

    def fails(entries: Tree) -> bool:
        try:
            other = Subject(entries, subject.choice, subject.seed)
            return cause in map(cause_of, found_faults(other))
        except Exception:
            return False

    return smaller(subject.entries, fails)


def _short(choice: Choice) -> str:
    return ", ".join(f"{k} {v}" for k, v in choice.items() if v != PLAIN[k])


def _keep(file: Path, choice: Choice, found: list[str], text: str) -> None:
    """Saves a model that fails."""
    file.parent.mkdir(parents=True, exist_ok=True)
    lines = [f"# {line}" for fault in [*found, _short(choice)] for line in fault.splitlines()]
    file.write_text("\n".join([*lines, text]), encoding="utf-8")


def _tell(
    covering: Covering, causes: dict[str, list[str]], codes: Counter[int], pairs: bool
) -> None:
    for code, number in sorted(codes.items()):
        print(f"{number:6d} models end with exit code {code}")
    for cause in sorted(causes, key=lambda cause: -len(causes[cause])):
        print(f"{len(causes[cause])} x {cause}\n    {' '.join(causes[cause][:8])}")
    print(f"{len(covering.missing)} pairs of values did not occur; {len(covering.left_out)} cannot")
    if pairs:
        for ((one, value), (other, second)), message in covering.left_out.items():
            print(f"  {one} {value}, {other} {second}: {message}")
