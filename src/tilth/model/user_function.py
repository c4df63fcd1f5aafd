# SPDX-License-Identifier: BSD-3-Clause
"""Functions of the user in a Python file, named in the case file as `file.py:name`."""

from __future__ import annotations

import hashlib
import os
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from tilth import _core
from tilth.arrays import Floats
from tilth.environment import USER_MODULE
from tilth.errors import BadInput
from tilth.input_files import absolute, why_no_file
from tilth.model.problems import suggestion

FAILURES = (Exception, SystemExit, GeneratorExit)
"""What code of the user may raise, without the requests to stop."""


def real_numbers(value: Any) -> Floats:
    """Returns what code of the user gave as an array of its own, of the dtype float64.

    Raises:
        TypeError, ValueError: it is none of real numbers; the text says what it is.
    """
    if np.ma.is_masked(value):
        raise TypeError("an array with masked entries")
    try:
        array = np.asarray(value)
    except Exception:
        array = np.asarray(None)
    if array.dtype.kind not in "fiub":
        kind = "a list of unlike entries" if array.dtype == object else f"{array.dtype} numbers"
        kind = kind if isinstance(value, np.ndarray | np.generic) else f"a {type(value).__name__}"
        raise TypeError(kind)
    return np.array(array, dtype=np.float64, order="C")


def load_function(
    reference: str, folder: str | Path, *, key: str = "function"
) -> Callable[..., Any]:
    """Returns the function with the name `reference`.

    reference: `file.py:name`; the file's path is absolute or relative to `folder`.
    key: key of the reference in the case file, for messages.
    Raises BadInput as `load_name`, and for a name that is not a function.
    """
    function = load_name(reference, folder, key=key)
    if not callable(function):
        file, _, name = reference.rpartition(":")
        raise BadInput(
            f"`{name}` in `{Path(file).name}` is a {type(function).__name__}, not a function",
            f"define it as a function: `def {name}(x): ...`",
            key=key,
            value=reference,
        )
    return function  # type: ignore[no-any-return]


def load_name(reference: str, folder: str | Path, *, key: str, what: str = "function") -> Any:
    """Returns what has the name `reference` in a Python file of the user.

    reference, folder, key: as in `load_function`.
    what: what the name should be, for messages.
    Each call runs the file again, under a separate module name. Python's module search path is not
    changed, and nothing is written to the folder of the file.
    Raises BadInput for a reference of another form, a file that is missing or fails when it is
    run, and a name that is missing.
    """
    file, colon, name = reference.rpartition(":")
    if not colon or not file or not name.isidentifier():
        raise BadInput(
            f"does not name a {what} in a Python file",
            f"write the file, a colon and the {what}'s name, such as `shape.py:distance`",
            key=key,
            value=reference,
        )
    path = absolute(Path(folder) / file)
    module = _run(path, key, reference)
    if not hasattr(module, name):
        raise BadInput(
            f"`{path.name}` has no {what} `{name}`",
            _remedy_for_name(name, module, what),
            key=key,
            value=reference,
        )
    return getattr(module, name)


class UserFunction:
    """A function of positions, loaded from its file, whose results are checked at every call.

    reference, folder, key: as in `load_function`; raises BadInput in the same cases.
    shape: of the value at one position: () for a number, (dim,) for a vector.
    where: places at which it must have a value, for messages.
    """

    def __init__(
        self,
        reference: str,
        folder: str | Path = ".",
        *,
        key: str = "function",
        shape: tuple[int, ...] = (),
        where: str = "in the grid and one cell around it, also far from the boundary",
    ) -> None:
        self.reference = reference
        self.key = key
        self.shape = shape
        self._where = where
        self._function = load_function(reference, folder, key=key)
        file, _, name = reference.rpartition(":")
        self._name = f"the function `{name}` in `{Path(file).name}`"

    def __call__(self, places: Floats, *further: Any) -> Floats:
        """Returns the function's values at the positions `places` (n, dim), shape (n, *shape).

        further: additional arguments, such as the load factor.
        Raises BadInput if the function raises an exception, or returns an array of another shape,
        no numbers, or a value that is not finite.
        """
        wanted = (len(places), *self.shape)
        if not len(places):  # as on one process of several; the function may not expect it
            return np.empty(wanted)
        try:
            # values that are not finite are refused below
            with _core.UserCode(f"{self._name} ({self.key})"), np.errstate(all="ignore"):
                result = self._function(places.copy(), *further)
        except FAILURES as error:
            raise self._refused(
                f"{self._name} failed: {described(error, file_of(self._function))}",
                f"it must accept any array of positions, shape (n, {places.shape[1]})",
            ) from error
        try:
            values = real_numbers(result)
        except (TypeError, ValueError) as error:
            raise self._refused(
                f"{self._name} returned {error}, not an array of real numbers",
                self._remedy_for_shape(places.shape[1]),
            ) from error
        if values.shape != wanted:
            raise self._refused(
                f"{self._name} returned an array of shape {values.shape} for {len(places)} "
                f"positions, not {wanted}",
                self._remedy_for_shape(places.shape[1]),
            )
        bad = np.flatnonzero(~np.isfinite(values.reshape(len(places), -1)).all(axis=1))
        if len(bad):
            place = ", ".join(f"{c:.6g}" for c in places[bad[0]])
            with_further = "".join(f" and {value!r}" for value in further)
            more = f" and {len(bad) - 1} further position(s)" if len(bad) > 1 else ""
            raise self._refused(
                f"{self._name} returned {values[bad[0]]} at ({place}){with_further}{more}",
                f"it must return a finite number everywhere {self._where}",
            )
        return values

    def _remedy_for_shape(self, dimension: int) -> str:
        number = " ".join(str(n) for n in self.shape) or "one"
        shape = ", ".join(["n", *(str(n) for n in self.shape)]) + ("" if self.shape else ",")
        example = "0.1 * x" if self.shape else "x[:, 1] - 2.0"
        return (
            f"return {number} number{'s' if self.shape else ''} per position: for positions x of "
            f"shape (n, {dimension}) an array of shape ({shape}), such as `{example}`"
        )

    def _refused(self, problem: str, remedy: str) -> BadInput:
        return BadInput(problem, remedy, key=self.key, value=self.reference)


def _run(path: Path, key: str, reference: str) -> ModuleType:
    """Runs the file at `path` and returns its module."""
    if reason := why_no_file(path):
        what = f"cannot be run: {reason}" if os.path.lexists(path) else "there is no such file"
        raise BadInput(
            f"`{path}`: {what}",
            _remedy_for_file(path),
            key=key,
            value=reference,
        )
    # Compiled here, not imported, to neither use nor write a `__pycache__` beside the user's file.
    digest = hashlib.sha256(str(path).encode()).hexdigest()[:16]
    module = ModuleType(f"{USER_MODULE}{path.stem}_{digest}")
    module.__file__ = str(path)
    sys.modules[module.__name__] = module  # dataclasses need their module there
    try:
        with _core.UserCode(f"`{path.name}` ({key})"):
            exec(compile(path.read_bytes(), str(path), "exec", dont_inherit=True), module.__dict__)
    except FAILURES as error:
        del sys.modules[module.__name__]
        raise BadInput(
            f"`{path.name}` fails when it is run: {described(error, str(path))}",
            _remedy_for_failure(error),
            key=key,
            value=reference,
        ) from error
    return module


def _remedy_for_failure(error: BaseException) -> str:
    if isinstance(error, ModuleNotFoundError) and error.name:
        package = error.name.partition(".")[0]
        return f"install the missing package into the Python of tilth: pip install {package}"
    return "correct the file; try it with `python` by itself"


def described(error: BaseException, file: str | None) -> str:
    """Returns the exception in one line, with the last line of `file` in its traceback."""
    text = " ".join(str(error).split())
    line: int | None = None
    if isinstance(error, SyntaxError) and error.filename == file:
        text, line = str(error.msg), error.lineno
    else:
        for frame in traceback.extract_tb(error.__traceback__):
            if frame.filename == file:
                line = frame.lineno
    where = f" (line {line} of `{Path(file).name}`)" if file and line is not None else ""
    return f"{type(error).__name__}{': ' if text else ''}{text}{where}"


def file_of(function: Callable[..., Any]) -> str | None:
    """Returns the file that defines `function`, or the class of an object with `__call__`."""
    module = sys.modules.get(getattr(function, "__module__", None) or "")
    code = getattr(function, "__code__", None)
    return code.co_filename if code is not None else getattr(module, "__file__", None)


def _remedy_for_name(name: str, module: ModuleType, what: str) -> str:
    known = [n for n, value in vars(module).items() if callable(value) and not n.startswith("_")]
    likely = suggestion(name, known)
    if likely:
        return f"did you mean `{likely}`?"
    plural = "classes" if what == "class" else f"{what}s"
    return f"{plural} there: {', '.join(f'`{n}`' for n in known) or 'none'}"


def _remedy_for_file(path: Path) -> str:
    beside = [p.name for p in path.parent.glob("*.py")] if path.parent.is_dir() else []
    likely = suggestion(path.name, beside)
    if likely:
        return f"did you mean `{likely}`?"
    return "check the name; a path is absolute or relative to the folder of the case file"
