# SPDX-License-Identifier: BSD-3-Clause
"""What a run leaves behind: results, history, log, checkpoint, and the progress bar."""

from .checkpoint import read_checkpoint, write_checkpoint
from .folder import prepare_output_folder
from .history import HistoryWriter, read_history
from .log import RunLog, read_log
from .progress import Progress
from .snapshot import Snapshot, SurfaceShape
from .surface_table import read_surface, write_surfaces
from .vtkhdf import Results, ResultsWriter, read_results

__all__ = [
    "HistoryWriter",
    "Progress",
    "Results",
    "ResultsWriter",
    "RunLog",
    "Snapshot",
    "SurfaceShape",
    "prepare_output_folder",
    "read_checkpoint",
    "read_history",
    "read_log",
    "read_results",
    "read_surface",
    "write_checkpoint",
    "write_surfaces",
]
