# SPDX-License-Identifier: BSD-3-Clause
"""The case files of the examples, found by glob: analyses and element tests."""

from pathlib import Path

EXAMPLES = Path(__file__).parents[1] / "examples"
ALL = sorted(EXAMPLES.glob("*/*.toml"))
ELEMENT_TESTS = [case for case in ALL if "[[tests]]" in case.read_text(encoding="utf-8")]
ANALYSES = [case for case in ALL if case not in ELEMENT_TESTS]
