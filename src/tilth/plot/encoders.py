# SPDX-License-Identifier: BSD-3-Clause
"""Writers of movies: GIF and WebP by Pillow, MP4 by ffmpeg."""

from __future__ import annotations

import errno
import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tilth.errors import BadInput, visible
from tilth.plot.files import require_ending

BY_PILLOW, BY_FFMPEG = ("gif", "webp"), ("mp4",)
FORMATS = (*BY_FFMPEG, *BY_PILLOW)
INSTALL = 'pip install "tilth[movie]" (or: pip install imageio-ffmpeg)'
"""Installs a package that brings the program."""


@dataclass(frozen=True)
class Encoder:
    """A writer of matplotlib, and the settings of matplotlib that it needs."""

    writer: Any
    settings: Any = field(default_factory=dict)

    @contextmanager
    def saving(self, figure: Any, path: Path, resolution: int) -> Iterator[None]:
        """Within this context the writer grabs frames of a figure; at the end the file is whole.

        Args:
            path: absolute, so that ffmpeg takes it neither for an option nor for a protocol.
            resolution: pixels per inch.

        Raises:
            OSError: the file cannot be written.
        """
        try:
            with self.writer.saving(figure, str(path), resolution):
                yield
        except subprocess.CalledProcessError as error:
            raise _of_ffmpeg(error) from error


def _of_ffmpeg(error: subprocess.CalledProcessError) -> OSError:
    """Returns the error that ffmpeg's last words are about."""
    said = error.stderr if isinstance(error.stderr, bytes) else b""
    text = said.decode(errors="replace")
    for number in (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES):
        if os.strerror(number) in text or error.returncode == 256 - number:
            return OSError(number, os.strerror(number))
    last = (text.strip().splitlines() or [f"exit code {error.returncode}"])[-1]
    return OSError(f"ffmpeg failed: {visible(last)}")


def encoder_for(path: Path, rate: float) -> Encoder:
    """Returns the writer for a file by its ending, with the rate of its frames [1/s].

    Raises ``BadInput`` for another ending, a folder that is not there, or if there is no ffmpeg.
    """
    from matplotlib.animation import FFMpegWriter, PillowWriter

    require_ending(path, FORMATS, "movies")
    fps: Any = rate  # matplotlib's annotation wants a whole number
    if path.suffix.lower().removeprefix(".") in BY_PILLOW:
        return Encoder(PillowWriter(fps=fps))
    # x264 for any player; a picture of lines and texts needs more than its usual quality.
    writer = FFMpegWriter(fps=fps, codec="h264", extra_args=["-crf", "18"])
    return Encoder(writer, {"animation.ffmpeg_path": _ffmpeg(path)})


def _ffmpeg(path: Path) -> str:
    """Returns the program: the one of the system, or of the package imageio-ffmpeg."""
    if found := shutil.which("ffmpeg"):
        return found
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        return str(get_ffmpeg_exe())
    except (ImportError, RuntimeError):  # not installed, or without a program for this machine
        raise BadInput(
            "an MP4 file needs the program ffmpeg, which is not installed",
            f"install it with: {INSTALL}; or let the name end with .gif or .webp",
            key="save",
            value=str(path),
        ) from None
