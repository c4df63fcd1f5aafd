# SPDX-License-Identifier: BSD-3-Clause
"""Figures of a set-up and of results, and the page ``report.html``."""

from tilth.report.field_plots import draw_frames
from tilth.report.html import write_report
from tilth.report.setup import Condition, Load, Setup, draw_setup

__all__ = ["Condition", "Load", "Setup", "draw_frames", "draw_setup", "write_report"]
