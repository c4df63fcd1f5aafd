# SPDX-License-Identifier: BSD-3-Clause
"""The public names and their signatures are those of a list: a change of them is on purpose."""

import difflib
import inspect
import os
import re
from pathlib import Path

import tilth
from tilth.cli import COMMANDS
from tilth.model.base import Declared

LIST = Path(__file__).with_name("public_api.txt")
ACCEPT = "TILTH_ACCEPT_API=1 python -m pytest tests/unit/test_public_api.py"


def public_api() -> str:
    """A line for each name: functions with their signatures, declarations with their keys."""
    lines = [f"command {name}" for name in COMMANDS]
    for name in sorted(tilth.__all__):
        entry = getattr(tilth, name)
        if inspect.isclass(entry) and issubclass(entry, Declared):
            keys = [
                (field.alias or key) + ("" if field.is_required() else " (optional)")
                for key, field in entry.model_fields.items()
            ]
            lines.append(f"declaration {name}: {', '.join(keys)}")
        elif inspect.isclass(entry):
            lines.append(f"class {name}{inspect.signature(entry)}")
        else:
            lines.append(f"function {name}{inspect.signature(entry)}")
    addresses = r" at 0x[0-9a-f]+"  # of functions that are default values
    return re.sub(addresses, "", "\n".join(lines)) + "\n"


def test_the_public_api_is_that_of_the_list() -> None:
    now = public_api()
    if os.environ.get("TILTH_ACCEPT_API"):
        LIST.write_text(now, encoding="utf-8")
    listed = LIST.read_text(encoding="utf-8")
    changes = [
        line
        for line in difflib.unified_diff(listed.splitlines(), now.splitlines(), n=0, lineterm="")
        if line[:1] in "+-" and not line.startswith(("---", "+++"))
    ]
    assert not changes, (
        "the public names changed:\n  "
        + "\n  ".join(changes)
        + f"\nif that is meant (CONTRIBUTING.md, 'Public names'), accept it with\n  {ACCEPT}"
    )
