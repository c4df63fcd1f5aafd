# SPDX-License-Identifier: BSD-3-Clause
"""Do the tests notice mistakes? Applies each change of `tests/mutants/*.toml` and runs tests.

`python tests/mutants.py --help`; CONTRIBUTING.md says more. The working tree is never changed: the
tracked files are copied to `build/mutants/clean` and `build/mutants/changed`, and the second copy
gets one change after the other. Where the core changes, it is built in `build/mutants/core`.

A mutant is killed by a test that fails with the change and passes without it.
"""

from __future__ import annotations

import argparse
import fnmatch
import hashlib
import json
import os
import signal
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from mutant_list import ROOT, Mutant, mistakes, read_list
from mutant_workshop import PETSC, BuildFailed, Workshop

FAST = ("-m", "not slow and not long", "-n", "2")
"""Arguments of pytest for the fast part of the tests."""

LIVES_NEAR = "lives in the nearest tests"
"""What is told of a mutant that these do not kill where no others were run."""

FAST_LIMIT = 3600.0
"""Greatest processor time of the fast part, of each of its processes [s]."""


@dataclass(frozen=True)
class Outcome:
    """What became of a mutant.

    Attributes:
        name: of the mutant.
        result: killed, hangs, lives, lives in the nearest tests, or why it was not judged.
        by: the test that killed it.
        seconds: wall-clock time, with that of the build [s].
        change: what distinguishes it from an earlier mutant of the same name, see `mark_of`.
    """

    name: str
    result: str
    by: str
    seconds: float
    change: str

    @property
    def is_killed(self) -> bool:
        return self.result in ("killed", "hangs")

    @property
    def is_judged(self) -> bool:
        return self.is_killed or self.result.startswith("lives")


def mark_of(mutant: Mutant) -> str:
    """Returns a text of two words that change with what the mutant changes and with its tests."""
    texts = "\n".join([mutant.file, mutant.line, mutant.change]), "\n".join(mutant.tests)
    return " ".join(hashlib.sha256(each.encode()).hexdigest()[:12] for each in texts)


def is_known(before: Outcome | None, mutant: Mutant, nearest: bool) -> bool:
    """Returns whether an earlier outcome of a mutant still holds."""
    if before is None or not before.is_judged:
        return False
    now = mark_of(mutant)
    if before.is_killed:
        return before.change.split()[:1] == now.split()[:1]
    return before.change == now and (nearest or before.result != LIVES_NEAR)


def read_outcomes(file: Path) -> dict[str, Outcome]:
    """Returns the outcomes in a file, by the mutants' names; none if there is no file."""
    if not file.exists():
        return {}
    return {each["name"]: Outcome(**each) for each in json.loads(file.read_text(encoding="utf-8"))}


def write_outcomes(file: Path, outcomes: dict[str, Outcome]) -> None:
    """Writes outcomes to a file, at once."""
    text = json.dumps([asdict(each) for each in outcomes.values()], indent=1) + "\n"
    (temporary := file.with_name(file.name + ".part")).write_text(text, encoding="utf-8")
    temporary.replace(file)


def table(outcomes: Iterable[Outcome]) -> str:
    """Returns a table in Markdown, and the share of killed mutants."""
    outcomes = list(outcomes)
    rows = [
        f"| {each.name} | {each.result} | {each.by} | {each.seconds:.0f} |" for each in outcomes
    ]
    judged = [each for each in outcomes if each.is_judged]
    killed = sum(each.is_killed for each in judged)
    share = f" ({100.0 * killed / len(judged):.0f} %)" if judged else ""
    rest = f", {len(outcomes) - len(judged)} not run" if len(judged) < len(outcomes) else ""
    seconds = sum(each.seconds for each in outcomes)
    return "\n".join(
        [
            "| mutant | result | test | s |",
            "| --- | --- | --- | --- |",
            *rows,
            "",
            f"{killed} of {len(judged)} mutants killed{share}{rest}; {seconds:.0f} s",
        ]
    )


def in_order(tests: Sequence[str], known: str = "") -> list[tuple[str, ...]]:
    """Returns the arguments of each run of pytest: the known test, fast tests of files, others.

    Of a file the list means the fast tests, of a test that it names all cases.
    """
    own = [each for each in tests if PETSC in each]
    files = [each for each in tests if "::" not in each and each not in own]
    others = [each for each in tests if "::" in each and each not in own]
    groups = [("-m", "not long", known)] if "::" in known else []
    for marks, group in (("not slow and not long", files), ("not long", others), ("not long", own)):
        if group:
            groups.append(("-m", marks, *group))
    return groups


def judged(mutant: Mutant, workshop: Workshop, options: argparse.Namespace, known: str) -> Outcome:
    """Applies a mutant, runs tests and takes the change back; returns what became of it."""
    start = time.monotonic()

    def outcome(result: str, by: str = "") -> Outcome:
        return Outcome(mutant.name, result, by, round(time.monotonic() - start, 1), mark_of(mutant))

    if mutant.needs_processes and not workshop.has_processes:
        return outcome("not run: needs processes")
    groups = [(each, options.limit) for each in in_order(mutant.tests, known)]
    if not options.nearest:
        groups.append((FAST, FAST_LIMIT))
    try:
        with workshop.applied(mutant):
            for tests, limit in groups:
                excluded: list[str] = []
                while True:
                    found = workshop.first_failure(tests, limit, excluded)
                    if found.hangs:
                        usual = workshop.first_failure(tests, limit, excluded, clean=True)
                        return outcome("not judged: slow tests" if usual.hangs else "hangs")
                    if not found.failed:
                        break
                    if workshop.passes_without(found.failed):
                        return outcome("killed", found.failed)
                    excluded.append(found.failed)
            return outcome(LIVES_NEAR if options.nearest else "lives")
    except BuildFailed as error:
        return outcome(f"not built: {str(error).splitlines()[-1]}")


def chosen(mutants: list[Mutant], patterns: list[str]) -> list[Mutant]:
    """Returns the mutants whose name or file has one of the patterns; all without a pattern."""
    for pattern in patterns:
        if not any(_matches(each, pattern) for each in mutants):
            raise SystemExit(f"no mutant has the name or the file {pattern!r}; --list shows all")
    return [each for each in mutants if not patterns or any(_matches(each, p) for p in patterns)]


def _matches(mutant: Mutant, pattern: str) -> bool:
    return fnmatch.fnmatch(mutant.name, pattern) or fnmatch.fnmatch(mutant.file, pattern)


def parsed(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Applies each change of tests/mutants/*.toml to a copy and runs tests there."
    )
    add = parser.add_argument
    add("--list", action="store_true", help="show the mutants and end")
    add("--only", metavar="NAME", action="append", default=[],
        help="only these mutants: a name or a file, * for any text; may be repeated")  # fmt: skip
    add("--nearest", action="store_true", help="only the tests that the list names")
    add("--json", type=Path, default=ROOT / "build/mutants/outcomes.json", metavar="FILE",
        help="outcomes, written after each mutant (build/mutants/outcomes.json)")  # fmt: skip
    add("--resume", action="store_true", help="skip what --json has already, for the same change")
    add("--known", type=Path, metavar="FILE",
        help="outcomes of an earlier run: the test that killed a mutant comes first")  # fmt: skip
    add("--limit", type=float, default=300.0, metavar="SECONDS",
        help="processor time after which the nearest tests hang, and so kill (300)")  # fmt: skip
    add("--jobs", type=int, default=os.cpu_count() or 1, help="processes of the compiler")
    return parser.parse_args(arguments)


def main(arguments: list[str] | None = None) -> int:
    """Runs the command; returns 0 if no mutant lives, 1 otherwise."""
    options = parsed(arguments)
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))  # ends the tests
    mutants = read_list()
    if wrong := mistakes(mutants):
        raise SystemExit("\n".join(["tests/mutants does not fit the source:", *wrong]))
    mutants = chosen(mutants, options.only)
    if options.list:
        for each in mutants:
            print(f"{each.name}: {each.file}: {each.guards}")
        return 0
    earlier = read_outcomes(options.known) if options.known else {}
    outcomes = read_outcomes(options.json) if options.resume else {}
    with Workshop(options.jobs) as workshop:
        for number, mutant in enumerate(mutants, 1):
            if is_known(outcomes.get(mutant.name), mutant, options.nearest):
                continue
            known = earlier[mutant.name].by if mutant.name in earlier else ""
            found = judged(mutant, workshop, options, known)
            outcomes[mutant.name] = found
            write_outcomes(options.json, outcomes)
            print(f"{number}/{len(mutants)} {found.name}: {found.result} {found.by}",
                  file=sys.stderr, flush=True)  # fmt: skip
    found_all = [outcomes[each.name] for each in mutants]
    print(table(found_all))
    return 0 if all(each.is_killed for each in found_all) else 1


if __name__ == "__main__":
    sys.exit(main())
