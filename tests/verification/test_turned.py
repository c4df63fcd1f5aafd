# SPDX-License-Identifier: BSD-3-Clause
"""The case files `turned.toml` are the problems of `case.toml`, turned."""

import pytest

from tilth.analysis.simulation import Simulation
from tilth_verification.cases import example
from tilth_verification.turned import ANGLE, aligned, turned

PROBLEMS = ("end_loaded_cantilever", "collapse", "upsetting", "strip_footing")
OTHERWISE = ("title", "track", "output")


def leaves(entries, at=""):
    """Yields all values of nested entries with their dotted keys."""
    if isinstance(entries, dict | list | tuple):
        keyed = entries.items() if isinstance(entries, dict) else enumerate(entries)
        for key, value in keyed:
            yield from leaves(value, f"{at}.{key}")
    else:
        yield at, entries


@pytest.mark.parametrize("problem", PROBLEMS)
def test_case_file_is_the_turned_problem(problem):
    model = example(problem, "turned.toml")
    Simulation(model).check()
    found, exact = (
        dict(leaves({k: v for k, v in m.to_dict().items() if k not in OTHERWISE}))
        for m in (model, turned(aligned(problem), ANGLE))
    )
    assert found.keys() == exact.keys()
    for key, value in exact.items():
        near = isinstance(value, float)
        assert found[key] == (pytest.approx(value, rel=1e-12, abs=1e-12) if near else value), key
