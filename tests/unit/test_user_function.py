# SPDX-License-Identifier: BSD-3-Clause
"""Functions named in a case file: loaded from their file, and their results checked."""

import sys

import numpy as np
import pytest

from tilth.errors import BadInput
from tilth.model.user_function import UserFunction, load_function

FILE = """
from __future__ import annotations
from dataclasses import dataclass
import numpy as np

LEVEL = 2.0

@dataclass
class Ramp:
    slope: float
    def __call__(self, x, factor):
        return factor * self.slope * x

lift = Ramp(0.5)

def distance(x):
    return x[:, 1] - LEVEL

def fails(x):
    value = x[:, 1]
    return value + np.ones(len(x) + 1)

def root(x):
    return np.sqrt(x[:, 0])

def number(x):
    return 1.0

def words(x):
    return "far"

def overwrites(x):
    x[:] = 0.0
    return x[:, 0]
"""

PLACES = np.array([[1.0, 5.0], [-3.0, 0.5], [-4.0, 1.0]])


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "shape.py").write_text(FILE)
    return tmp_path


def refused(reference, folder, further=(), shape=()):
    with pytest.raises(BadInput) as raised:
        UserFunction(reference, folder, key="boundaries[0].geometry.function", shape=shape)(
            PLACES, *further
        )
    assert raised.value.key == "boundaries[0].geometry.function"
    assert raised.value.value == reference
    assert "Traceback" not in str(raised.value)
    return raised.value


def test_a_path_is_relative_to_the_folder_or_absolute(folder):
    before = list(sys.path)
    for reference in ("shape.py:distance", f"{folder}/shape.py:distance"):
        np.testing.assert_array_equal(load_function(reference, folder)(PLACES), [3.0, -1.5, -1.0])
    assert sys.path == before
    assert [p.name for p in folder.iterdir()] == ["shape.py"]


def test_two_files_of_one_name_and_a_changed_file_are_kept_apart(folder):
    (folder / "other").mkdir()
    (folder / "other/shape.py").write_text("def distance(x):\n    return 7.0 * x[:, 0]\n")
    first = load_function("shape.py:distance", folder)
    second = load_function("other/shape.py:distance", folder)
    (folder / "shape.py").write_text(FILE.replace("LEVEL = 2.0", "LEVEL = 3.0"))
    changed = load_function("shape.py:distance", folder)
    assert [f(PLACES)[0] for f in (first, second, changed)] == [3.0, 7.0, 2.0]


def test_further_arguments_and_objects_that_can_be_called(folder):
    lift = UserFunction("shape.py:lift", folder, shape=(2,))
    np.testing.assert_array_equal(lift(PLACES, 0.5), 0.25 * PLACES)


def test_a_function_cannot_change_the_places(folder):
    places = PLACES.copy()
    UserFunction("shape.py:overwrites", folder)(places)
    np.testing.assert_array_equal(places, PLACES)


@pytest.mark.parametrize("reference", ["shape.py", "shape.distance", ":distance", "shape.py:a b"])
def test_another_form_of_reference_is_refused(folder, reference):
    assert "`shape.py:distance`" in refused(reference, folder).remedy


def test_a_missing_file_or_name_suggests_a_near_one(folder):
    error = refused("shap.py:distance", folder)
    assert "there is no such file" in error.problem
    assert error.remedy == "did you mean `shape.py`?"
    error = refused("shape.py:distence", folder)
    assert error.problem == "`shape.py` has no function `distence`"
    assert error.remedy == "did you mean `distance`?"
    assert "`distance`" in refused("shape.py:zzz", folder).remedy
    assert "is a float, not a function" in refused("shape.py:LEVEL", folder).problem


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a = 1\nb = a / 0\n", "ZeroDivisionError: division by zero (line 2 of `bad.py`)"),
        (
            "def distance(x):\n    return (x\n",
            "SyntaxError: '(' was never closed (line 2 of `bad.py`)",
        ),
        (
            "import no_such_package\n",
            "ModuleNotFoundError: No module named 'no_such_package' (line 1",
        ),
        ("\nraise SystemExit\n", "SystemExit (line 2 of `bad.py`)"),
        ("def f():\n    raise KeyError('a')\n\nf()\n", "KeyError: 'a' (line 2 of `bad.py`)"),
    ],
)
def test_a_file_that_fails_when_it_is_run(folder, text, said):
    (folder / "bad.py").write_text(text)
    modules = set(sys.modules)
    assert said in refused("bad.py:distance", folder).problem
    assert not [name for name in set(sys.modules) - modules if name.startswith("tilth_user")]


def test_an_exception_inside_the_function_is_told_with_its_line(folder):
    line = FILE.splitlines().index("    return value + np.ones(len(x) + 1)") + 1
    problem = refused("shape.py:fails", folder).problem
    assert "ValueError: operands could not be broadcast" in problem
    assert f"(line {line} of `shape.py`)" in problem


def test_wrong_results_are_refused(folder):
    assert "shape () for 3 positions, not (3,)" in refused("shape.py:number", folder).problem
    assert "returned a str" in refused("shape.py:words", folder).problem
    error = refused("shape.py:distance", folder, shape=(2,))
    assert "shape (3,) for 3 positions, not (3, 2)" in error.problem
    assert "return 2 numbers per position" in error.remedy
    assert "shape (n, 2), such as" in error.remedy


def test_a_value_that_is_not_finite_names_the_first_place(folder):
    error = refused("shape.py:root", folder)
    assert (
        error.problem
        == "the function `root` in `shape.py` returned nan at (-3, 0.5) and 1 further position(s)"
    )
    error = refused("shape.py:lift", folder, further=(np.inf,), shape=(2,))
    assert error.problem.startswith(
        "the function `lift` in `shape.py` returned [inf inf] at (1, 5) and inf"
    )


@pytest.mark.parametrize("shape", [(), (2,)])
def test_no_places_give_no_values_and_the_function_is_not_called(folder, shape):
    values = UserFunction("shape.py:fails", folder, shape=shape)(np.empty((0, 2)))
    assert values.shape == (0, *shape)
