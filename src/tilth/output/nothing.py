# SPDX-License-Identifier: BSD-3-Clause
"""What stands for a file in a process that writes none."""

from __future__ import annotations

from typing import Any


class Nothing:
    """Takes every call and does nothing."""

    def __getattr__(self, name: str) -> Any:
        return lambda *arguments, **named: None
