# SPDX-License-Identifier: BSD-3-Clause
"""`tilth plot` and `tilth movie`: the files it writes, and names and times that are refused."""

from collections.abc import Callable
from pathlib import Path

import pytest

from .conftest import Outcome


@pytest.mark.slow
def test_pictures_are_written_and_wrong_names_refused(
    tilth: Callable[..., Outcome], case: Callable[..., Path], tmp_path: Path
) -> None:
    run = tmp_path / "run"
    assert tilth("run", case(), "--out", run, "--quiet").code == 0
    for number, ask in enumerate(
        (
            ("--field", "displacement"),
            ("--history", "time", "top", "--scale", "log"),
            ("--field", "displacement", "--path", "0.1,0.1:0.9,0.9", "--times", "0,1"),
        )
    ):
        file = tmp_path / f"{number}.png"
        assert tilth("plot", run, *ask, "--save", file).code == 0
        assert file.read_bytes().startswith(b"\x89PNG")
    made = tilth("movie", run, "--field", "displacement", "--save", tmp_path / "x.gif")
    assert (made.code, made.err) == (0, "")
    assert f"frames written to {tmp_path / 'x.gif'}" in made.out
    assert (tmp_path / "x.gif").read_bytes().startswith(b"GIF89a")
    refused = tilth("movie", run, "--field", "displacement", "--save", tmp_path / "x.avi")
    assert refused.code == 2
    assert ".mp4, .gif, .webp" in refused.err
    for ask, remedy in (
        (("--field", "displacements"), "did you mean displacement"),
        (("--field", "displacement", "--time", "77"), "choose from 0,"),
        (("--history", "time", "topp"), "did you mean top"),
        (("--field", "displacement", "--section", "x=0"), "leave out --section"),
        (("--field", "displacement", "--times", "0,1"), "give it with --path"),
        (("--field", "displacement", "--path", "0,0:1,1", "--times", "a"), "write T1,T2"),
        (("--field", "displacement", "--scale", "log"), "leave it out"),
    ):
        refused = tilth("plot", run, *ask, "--save", tmp_path / "refused.png")
        assert refused.code == 2
        assert remedy in refused.err
    assert not (tmp_path / "refused.png").exists()
