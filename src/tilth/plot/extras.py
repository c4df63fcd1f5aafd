# SPDX-License-Identifier: BSD-3-Clause
"""Packages that only some users need, imported when they are asked for."""

from __future__ import annotations

import importlib
from typing import Any

from tilth.errors import BadInput


def require_extra(name: str, extra: str = "") -> Any:
    """Returns the package of an optional extra of tilth, which has the same name if not given.

    Raises ``BadInput`` that names the extra if the package is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise BadInput(
            f"the package {name} is needed, and cannot be imported: {error}",
            f'install it with: pip install "tilth[{extra or name}]" (or: pip install {name})',
        ) from error
