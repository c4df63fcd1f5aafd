# SPDX-License-Identifier: BSD-3-Clause
"""`tilth export`: the files it writes, and what it refuses with one message."""

from collections.abc import Callable
from pathlib import Path

from .conftest import Outcome


def test_files_are_written_and_wrong_names_refused(
    tilth: Callable[..., Outcome], case: Callable[..., Path], tmp_path: Path
) -> None:
    run, out = tmp_path / "run", tmp_path / "out"
    assert tilth("run", case(), "--out", run, "--quiet").code == 0
    done = tilth("export", run, "--to", "csv", "--all", "--fields", "displacement_y, volume")
    assert (done.code, done.out) == (0, f"4 files written to {tmp_path / 'run_csv'}\n")
    first = (tmp_path / "run_csv" / "points_0002.csv").read_text().splitlines()[0]
    assert first == "point_id,body,x [m],y [m],displacement_y [m],volume [m²]"
    for choice, remedy in (
        (("--to", "csv", "--fields", "displacements"), "did you mean displacement"),
        (("--to", "csv", "--time", "77"), "choose from 0,"),
        (("--to", "csv", "--time", "1", "--all"), "give one of them"),
        (("--to", "xls"), "'vtk', 'csv', 'gmsh', 'paraview'"),
        ((), "Missing option '--to'"),
    ):
        refused = tilth("export", run, *choice, "--out", out)
        assert refused.code == 2
        assert remedy in refused.err
        assert not out.exists()
    assert tilth("export", run, "--to", "csv").code == 2  # not empty
    assert tilth("export", tmp_path / "none", "--to", "csv").code == 2
