# SPDX-License-Identifier: BSD-3-Clause
"""tilth: implicit material point method for geotechnics.

The public names are loaded when they are first used, so that `tilth --version` is instant.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from tilth.analysis.check import check as check
    from tilth.analysis.run import resume as resume
    from tilth.analysis.run import run as run
    from tilth.analysis.safety_run import safety as safety
    from tilth.analysis.stepwise import steps as steps
    from tilth.case import load_case as load_case
    from tilth.case import load_element_case as load_element_case
    from tilth.case import load_study as load_study
    from tilth.element_tests.run import element as element
    from tilth.errors import AnalysisFailed as AnalysisFailed
    from tilth.errors import BadInput as BadInput
    from tilth.errors import Interrupted as Interrupted
    from tilth.errors import TilthError as TilthError
    from tilth.model import *  # noqa: F403 - all that can be declared
    from tilth.results.run_results import open as open
    from tilth.studies.run import study as study

_HOME = {
    "check": "tilth.analysis.check",
    **dict.fromkeys(("resume", "run"), "tilth.analysis.run"),
    "safety": "tilth.analysis.safety_run",
    "steps": "tilth.analysis.stepwise",
    "element": "tilth.element_tests.run",
    "open": "tilth.results.run_results",
    "study": "tilth.studies.run",
    **dict.fromkeys(("load_case", "load_element_case", "load_study"), "tilth.case"),
    **dict.fromkeys(("AnalysisFailed", "BadInput", "Interrupted", "TilthError"), "tilth.errors"),
}
"""Where the public names are that are no declarations; those are all classes of `tilth.model`."""


if not TYPE_CHECKING:  # type checkers refuse a name that is not above

    def __getattr__(name: str) -> Any:
        if name in _HOME:
            return getattr(importlib.import_module(_HOME[name]), name)
        if name == "__all__":
            return _public_names()
        if not name.startswith("_") and name in (declared := _declarations()):
            return declared[name]
        raise AttributeError(f"module 'tilth' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_public_names()})


def _public_names() -> list[str]:
    return sorted({*_HOME, *_declarations()})


def _declarations() -> dict[str, type]:
    """Returns the classes that `tilth.model` offers, by name."""
    names = vars(importlib.import_module("tilth.model"))
    return {name: entry for name, entry in names.items() if isinstance(entry, type)}
