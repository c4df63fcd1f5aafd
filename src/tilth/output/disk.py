# SPDX-License-Identifier: BSD-3-Clause
"""What the system says of a file that it cannot write, in words of the user."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

from tilth.errors import NOT_GIVEN, AnalysisFailed, BadInput
from tilth.input_files import NoFile

_REASONS = {
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the quota of the disk is used up",
    errno.EFBIG: "the file would be larger than the system allows",
    errno.EIO: "the disk reports an input or output error",
    errno.EROFS: "the disk is read-only",
    errno.EACCES: "there is no permission to write there",
    errno.EPERM: "there is no permission to write there",
    errno.ENODEV: "the disk is not there any more",
    errno.ENXIO: "the disk is not there any more",
    errno.ESTALE: "the disk is not there any more",
}
_OF_THE_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS, errno.ESTALE)


def reason_of(error: OSError) -> str:
    """Returns why the system refused, in one line."""
    if error.errno in _REASONS:
        return _REASONS[error.errno]
    if isinstance(error, NoFile):
        return str(error.strerror)
    text = os.strerror(error.errno) if error.errno else str(error)
    return " ".join(text.split())


def is_of_the_disk(error: BaseException) -> bool:
    """Whether an error is a full, damaged or read-only disk, whatever was written."""
    return isinstance(error, OSError) and error.errno in _OF_THE_DISK


@contextmanager
def writing(path: Path, remedy: str = "") -> Iterator[None]:
    """Within this context an `OSError` becomes `AnalysisFailed` with one sentence about ``path``.

    ``remedy`` is what to do then; if not given, how to continue the run in the folder of ``path``.
    """
    try:
        yield
    except OSError as error:
        raise AnalysisFailed(
            f"{path} cannot be written: {reason_of(error)}", remedy or _how_to_go_on(path.parent)
        ) from error


@contextmanager
def asked_to_write(
    problem: str, remedy: str, *, key: str = "", value: Any = NOT_GIVEN
) -> Iterator[None]:
    """Within this context an `OSError` for a file that the user named becomes `BadInput`.

    One that is of the disk becomes `AnalysisFailed`. ``problem`` is followed by the reason; the
    other arguments are as of ``BadInput``.
    """
    try:
        yield
    except OSError as error:
        what = f"{problem}: {reason_of(error)}"
        if is_of_the_disk(error):
            subject = "" if value is NOT_GIVEN else f"{value}: "
            raise AnalysisFailed(
                f"{subject}{what}", f"make room on the disk, or {remedy}"
            ) from error
        raise BadInput(what, remedy, key=key, value=value) from None


def asked_to_save(path: Path, option: str = "--save") -> AbstractContextManager[None]:
    """Returns `asked_to_write` for a picture or movie that the user named with an option."""
    key = option.removeprefix("--")
    return asked_to_write(
        "cannot be written", f"choose another file with {option}", key=key, value=str(path)
    )


def _how_to_go_on(folder: Path) -> str:
    from tilth.output.folder import CHECKPOINT

    if (folder / CHECKPOINT).exists():
        return f"put this right, then continue with: tilth resume {folder}"
    return "put this right, then start the run again with --overwrite"
