# SPDX-License-Identifier: BSD-3-Clause
"""Verification: reference problems, and the closed forms and data that they are compared with."""

from tilth_verification.run import run_verification

__all__ = ["run_verification"]
