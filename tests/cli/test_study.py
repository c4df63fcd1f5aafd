# SPDX-License-Identifier: BSD-3-Clause
"""`tilth study`: its table, killed and resumed studies, failures, and what is refused."""

import csv
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import tilth as library
from tilth import BadInput
from tilth.output.safety_files import read_safety

from .conftest import CASE, Outcome

Tilth = Callable[..., Outcome]

STUDY = """\
format = 1
case = "column.toml"
seed = 3
samples = 3
keep = "tables"

[[vary]]
key = "materials.clay.young_modulus"
name = "stiffness"
distribution = { type = "lognormal", mean = 1e6, standard_deviation = 2e5 }

[[vary]]
key = "grid.cell_size"
values = [1.0, 0.5]

[[outcomes]]
type = "history"
name = "settlement"
column = "top"
take = "smallest"
worst = "smallest"

[[outcomes]]
type = "function"
name = "rows"
function = "rows.py:rows"
"""

ROWS = """\
def rows(folder):
    return len((folder / "history.csv").read_text().splitlines())
"""

ELASTIC = ("yield_stress = 2e4", "yield_stress = 2e6")


@pytest.fixture
def column(tmp_path: Path) -> Path:
    """A study of six small columns; the yield stress is out of reach."""
    (tmp_path / "column.toml").write_text(CASE.replace(*ELASTIC), encoding="utf-8")
    (tmp_path / "rows.py").write_text(ROWS, encoding="utf-8")
    study = tmp_path / "study.toml"
    study.write_text(STUDY, encoding="utf-8")
    return study


def rows_of(folder: Path) -> list[dict[str, str]]:
    with (folder / "study.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def started(study: Path, folder: Path) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "tilth", "study", str(study), "--out", str(folder)]
    return subprocess.Popen(
        [*command, "--processes", "2"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )


def wait_for(condition: Callable[[], bool]) -> None:
    until = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.01)


def workers_of(folder: Path) -> list[int]:
    """The processes that run samples of the study in a folder (on Linux)."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if b"tilth.studies.worker" in words and str(folder.resolve()).encode() in words:
            found.append(int(entry.name))
    return found


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="finds processes in /proc")
def test_a_killed_study_gives_the_same_table(column: Path, tilth: Tilth, tmp_path: Path) -> None:
    """Killed, then a worker of it, then stopped as by Ctrl-C; compared with one in one process."""
    whole = tilth("study", column, "--out", tmp_path / "whole", "--processes", "1", "--quiet")
    assert (whole.code, whole.out, whole.err) == (0, "", "")
    folder = tmp_path / "killed"

    def complete() -> int:
        return len(list(folder.glob("samples/*/outcome.json")))

    process = started(column, folder)
    wait_for(lambda: complete() >= 1)
    process.kill()
    process.communicate()
    wait_for(lambda: not workers_of(folder))  # they end with the study, also by SIGKILL
    killed_at = complete()
    assert killed_at < 6

    process = started(column, folder)
    wait_for(lambda: len(workers_of(folder)) == 2)
    os.kill(workers_of(folder)[0], signal.SIGKILL)
    wait_for(lambda: complete() > killed_at)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate()
    if complete() < 6:
        assert process.returncode == 3
        assert b"go on with: tilth study" in said
        assert any(row["status"] == "waiting" for row in rows_of(folder))
    assert workers_of(folder) == []

    before = {f: f.stat().st_mtime_ns for f in folder.glob("samples/*/outcome.json")}
    last = tilth("study", column, "--out", folder, "--processes", "2")
    assert last.code == 0, last.err
    assert {f: f.stat().st_mtime_ns for f in before} == before  # none was run again
    for name in ("study.csv", "statistics.csv"):
        assert (folder / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
    rows = rows_of(folder)
    assert [row["sample"] for row in rows] == list("123456")
    assert {row["status"] for row in rows} == {"done"}
    assert [row["rows"] for row in rows] == ["4.0"] * 6  # headings, start, two steps
    for row in rows[1::2]:
        expected = 1800 * 9.81 * 4.0**2 / 2 / float(row["stiffness"]) * (1 - 0.3**2)
        assert -float(row["settlement [m]"]) == pytest.approx(expected, rel=0.25)
    smallest = min(rows, key=lambda row: float(row["settlement [m]"]))
    worst = float(smallest["settlement [m]"])
    assert f"worst: {worst:.5g} in sample {smallest['sample']}" in last.out
    assert "all 6 samples are done" in last.out
    sample = folder / "samples" / "0002"
    kept = {file.name for file in (sample / "case").iterdir()}
    assert "history.csv" in kept
    assert not kept & {"results.vtkhdf", "checkpoint.npz", "report.html"}
    alone = library.run(library.load_case(sample / "case.toml"), tmp_path / "alone", quiet=True)
    assert repr(float(alone.history["top [m]"].min())) == rows[1]["settlement [m]"]
    page = (folder / "study.html").read_text(encoding="utf-8")
    assert "All 6 samples are done" in page
    assert 'href="samples/0006/case"' in page
    assert "lognormal distribution, mean 1e+06, standard deviation 200000" in page
    assert "stiffness (materials.clay.young_modulus)" in page
    assert "<td>grid.cell_size</td><td>1, 0.5</td>" in page
    assert "Random draws with the seed 3 of the study." in page


@pytest.mark.slow
def test_failures_are_in_table_summary_and_exit_code(
    column: Path, tilth: Tilth, tmp_path: Path
) -> None:
    """A column too weak for its weight; a third value adds a sample and keeps the others."""
    text = column.read_text(encoding="utf-8").replace("samples = 3\n", "")
    first, last = text.index("[[vary]]"), text.index("[[outcomes]]")
    vary = '[[vary]]\nkey = "materials.clay.yield_stress"\nvalues = [2e6, 1e3]\n\n'
    text = text[:first] + vary + text[last:]
    file = column.with_name("column.toml")
    coarse = file.read_text(encoding="utf-8").replace("cell_size = 0.5", "cell_size = 1.0")
    once = coarse.replace("steps = 2", "steps = 2\nminimum_step = 0.25")
    file.write_text(once, encoding="utf-8")
    column.write_text(text, encoding="utf-8")
    done = tilth("study", column)
    folder = tmp_path / "study"
    assert done.code == 1
    assert "1 of 2 samples failed:\n  sample 2: " in done.out
    good, bad = rows_of(folder)
    assert (good["status"], good["reason"], bad["status"]) == ("done", "", "failed")
    assert bad["settlement [m]"] == bad["rows"] == ""
    assert bad["reason"]
    assert "settlement [m]: 1 samples" in done.out
    page = (folder / "study.html").read_text(encoding="utf-8")
    assert "1 of 2 samples failed" in page
    assert "Random draws" not in page

    column.write_text(text.replace("1e3]", "1e3, 3e6]"), encoding="utf-8")
    result = library.study(column, folder, processes=1, quiet=True)
    assert rows_of(folder)[:2] == [good, bad]
    assert list(result.reasons) == [2]
    assert result.values["materials.clay.yield_stress"] == [2e6, 1e3, 3e6]
    assert result.outcomes["settlement [m]"][0] == result.outcomes["settlement [m]"][2]

    column.write_text(text.replace("2e6", "4e6"), encoding="utf-8")
    refused = tilth("study", column)
    assert refused.code == 2
    assert "its 3 samples are not the first ones of this study" in refused.err
    (tmp_path / "rows.py").write_text(f"{ROWS}\n", encoding="utf-8")
    with pytest.raises(BadInput, match=r"rows\.py has changed"):
        library.study(column, folder, quiet=True)
    assert len(rows_of(folder)) == 3
    replaced = tilth("study", column, "--overwrite", "--quiet")
    assert replaced.code == 1
    assert len(rows_of(folder)) == 2


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('case = "column.toml"', 'case = "colum.toml"', "there is no such file"),
        ('column = "top"', 'column = "tpo"', "did you mean `top`?"),
        ("grid.cell_size", "grid.cell_sise", "did you mean `cell_size`?"),
        ("rows.py:rows", "rows.py:row", "did you mean `rows`?"),
        ("samples = 3\n", "", "samples: missing"),
        ("values = [1.0, 0.5]", "values = [1.0, -0.5]", "sample 2: stiffness = "),
    ],
)
def test_wrong_studies(
    column: Path, tilth: Tilth, tmp_path: Path, old: str, new: str, said: str
) -> None:
    """Refused before anything is written."""
    text = column.read_text(encoding="utf-8")
    assert old in text
    column.write_text(text.replace(old, new), encoding="utf-8")
    refused = tilth("study", column)
    assert refused.code == 2
    assert said in refused.err
    assert not (tmp_path / "study").exists()


def test_a_case_is_no_study_and_a_study_no_case(column: Path, tilth: Tilth) -> None:
    assert "run it with: tilth run" in tilth("study", column.with_name("column.toml")).err
    assert "run it with: tilth study" in tilth("run", column).err


def test_a_folder_with_something_else_is_refused(
    column: Path, tilth: Tilth, tmp_path: Path
) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("mine", encoding="utf-8")
    refused = tilth("study", column, "--out", tmp_path / "mine", "--overwrite")
    assert refused.code == 2
    assert "is not empty, and not that of a study" in refused.err
    assert [file.name for file in (tmp_path / "mine").iterdir()] == ["notes.txt"]


RECORDS = ["", "{}", '{"study": 1}', '{"study": {}, "case": {}, "files": {}, "samples": 3}']


@pytest.mark.parametrize("content", RECORDS)
def test_overwrite_removes_nothing_that_is_no_study(
    column: Path, tilth: Tilth, tmp_path: Path, content: str
) -> None:
    """A study.json of another program does not make a folder a study."""
    mine = tmp_path / "mine"
    (mine / "samples/0001").mkdir(parents=True)
    files = [mine / "study.json", mine / "study.csv", mine / "samples/0001/sound.wav"]
    for file in files:
        file.write_text(content, encoding="utf-8")
    refused = tilth("study", column, "--out", mine, "--overwrite")
    assert (refused.code, "study.json cannot be read" in refused.err) == (2, True)
    assert sorted(file for file in mine.rglob("*.*")) == sorted(files)
    assert all(file.read_text(encoding="utf-8") == content for file in files)


@pytest.mark.slow
def test_overwrite_keeps_what_a_study_has_not_written(column: Path, tilth: Tilth) -> None:
    text = column.read_text(encoding="utf-8").replace("samples = 3", "samples = 1")
    column.write_text(text, encoding="utf-8")
    assert tilth("study", column, "--quiet", "--processes", "1").code == 0
    folder = column.with_suffix("")
    own = [
        folder / "samples/0001/note.txt",
        folder / "samples/0002/case/note.txt",
        folder / "n.txt",
    ]
    for file in own:
        file.write_text("mine", encoding="utf-8")
    column.write_text(text.replace("values = [1.0, 0.5]", "values = [1.0]"), encoding="utf-8")
    assert tilth("study", column, "--quiet", "--processes", "1", "--overwrite").code == 0
    assert [file.read_text(encoding="utf-8") for file in own] == ["mine"] * 3
    assert not (folder / "samples/0002/case.toml").exists()
    assert len(rows_of(folder)) == 1


def test_no_cell_of_the_table_is_a_formula(column: Path, tilth: Tilth) -> None:
    """For a spreadsheet that opens it; a reason may repeat what a user's function has said."""
    titles = ["=1+1", "@SUM(1)", "+1", "-1", " =1", "a;=1", "a - 1", "\uff1d1", "<img src=x>"]
    text = column.read_text(encoding="utf-8").partition("[[vary]]")[0]
    text = text.replace("seed = 3\nsamples = 3\n", "")
    text += f'[[vary]]\nkey = "title"\nvalues = {titles}\n'
    text += '[[outcomes]]\ntype = "function"\nname = "rows"\nfunction = "rows.py:rows"\n'
    column.write_text(text, encoding="utf-8")
    rows = "def rows(folder):\n    raise ValueError('=HYPERLINK()')\n"
    column.with_name("rows.py").write_text(rows, encoding="utf-8")
    assert tilth("study", column, "--quiet", "--processes", "1").code == 1
    found = [row["title"] for row in rows_of(column.with_suffix(""))]
    assert found == [
        "'=1+1",
        "'@SUM(1)",
        "'+1",
        "'-1",
        "' =1",
        "a;'=1",
        "a - 1",
        "'\uff1d1",
        titles[-1],
    ]
    for line in rows_of(column.with_suffix("")):
        assert not line["reason"].lstrip().startswith(("=", "+", "-", "@"))
    page = (column.with_suffix("") / "study.html").read_text(encoding="utf-8")
    assert "<img src=x" not in page


@pytest.mark.slow
def test_a_study_of_davis_equivalents(tilth: Tilth, tmp_path: Path) -> None:
    stronger = CASE.replace("yield_stress = 2e4", "yield_stress = 1e5")
    (tmp_path / "column.toml").write_text(stronger, encoding="utf-8")
    study = tmp_path / "study.toml"
    outcome = '[[outcomes]]\ntype = "safety"\ntolerance = 0.2\ndavis = "C"\n'
    vary = '[[vary]]\nkey = "grid.cell_size"\nvalues = [1.0]\n\n'
    study.write_text(f'format = 1\ncase = "column.toml"\n{vary}{outcome}', encoding="utf-8")
    done = tilth("study", study)
    assert done.code == 0, done.err
    (record,) = (tmp_path / "study").rglob("safety.json")
    assert read_safety(record.parent).davis == "C"
