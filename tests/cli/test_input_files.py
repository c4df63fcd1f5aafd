# SPDX-License-Identifier: BSD-3-Clause
"""Every file that a user can name: one that has no end, or never comes, is refused at once."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tilth import BadInput, load_case
from tilth.bodies.gmsh_file import read_gmsh
from tilth.bodies.stl_file import read_stl
from tilth.case import load_element_case, load_study
from tilth.input_files import absolute, require_file, why_no_file, why_no_folder
from tilth.model.base import Declared
from tilth.model.user_function import load_function
from tilth.output.checkpoint import read_checkpoint
from tilth.output.contact_table import read_contacts
from tilth.output.history import read_history
from tilth.output.log import read_log
from tilth.output.surface_table import read_surface
from tilth.output.vtkhdf import read_results
from tilth.variation.grid_file import read_grid
from tilth.variation.heights import read_heights
from tilth.variation.survey import read_survey

from .conftest import CASE, Outcome

Tilth = Callable[..., Outcome]

pytestmark = [
    pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no named pipes"),
    pytest.mark.timeout(150),  # what waits for a pipe waits for ever
]

STRANGE = {
    "pipe": "it is a pipe",
    "device": "it is a device",
    "circle": "its symbolic links lead in a circle",
    "folder": "it is a folder",
}


def put(kind: str, path: Path) -> Path:
    """Makes something that is no file where one is expected; returns its path."""
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "circle":
        path.symlink_to(path.name)
    else:
        path.mkdir()
    return path


def spoil(path: Path, kind: str) -> None:
    """Replaces a file by something that is none."""
    path.unlink(missing_ok=True)
    put(kind, path)


BOX = 'shape = { type = "box", lower = [0, 0], upper = [1, 4] }'
DENSITY = "density = 1800"
BASE = 'axis = "y"\nat = 0\ncondition = "fixed"'
AXIS = 'type = "plane"\n' + BASE
MATERIAL = CASE[CASE.index('model = "von') : CASE.index("[[bodies]]")]
WEIGHT = CASE[CASE.index("[[loads]]") : CASE.index("[schedule]")]


def shape(text: str) -> tuple[str, str]:
    return BOX, f"shape = {{ {text} }}"


def geometry(text: str) -> tuple[str, str]:
    return AXIS, f'type = "implicit"\ncondition = "fixed"\ngeometry = {{ {text} }}'


NAMED = {
    "bodies[0].shape.file": [
        shape('type = "mesh", file = "F.msh"'),
        shape('type = "stl", file = "F.stl"'),
        shape('type = "outline", scale = 1.0, file = "F.dxf"'),
        shape('type = "outline", scale = 1.0, file = "F.geojson"'),
    ],
    "bodies[0].shape.surface.file": [
        shape(
            'type = "terrain", lower = [0], upper = [4], base = 0.0, surface = { file = "F.csv" }'
        ),
        shape(
            'type = "terrain", lower = [0], upper = [4], base = 0.0, surface = { file = "F.asc" }'
        ),
    ],
    "bodies[0].layers[0].bottom.file": [
        (BOX, BOX + '\nlayers = [{ material = "clay", bottom = { file = "F.csv" } }]')
    ],
    "materials.clay.density.file": [(DENSITY, 'density = { type = "grid", file = "F.csv" }')],
    "materials.clay.density": [(DENSITY, 'density = "F.py:f"')],
    "materials.clay.class": [(MATERIAL, 'model = "user_python"\nclass = "F.py:Clay"\n')],
    "materials.clay.function": [(MATERIAL, 'model = "user_compiled"\nfunction = "F.py:f"\n')],
    "materials.clay.library": [(MATERIAL, 'model = "user_umat"\nlibrary = "F.so"\n')],
    "boundaries[0].geometry.function": [geometry('type = "function", function = "F.py:f"')],
    "boundaries[0].geometry.file": [geometry('type = "stl", file = "F.stl"')],
    "boundaries[0].motion": [(BASE, BASE + '\nmotion = "F.py:f"')],
    "boundaries[0].acceleration.file": [(BASE, BASE + '\nacceleration = { file = "F.csv" }')],
    "initial.stress[0].folder": [
        (WEIGHT, WEIGHT + '[[initial.stress]]\ntype = "run"\nbody = "column"\nfolder = "F"\n')
    ],
    "water.level.file": [(WEIGHT, WEIGHT + '[water]\nlevel = { file = "F.csv" }\n')],
}
"""Entries of a case file that name a file, by their keys: each kind of file that they may name."""

ENTRIES = [(key, change) for key, changes in NAMED.items() for change in changes]


@pytest.mark.parametrize("kind", STRANGE)
def test_no_file_that_a_case_names(
    kind: str, case: Callable[..., Path], tilth: Tilth, tmp_path: Path
) -> None:
    """One message with file, key, value and remedy, from one command for all entries."""
    for key, change in ENTRIES:
        file = case(change)
        name = change[1].partition('"F')[2].partition('"')[0].partition(":")[0]
        there = tmp_path / f"F{name}"
        wanted = "folder" if key.endswith("folder") else "file"
        if kind == wanted:
            continue
        put(kind, there)
        done = tilth("run", file, "--out", tmp_path / "out")
        assert (done.code, done.out) == (2, ""), done
        assert done.err.startswith(f"{file}: {key} = "), done.err
        assert STRANGE[kind] in done.err, done.err
        assert str(tmp_path) in done.err.splitlines()[1], done.err
        assert len(done.err.splitlines()) == 2, done.err
        assert not (tmp_path / "out").exists()
        there.rmdir() if kind == "folder" else there.unlink()


OF_STUDIES = {"Study.case", "FunctionOutcome.function"}

KNOWN = {
    "Mesh.file": "bodies[0].shape.file",
    "Stl.file": "bodies[0].shape.file",
    "Outline.file": "bodies[0].shape.file",
    "MeshGeometry.file": "boundaries[0].geometry.file",
    "StlGeometry.file": "boundaries[0].geometry.file",
    "FunctionGeometry.function": "boundaries[0].geometry.function",
    "UserPython.class_": "materials.clay.class",
    "UserCompiled.function": "materials.clay.function",
    "UserUmat.library": "materials.clay.library",
    "GroundAcceleration.file": "boundaries[0].acceleration.file",
    "GridFile.file": "materials.clay.density.file",
    "OfPosition.function": "materials.clay.density",
    "StressOfRun.folder": "initial.stress[0].folder",
    "ImplicitBoundary.motion": "boundaries[0].motion",
}


def declared(of: type) -> set[type]:
    return {of}.union(*(declared(each) for each in of.__subclasses__()))


def test_every_declared_entry_that_names_a_file_is_tested() -> None:
    """A new one belongs into `NAMED`, with its key."""
    found = {
        f"{each.__name__}.{name}"
        for each in declared(Declared)
        for name, kind in each.__annotations__.items()
        if "FileName" in str(kind) or "PythonFunction" in str(kind)
    }
    assert found == set(KNOWN) | OF_STUDIES
    assert set(KNOWN.values()) <= set(NAMED)


READERS: dict[str, Callable[[str], Any]] = {
    ".csv": lambda file: read_grid(file, 2, "key"),
    ".asc": lambda file: read_heights(file, 2, "key"),
    "_survey.csv": lambda file: read_survey(file, 2, "key"),
    ".stl": lambda file: read_stl(Path(file), "key"),
    ".msh": lambda file: read_gmsh(Path(file), lambda problem, remedy: BadInput(problem, remedy)),
    ".py": lambda file: load_function(f"{file}:f", "."),
    "history.csv": read_history,
    "surface.csv": read_surface,
    "contact.csv": read_contacts,
    ".vtkhdf": read_results,
    ".npz": read_checkpoint,
    ".txt": read_log,
    ".toml": load_case,
    "_study.toml": load_study,
    "_element.toml": load_element_case,
}


@pytest.mark.parametrize("ending", READERS)
@pytest.mark.parametrize("kind", STRANGE)
def test_no_file_that_is_given_in_python(ending: str, kind: str, tmp_path: Path) -> None:
    """The same where no case file is between the user and the reader."""
    with pytest.raises(BadInput) as error:
        READERS[ending](str(put(kind, tmp_path / f"file{ending}")))
    found = STRANGE[kind].removeprefix("it is ")
    assert found in str(error.value), error.value
    assert "Errno" not in str(error.value)


@pytest.mark.parametrize("kind", STRANGE)
@pytest.mark.parametrize("command", ["run", "check", "safety", "study", "element"])
def test_no_case_file(command: str, kind: str, tilth: Tilth, tmp_path: Path) -> None:
    file = put(kind, tmp_path / "case.toml")
    done = tilth(command, file)
    assert (done.code, done.out) == (2, ""), done
    if (command, kind) == ("safety", "folder"):  # it may be that of a run
        assert "model.json cannot be read" in done.err
        return
    assert done.err.startswith(f"{file}: "), done.err
    assert STRANGE[kind].removeprefix("it ") in done.err, done.err
    assert os.listdir(tmp_path) == ["case.toml"]


OF_RUNS = {
    "resume": [],
    "report": [],
    "plot": ["--field", "displacement_y", "--save", "P.png"],
    "movie": ["--field", "displacement_y", "--save", "M.gif"],
    "export": ["--to", "csv", "--out", "E"],
    "safety": [],
}


@pytest.mark.parametrize("command", OF_RUNS)
def test_no_file_in_the_folder_of_a_run(
    command: str, finished: Path, tilth: Tilth, tmp_path: Path
) -> None:
    """Whichever of its files it is, also the hidden ones that exist while one is written."""
    names = [file.name for file in finished.iterdir()] + [
        ".history.csv.new",
        "checkpoint_stage_02.npz",
    ]
    assert len(names) > 8
    options = [each.replace("P", str(tmp_path / "P")) for each in OF_RUNS[command]]
    for number, name in enumerate(names):
        kind = ["pipe", "device", "folder"][number % 3]
        folder = tmp_path / f"run{number}"
        shutil.copytree(finished, folder)
        spoil(folder / name, kind)
        done = tilth(command, folder, *options)
        assert done.code == 2, done
        assert f"{folder / name} has the name of a file of tilth's, but {STRANGE[kind]}" in done.err
        assert "rename or delete it" in done.err


def test_no_file_in_a_folder_that_is_written(
    case: Callable[..., Path], tilth: Tilth, tmp_path: Path
) -> None:
    """`--overwrite` removes files, nothing else; `--out` may be no circle of links."""
    for number, name in enumerate(["history.csv", "log.txt", "results.vtkhdf", ".tilth.lock"]):
        folder = tmp_path / f"out{number}"
        folder.mkdir()
        put("pipe", folder / name)
        done = tilth("run", case(), "--out", folder, "--overwrite")
        assert done.code == 2
        assert f"{folder / name} has the name of a file of tilth's, but it is a pipe" in done.err
        assert os.listdir(folder) == [name]
    for command in ("run", "safety"):
        done = tilth(command, case(), "--out", put("circle", tmp_path / command))
        assert done.code == 2
        assert STRANGE["circle"] in done.err


def test_no_file_of_a_study(tilth: Tilth, tmp_path: Path) -> None:
    """The case and the function that it names, its record, and the files of its samples."""
    study, out, case = tmp_path / "study.toml", tmp_path / "out", tmp_path / "case.toml"
    text = """format = 1
case = "case.toml"
vary = [{ key = "grid.cell_size", values = [1.0] }]
outcomes = [{ type = "function", name = "one", function = "one.py:one" }]
"""
    study.write_text(text, encoding="utf-8")
    case.write_text(CASE, encoding="utf-8")
    function = tmp_path / "one.py"
    function.write_text("def one(folder): return 1.0\n", encoding="utf-8")
    command = ("study", study, "--out", out, "--quiet", "--processes", "1")
    for kind in ("pipe", "device", "folder"):
        for file in (case, function):
            kept = file.read_bytes()
            spoil(file, kind)
            done = tilth(*command)
            assert (done.code, STRANGE[kind].removeprefix("it ") in done.err) == (2, True), done
            assert not (out / "study.json").exists()
            file.rmdir() if kind == "folder" else file.unlink()
            file.write_bytes(kept)
    assert tilth(*command).code == 0
    for name in ("case.toml", "outcome.json", "output.txt"):
        again = tmp_path / f"with {name}"
        shutil.copytree(out, again)
        (again / "samples/0001/outcome.json").unlink()
        spoil(again / "samples/0001" / name, "pipe")
        done = tilth("study", study, "--out", again, "--quiet")
        assert (done.code, "it is a pipe" in done.err) == (2, True), done
    spoil(out / "study.json", "pipe")
    done = tilth(*command, "--overwrite")
    assert (done.code, "it is a pipe" in done.err) == (2, True), done


def test_what_a_path_is(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.touch()
    assert (why_no_file(file), why_no_folder(tmp_path)) == ("", "")
    assert why_no_folder(file) == "it is a file, not a folder"
    assert why_no_file(tmp_path) == "it is a folder, not a file"
    for none in (tmp_path / "none", file / "in it", "with\0zero"):
        assert why_no_file(none) == "there is no such file"
        assert why_no_folder(none) == "there is no such folder"
    assert why_no_file("x" * 5000) == os.strerror(36)
    circle = put("circle", tmp_path / "circle")
    assert absolute(circle) == tmp_path.resolve() / "circle"
    for path, error in ((tmp_path, IsADirectoryError), (file / "none", FileNotFoundError)):
        with pytest.raises(error):
            require_file(path)
    require_file(file)


# --- the mark that Windows editors put at the start of a text ---------------------------------

MARK = b"\xef\xbb\xbf"
