# SPDX-License-Identifier: BSD-3-Clause
"""Files that a command writes where the user says: whole or not at all, and under that name."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tilth import BadInput
from tilth.analysis.run import set_threads
from tilth.plot.encoders import _of_ffmpeg
from tilth.plot.movie import write_movie

from .conftest import CASE, Outcome

Tilth = Callable[..., Outcome]


FIELD = ("--field", "displacement_y", "--save")
WRITERS: dict[str, tuple[str | Path, ...]] = {
    "p.png": ("plot", "RUN", *FIELD),
    "p.svg": ("plot", "RUN", *FIELD),
    "m.gif": ("movie", "RUN", *FIELD),
    "c.png": ("check", "CASE", "--picture"),
    "s.json": ("schema", "--out"),
}
"""What writes a file of such a name; its name is the last argument."""


def arguments(finished: Path, file: Path) -> list[str]:
    known = {"RUN": str(finished), "CASE": str(finished.parent / "case.toml")}
    return [*(known.get(str(word), str(word)) for word in WRITERS[file.name]), str(file)]


@pytest.mark.parametrize(
    ("name", "earlier"),
    [
        ("s.json", True),
        ("s.json", False),
        ("p.svg", True),
        ("c.png", False),
        pytest.param("p.png", True, marks=pytest.mark.slow),
        pytest.param("m.gif", True, marks=pytest.mark.slow),
    ],
)
def test_a_file_that_cannot_be_completed(
    name: str, earlier: bool, finished: Path, tilth: Tilth, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """The disk is full, there is no permission, the user stops it: an earlier file stays."""
    file = tmp_path / name
    if earlier:
        file.write_text("earlier", encoding="utf-8")
    option = WRITERS[name][-1]
    faults: list[tuple[BaseException, int, str, str]] = [
        (OSError(errno.ENOSPC, "x"), 1, "the disk is full", "make room on the disk, or choose"),
        (KeyboardInterrupt(), 3, "interrupted", ""),
        (OSError(errno.EDQUOT, "x"), 1, "the quota of the disk is used up", "make room"),
        (OSError(errno.EACCES, "x"), 2, "there is no permission to write there", "choose another"),
    ]
    for error, code, reason, remedy in faults if name == "s.json" else faults[:2]:

        def stop(*_: Any, fault: BaseException = error) -> None:
            raise fault

        monkeypatch.setattr(os, "replace", stop)
        done = tilth(*arguments(finished, file))
        monkeypatch.undo()
        assert done.code == code, done
        assert reason in done.err
        assert remedy in done.err
        if code != 3:
            assert str(file) in done.err
            assert f"another file with {option}" in done.err
        assert os.listdir(tmp_path) == ([name] if earlier else [])
        assert not earlier or file.read_text(encoding="utf-8") == "earlier"
    done = tilth(*arguments(finished, file))
    assert (done.code, os.listdir(tmp_path)) == (0, [name]), done
    assert file.stat().st_size > 1000


@pytest.mark.parametrize("name", ["p.svg", "c.png", "s.json"])
def test_only_a_file_is_replaced(name: str, finished: Path, tilth: Tilth, tmp_path: Path) -> None:
    """A link keeps its place: the file that it leads to is replaced."""
    (tmp_path / "real").mkdir()
    file, real = tmp_path / name, tmp_path / "real" / name
    real.write_text("earlier", encoding="utf-8")
    file.symlink_to(real)
    assert tilth(*arguments(finished, file)).code == 0
    assert (file.is_symlink(), real.stat().st_size > 1000) == (True, True)
    file.unlink()
    if name != "s.json":  # which can be printed, into /dev/stdout
        os.mkfifo(file)
        done = tilth(*arguments(finished, file))
        assert (done.code, "it is a pipe, not a file" in done.err) == (2, True), done


def limited(command: list[str], size: int) -> subprocess.CompletedProcess[str]:
    """Runs a command whose files are so large at most [bytes]."""

    def limit() -> None:
        import resource

        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    return subprocess.run(command, preexec_fn=limit, capture_output=True, text=True, check=False)


def test_a_template_on_a_full_disk(tmp_path: Path) -> None:
    pytest.importorskip("resource")
    file = tmp_path / "new.toml"
    done = limited([sys.executable, "-m", "tilth", "new", "slope", str(file)], 100)
    assert done.returncode == 1
    assert f"{file}: cannot be written: the file would be larger than the system" in done.stderr
    assert "make room on the disk, or choose another file" in done.stderr
    assert not file.exists()


# --- movies -------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["-y.mp4", "pipe:1.mp4", "http:a.mp4", "%d.mp4", "-.mp4", "-a.gif"]
)
def test_names_mean_nothing_to_ffmpeg(
    name: str, finished: Path, tilth: Tilth, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither an option nor a protocol nor a pattern: a file of that name is written."""
    pytest.importorskip("imageio_ffmpeg")
    monkeypatch.chdir(tmp_path)
    done = tilth("movie", finished, "--field", "displacement_y", "--save", name)
    assert (done.code, os.listdir(tmp_path)) == (0, [name]), done
    assert (tmp_path / name).stat().st_size > 1000


def test_what_ffmpeg_says() -> None:
    """In its exit code, or in its last words."""
    for code, words, number in (
        (256 - errno.ENOSPC, b"", errno.ENOSPC),
        (1, b"frame 3\nout.mp4: No space left on device\n", errno.ENOSPC),
        (1, b"out.mp4: Permission denied", errno.EACCES),
    ):
        assert _of_ffmpeg(subprocess.CalledProcessError(code, "x", b"", words)).errno == number
    other = _of_ffmpeg(subprocess.CalledProcessError(8, "x", b"", b"a\nno codec\n"))
    assert str(other) == "ffmpeg failed: no codec"
    silent = _of_ffmpeg(subprocess.CalledProcessError(8, "x"))
    assert str(silent) == "ffmpeg failed: exit code 8"


@pytest.mark.parametrize("rate", [1e-9, 0.0, -1.0, 61.0, float("nan"), float("inf")])
def test_a_rate_that_no_movie_has(rate: float, finished: Path, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"fps = .*: is no rate of frames\n.*from 0\.01 to 60"):
        write_movie(finished, "displacement_y", tmp_path / "m.gif", fps=rate)
    assert not list(tmp_path.iterdir())


def test_the_slowest_movie(finished: Path, tmp_path: Path) -> None:
    assert write_movie(finished, "displacement_y", tmp_path / "m.gif", fps=0.01) == 3


# --- numbers of threads -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("command", "option"),
    [
        ("run", "--threads"),
        ("resume", "--threads"),
        ("safety", "--threads"),
        ("study", "--processes"),
    ],
)
def test_more_threads_than_the_core_takes(
    command: str, option: str, case: Callable[..., Path], tilth: Tilth
) -> None:
    for number in ("1025", "1000000000000", "0", "-1"):
        done = tilth(command, case(), option, number)
        assert (done.code, done.out) == (2, ""), done
        assert f"Invalid value for '{option}': {number} is not in the range" in done.err
    with pytest.raises(BadInput, match="threads = 1025: is more than the core takes"):
        set_threads(1025)


# --- standard streams ---------------------------------------------------------------------------


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize("command", ["run case.toml --quiet", "schema"])
def test_closed_streams(command: str, closed: str, tmp_path: Path) -> None:
    """What is printed goes nowhere, and above all not into a file of the run."""
    (tmp_path / "case.toml").write_text(CASE, encoding="utf-8")
    line = f"{sys.executable} -m tilth {command} {closed}"
    done = subprocess.run(["sh", "-c", line], cwd=tmp_path, capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    if command == "schema":
        assert (len(done.stdout) > 1000) == (">&-" not in closed.replace("2>&-", ""))
        return
    own = [file.read_bytes() for file in (tmp_path / "case").iterdir()]
    assert len(own) > 6
    assert all(not content.startswith(b"results in") for content in own)


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        "run CASE --out out", "check CASE", "resume RUN", "report RUN", "new slope",
        "plot RUN --field displacement_y", "movie RUN --field displacement_y", "safety RUN",
        "export RUN --to csv --out out", "study study.toml", "verify oedometer",
        "completion bash", "--version", "--help",
    ],
)  # fmt: skip
def test_closed_streams_of_every_command(command: str, finished: Path, tmp_path: Path) -> None:
    closed = "<&- >&- 2>&-"
    study = """format = 1
case = "CASE"
vary = [{ key = "grid.cell_size", values = [1.0] }]
outcomes = [{ type = "history", name = "one", column = "top", take = "last" }]
"""
    case = finished.parent / "case.toml"
    (tmp_path / "study.toml").write_text(study.replace("CASE", str(case)), encoding="utf-8")
    words = command.replace("CASE", str(case)).replace("RUN", str(finished))
    line = f"{sys.executable} -m tilth {words} {closed}"
    done = subprocess.run(["sh", "-c", line], cwd=tmp_path, capture_output=True, check=False)
    codes = (0, 1) if words.startswith("safety") else (0,)  # 1: undecided
    assert done.returncode in codes, done
    assert b"Traceback" not in done.stderr
    wrong = subprocess.run(
        ["sh", "-c", f"{sys.executable} -m tilth {words} --no-such-option {closed}"],
        cwd=tmp_path, capture_output=True, check=False,
    )  # fmt: skip
    assert wrong.returncode == 2


WARNING = """
import logging, sys, types, warnings
from tilth.cli import silence_libraries

silence_libraries()
for name in ("numpy.linalg", "matplotlib.font_manager", "tilth.report.html", "__main__"):
    for kind in (RuntimeWarning, DeprecationWarning, UserWarning):
        exec(f"import warnings; warnings.warn('of {name}', {kind.__name__})", {"__name__": name})
logging.getLogger("matplotlib").warning("of a logger")
exec("import warnings; warnings.warn('of my law')", {"__name__": "tilth_user_law_12"})
"""


def test_warnings_of_libraries_stay_from_the_terminal() -> None:
    """Those of the user's own functions do not; whoever asks for all warnings has them."""
    found = subprocess.run(
        [sys.executable, "-c", WARNING], capture_output=True, text=True, check=True
    )
    assert "of my law" in found.stderr
    for part in ("numpy", "matplotlib", "tilth.report", "__main__", "logger"):
        assert f"of {part}" not in found.stderr
    assert len(found.stderr.splitlines()) <= 2, found.stderr
    asked = [sys.executable, "-W", "default", "-c", WARNING]
    every = subprocess.run(asked, capture_output=True, text=True, check=True).stderr
    assert "of numpy.linalg" in every
