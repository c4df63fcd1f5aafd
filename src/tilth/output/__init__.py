# SPDX-License-Identifier: BSD-3-Clause
"""Output of a run: results, history, log, checkpoint, and the progress bar."""

from tilth.output.checkpoint import read_checkpoint, write_checkpoint
from tilth.output.checkpoint_thread import CheckpointThread
from tilth.output.contact_table import read_contacts, write_contacts
from tilth.output.folder import prepare_output_folder
from tilth.output.history import HistoryWriter, read_history, read_stages
from tilth.output.log import RunLog, read_log
from tilth.output.progress import Progress
from tilth.output.snapshot import ContactShape, Snapshot, SurfaceShape
from tilth.output.surface_table import read_surface, write_surfaces
from tilth.output.vtkhdf import Results, ResultsWriter, read_results

__all__ = [
    "CheckpointThread",
    "ContactShape",
    "HistoryWriter",
    "Progress",
    "Results",
    "ResultsWriter",
    "RunLog",
    "Snapshot",
    "SurfaceShape",
    "prepare_output_folder",
    "read_checkpoint",
    "read_contacts",
    "read_history",
    "read_log",
    "read_results",
    "read_stages",
    "read_surface",
    "write_checkpoint",
    "write_contacts",
    "write_surfaces",
]
