# SPDX-License-Identifier: BSD-3-Clause
"""What the tests cost in processor time: measured in every run, compared with `tests/budget.toml`.

A plugin of pytest, loaded by `conftest.py`. Each test's time is that of its process and of the
programs that it started and that have ended, preparation and clean-up included. Something that
several tests share counts for the first of them.

    pytest --cost FILE     writes it down: node id of each test -> processor seconds
    pytest --budget FILE   prints the sums by what the tests guard, and fails above a budget
    pytest --budget FILE --spent FILE
                           the same with what `.ci/run` has spent before: lines of bash's `times`
    python tests/cost.py FILE [FILE ...] [--tests N]
                           prints tables of such costs: parts, test files, the N longest tests
"""

from __future__ import annotations

import argparse
import fnmatch
import json
import resource
import sys
from collections import Counter
from collections.abc import Generator, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

BUDGET = Path(__file__).with_name("budget.toml")
TOLERATED = 1.5
"""Processor time of a part over its budget that fails, on a machine of the pace of the budgets."""
WORKERS = "starting pytest, finding tests"
_charged = 0.0
START = pytest.StashKey[float]()
COSTS = pytest.StashKey["Costs"]()


@dataclass(frozen=True)
class Part:
    """Some tests by what they guard, or another part of `.ci/run` (without files).

    Attributes:
        name: what is guarded.
        seconds: of processor time that it may take, on the machine that `budget.toml` names.
        files: patterns of test files; a file belongs to the first part with a pattern of it.
        pace: whether its time tells how fast a machine is: it runs the programs of others.
    """

    name: str
    seconds: float
    files: tuple[str, ...] = ()
    pace: bool = False

    def has(self, node: str) -> bool:
        """Whether a test belongs to this part, unless to one before."""
        file = node.partition("::")[0]
        return any(fnmatch.fnmatchcase(file, pattern) for pattern in self.files)


def parts(file: str | Path = BUDGET) -> list[Part]:
    """The parts with their budgets."""
    entries = tomllib.loads(Path(file).read_text(encoding="utf-8"))["part"]
    return [Part(**{**each, "files": tuple(each.get("files", ()))}) for each in entries]


def sums(costs: Mapping[str, float], budget: Iterable[Part]) -> dict[str, float]:
    """Processor seconds by part of the budget; the name of a part that is not there stays."""
    found: Counter[str] = Counter()
    budget = list(budget)
    for node, seconds in costs.items():
        found[next((part.name for part in budget if part.has(node)), node)] += seconds
    return dict(found)


def spent_before(file: str | Path) -> dict[str, float]:
    """Processor seconds of parts of `.ci/run`, from what bash's `times` said after each of them.

    A line has the part's name and, after a tab, the user's and the system's time of all programs
    until then: "installation\t2m3.5s 0m4.1s".
    """
    found, before = {}, 0.0
    for line in Path(file).read_text(encoding="utf-8").splitlines():
        name, _, times = line.partition("\t")
        pairs = (each.rstrip("s").split("m") for each in times.split())
        now = sum(60.0 * float(minutes) + float(seconds) for minutes, seconds in pairs)
        found[name], before = now - before, now
    return found


def slowness(spent: Mapping[str, float], budget: Iterable[Part]) -> float:
    """How many times as long as on the machine of the budgets a program takes here; at least 1.

    By the parts whose time tells the pace of a machine; 1 if none of them ran.
    """
    measures = [part for part in budget if part.pace and part.name in spent]
    planned = sum(part.seconds for part in measures)
    return max(1.0, sum(spent[part.name] for part in measures) / planned) if planned else 1.0


def verdicts(spent: Mapping[str, float], budget: Iterable[Part]) -> list[str]:
    """A sentence for each part above its budget by more than a half, and for what has none.

    On a slower machine the budgets are longer. The parts that tell its pace are not judged.
    """
    budget = list(budget)
    slow = slowness(spent, budget)
    named = {part.name: part for part in budget}
    said = []
    for name, seconds in spent.items():
        if name not in named:
            said.append(f"{name}: no part of the budget has it; add a pattern of its file")
        elif not named[name].pace and seconds > TOLERATED * slow * named[name].seconds:
            said.append(
                f"{name}: {seconds:.0f} s of processor time, {slow * named[name].seconds:.0f} s are"
                " planned on this machine and half as much again is tolerated; make its tests"
                " shorter, mark them `long`, or raise the budget in tests/budget.toml and say why"
            )
    return said


def table(spent: Mapping[str, float], budget: Iterable[Part]) -> str:
    """The parts that took time, with their budgets and the sum [processor seconds]."""
    budget = list(budget)
    slow = slowness(spent, budget)
    rows = [(part.name, spent[part.name], part.seconds) for part in budget if part.name in spent]
    rows.append(("sum", sum(row[1] for row in rows), sum(row[2] for row in rows)))
    lines = [f"{'processor seconds':<40}{'spent':>8}{'budget':>8}"]
    lines += [f"{name:<40}{a:8.0f}{b:8.0f}" for name, a, b in rows]
    return "\n".join([*lines, f"this machine takes {slow:.2f} times as long as that of the budget"])


def processor_time() -> float:
    """Processor seconds of this process, of its children that have ended, and what was charged."""
    used = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(each.ru_utime + each.ru_stime for each in used) + _charged


def charge(seconds: float) -> None:
    """Adds processor seconds of children that have not ended to the test that is running."""
    global _charged
    _charged += seconds


class Costs:
    """The costs of a run, gathered in the process that prints the results.

    Attributes:
        of_tests: node id -> processor seconds.
        of_workers: processor seconds of the processes that run tests, as far as they report.
        spent: processor seconds by part, once all tests have ended and if there is a budget.
        failures: sentences on exceeded budgets.
    """

    def __init__(self) -> None:
        self.of_tests: dict[str, float] = {}
        self.of_workers = 0.0
        self.spent: dict[str, float] = {}
        self.failures: list[str] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Takes the cost of a test that has ended."""
        if (seconds := getattr(report, "processor_seconds", None)) is not None:
            self.of_tests[report.nodeid] = seconds

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """Takes the cost of a process that has run its tests."""
        self.of_workers += getattr(node, "workeroutput", {}).get("processor_seconds", 0.0)

    def by_part(self, config: pytest.Config) -> dict[str, float]:
        """Processor seconds by part: those before the tests, those of tests, and of no test."""
        before = config.getoption("--spent")
        tests = sums(self.of_tests, parts(config.getoption("--budget")))
        rest = (self.of_workers or processor_time()) - sum(tests.values())
        return (spent_before(before) if before else {}) | {WORKERS: max(0.0, rest)} | tests


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("cost", "processor time")
    group.addoption("--cost", metavar="FILE", help="write the processor seconds of each test")
    group.addoption("--budget", metavar="FILE", help="fail above the budgets of a file")
    group.addoption("--spent", metavar="FILE", help="times of the parts before, for --budget")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[COSTS] = costs = Costs()
    config.pluginmanager.register(costs, "costs")


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, bool, bool]:
    item.stash[START] = processor_time()
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    if call.when == "teardown":
        report.processor_seconds = round(processor_time() - item.stash[START], 4)
    return report


@pytest.hookimpl(tryfirst=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    config = session.config
    if hasattr(config, "workeroutput"):
        config.workeroutput["processor_seconds"] = processor_time()
        return
    costs = config.stash[COSTS]
    if file := config.getoption("--cost"):
        Path(file).write_text(json.dumps(costs.of_tests, indent=0), encoding="utf-8")
    if budget := config.getoption("--budget"):
        costs.spent = costs.by_part(config)
        costs.failures = verdicts(costs.spent, parts(budget))
        if costs.failures and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    if budget := config.getoption("--budget"):
        costs = config.stash[COSTS]
        terminalreporter.write_sep("=", "processor time")
        terminalreporter.write_line(table(costs.spent, parts(budget)))
        for sentence in costs.failures:
            terminalreporter.write_line(f"above its budget: {sentence}", red=True)


def main() -> None:
    parser = argparse.ArgumentParser(description="Tables of what the tests cost.")
    parser.add_argument("files", nargs="+", type=Path, help="written by `pytest --cost FILE`")
    parser.add_argument("--tests", type=int, default=40, help="how many of the longest tests")
    given = parser.parse_args()
    costs: dict[str, float] = {}
    for file in given.files:
        costs |= json.loads(file.read_text(encoding="utf-8"))
    print(table(sums(costs, parts()), parts()))
    files: Counter[str] = Counter()
    number = Counter(node.partition("::")[0] for node in costs)
    for node, seconds in costs.items():
        files[node.partition("::")[0]] += seconds
    print(f"\n{'seconds':>8}{'tests':>7}  test file")
    for name, seconds in files.most_common():
        print(f"{seconds:8.1f}{number[name]:7}  {name}")
    print(f"\n{'seconds':>8}  longest tests")
    for node, seconds in Counter(costs).most_common(given.tests):
        print(f"{seconds:8.2f}  {node}")


if __name__ == "__main__":
    main()
