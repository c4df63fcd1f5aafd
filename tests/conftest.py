# SPDX-License-Identifier: BSD-3-Clause
"""Settings of all tests; must come before the first import of tilth."""

import os
import signal
from collections.abc import Generator, Iterator
from typing import Any

import pytest

pytest_plugins = ["cost"]

os.environ.setdefault("OMP_WAIT_POLICY", "passive")  # idle threads leave the cores to others

for name in ("SIGINT", "SIGHUP"):  # ignored under `nohup` and in the background; tests send them
    number = getattr(signal, name, signal.SIGINT)
    if signal.getsignal(number) is signal.SIG_IGN:
        default = signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL
        signal.signal(number, default)

if (worker := os.environ.get("PYTEST_XDIST_WORKER")) and hasattr(os, "sched_setaffinity"):
    cores = sorted(os.sched_getaffinity(0))  # one for each worker: so one thread in each
    os.sched_setaffinity(0, {cores[int(worker.removeprefix("gw")) % len(cores)]})

FAST = "not slow and not long"
"""The marks of the tests that run by default: `addopts` in `pyproject.toml`."""
REST = f"""{os.linesep}This was the fast part. The others:
  pytest -m 'slow and not long'  about 10 minutes on two cores
  pytest -m long                 fine grids and long runs, hours"""

SHARING = {
    "tests/test_citations.py",
    "tests/test_manual.py",
    "tests/test_tutorial.py",
    "tests/unit/test_safety_stages.py",
    "tests/unit/test_stage_report.py",
    "tests/unit/test_stage_resume.py",
}
"""Files whose tests share what takes long, as a run: one process runs all of a file."""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Gives tests to processes one by one, those of a file in `SHARING` together."""
    from xdist.scheduler import LoadScopeScheduling

    class Scheduling(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.partition("::")[0]
            return file if file in SHARING else nodeid

    return Scheduling(config, log)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The fast part comes first: what is broken is then seen early."""
    items.sort(key=lambda item: item.get_closest_marker("slow") is not None)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_sessionfinish(session: pytest.Session) -> Generator[None, None, None]:
    """Says after pytest's summary how to run what was left out."""
    yield
    config = session.config
    option, reporter = config.option, config.pluginmanager.get_plugin("terminalreporter")
    if option.markexpr == FAST and not option.file_or_dir and reporter:
        reporter.write_line(REST)


@pytest.fixture
def every_loop_in_parallel() -> Iterator[None]:
    """All loops are threaded, however short; the number of threads is restored after the test."""
    from tilth import _core

    threads, points = _core.threads(), _core.parallel_from()
    _core.set_parallel_from(0)
    yield
    _core.set_threads(threads)
    _core.set_parallel_from(points)
