# SPDX-License-Identifier: BSD-3-Clause
"""Random calls of all functions and classes of the compiled core.

Valid calls are recorded while small problems are computed; then their arguments are changed at
random. Each call must return or raise an ordinary exception. From a checkout:

    PYTHONPATH=tests python -m fuzz.core_calls 2000 --seed 1
"""

from __future__ import annotations

import argparse
import contextlib
import copy
import dataclasses
import faulthandler
import inspect
import re
from collections import defaultdict
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
from implicit_blocks import flat, implicit
from implicit_blocks import model_of as implicit_model
from small_problems import BASES, KINDS, block_entries, dimension, parameters, rollers, weight

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.grid.background import Grid
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.point_integrals import PointIntegrals

ORDINARY = (ValueError, TypeError, IndexError)
KEPT = 6
"""Calls of a function that are kept; of different problems, as far as possible."""


@dataclasses.dataclass
class Call:
    """A call of a function, or the creation of an object with the calls of its methods.

    Attributes:
        name: of the function or class.
        arguments: in order; for a class those of its constructor.
        methods: names and arguments of the methods called afterwards.
    """

    name: str
    arguments: list[Any]
    methods: list[tuple[str, list[Any]]] = dataclasses.field(default_factory=list)

    def make(self) -> Any:
        """Calls the function, or creates the object and calls its methods; returns the result."""
        result = getattr(_core, self.name)(*self.arguments)
        for method, arguments in self.methods:
            getattr(result, method)(*arguments)
        return result


def names() -> list[str]:
    """Names of the functions and classes of the core."""
    return [name for name in dir(_core) if not name.startswith("_")]


def written(name: str) -> list[list[int]]:
    """For each signature of a function, the positions of the arrays that it writes."""
    found = []
    for line in (getattr(_core, name).__doc__ or "").splitlines():
        if match := re.search(rf"\b{name}\((.*)\) ->", line):
            kinds = re.findall(r"(\w+): (ndarray\[[^\]]*\]|[^,\[]+(?:\[[^\]]*\])?)", match[1])
            found.append([
                i for i, (_, kind) in enumerate(kinds)
                if kind.startswith("ndarray") and "writable=False" not in kind
            ])  # fmt: skip
    return found


def plain(argument: Any) -> Any:
    """A copy of an argument; objects become namespaces of copies, whose fields can be changed."""
    if dataclasses.is_dataclass(argument):
        fields = {f.name: getattr(argument, f.name) for f in dataclasses.fields(argument)}
        if hasattr(argument, "boxed"):
            fields["boxed"] = argument.boxed
        return SimpleNamespace(**{name: plain(value) for name, value in fields.items()})
    return copy.deepcopy(argument)


class Recorder:
    """Takes the place of the core's functions while problems are computed."""

    def __init__(self) -> None:
        self.calls: dict[str, list[Call]] = defaultdict(list)
        self._seen: set[tuple[Any, ...]] = set()

    def keep(self, call: Call) -> None:
        """Keeps a call if it differs in kind from those that are kept."""
        shapes = [
            argument if isinstance(argument, (str, bool)) else getattr(argument, "shape", (0,))[1:]
            for argument in call.arguments
        ]
        kind = (call.name, *shapes)
        if kind not in self._seen or len(self.calls[call.name]) < KEPT:
            self._seen.add(kind)
            self.calls[call.name].append(call)

    def function(self, name: str, original: Callable[..., Any]) -> Callable[..., Any]:
        """Returns a function that keeps its calls."""

        def recorded(*arguments: Any) -> Any:
            self.keep(Call(name, [plain(argument) for argument in arguments]))
            return original(*arguments)

        return recorded

    def type(self, name: str, original: type) -> type:
        """Returns a class whose objects keep the calls of their methods."""
        recorder = self

        class Recorded:
            def __init__(self, *arguments: Any) -> None:
                self._object = original(*arguments)
                self._call = Call(name, [plain(argument) for argument in arguments])
                recorder.keep(self._call)

            def __getattr__(self, method: str) -> Callable[..., Any]:
                def recorded(*arguments: Any) -> Any:
                    if len(self._call.methods) < KEPT:
                        self._call.methods.append((method, [plain(a) for a in arguments]))
                    return getattr(self._object, method)(*arguments)

                return recorded

        return Recorded


@contextlib.contextmanager
def recording() -> Iterator[Recorder]:
    """Replaces the functions and classes of the core by ones that keep their calls."""
    recorder, originals = Recorder(), {name: getattr(_core, name) for name in names()}
    try:
        for name, original in originals.items():
            is_type = inspect.isclass(original)
            setattr(_core, name, (recorder.type if is_type else recorder.function)(name, original))
        yield recorder
    finally:
        for name, original in originals.items():
            setattr(_core, name, original)


def models() -> Iterator[Model]:
    """Small problems that together call almost all functions of the core."""
    for kind in KINDS:
        for basis in BASES:
            dim, corners = dimension(kind), basis.startswith("cpdi")
            entries = block_entries(kind, basis, "von_mises")
            entries["boundaries"] = rollers(kind, sides=False)
            entries["loads"] = [weight(kind, 40.0)]
            entries["bodies"][0]["anti_locking"] = "f_bar"
            entries["materials"]["soil"]["saturated_density"] = 2.5
            entries["water"] = {
                "level": 1.3,
                "unit_weight": 10.0,
                "factor": [[0.0, 0.0], [1.0, 1.0]],
            }
            if basis == "gimp":
                entries["bodies"][0]["domain_update"] = "corners"
            if basis == "linear":
                entries["units"] = {"length": "m", "force": "N", "time": "s"}
                entries["analysis"]["inertia"] = {"scheme": "newmark"}
                entries["schedule"]["end"] = 1.0
            if kind != "axisymmetric" and not corners:
                entries["analysis"]["solver"] = "multigrid" if kind == "3d" else "banded"
            yield Model.from_dict(entries)
    for kind in ("plane_strain", "3d"):
        for basis in ("gimp", "cpdi2"):
            dim = dimension(kind)
            shape = {"type": "box", "lower": [0.1] * dim, "upper": [1.1] * dim}
            below = implicit("below", flat([0.1] * dim, np.eye(dim)[-1].tolist()))
            side = [
                implicit(f"side {k}", flat([0.1] * dim, np.eye(dim)[k].tolist()))
                for k in range(dim - 1)
            ]
            loads = [weight(kind, 9.0)]
            yield implicit_model(kind, basis, shape, [below, *side], 1, loads=loads)


def valid_calls() -> dict[str, list[Call]]:
    """Valid calls of every function and class of the core, by name."""
    with recording() as recorder:
        for model in models():
            simulation = Simulation(model)
            active = simulation.advance(0.0, 0.3).active
            use_point_integrals(active)
            simulation.advance(0.3, 0.6)
            active.stencils[0].basis()
            simulation.state.points.stored_energy()
            _ = simulation.state.points.elastic_strain
            simulation.state.points.elastic_strain = simulation.state.points.elastic_strain
    calls = {name: list(kept) for name, kept in recorder.calls.items() if kept}
    for call in [*direct_calls(), *dense_calls(calls["add_scaled_blocks"])]:
        calls.setdefault(call.name, []).append(call)
    return calls


def use_point_integrals(active: ActiveGrid) -> None:
    """Calls what a field of one component and one of all directions need from the points."""
    integrals, dim = PointIntegrals(active), active.grid.dim
    for r in (1, dim):
        integrals.scattered_gradient(integrals.gradient(np.ones((active.nodes, r))))
        for c in (1, dim):
            matrices = np.ones((len(active.points), r, 1 + dim, c, 1 + dim))
            blocks = np.zeros((len(active.column), r, c))
            integrals.add_blocks(active.block_positions, matrices, blocks)


def dense_calls(scaled: list[Call]) -> Iterator[Call]:
    """Calls for dense elements, on the elements of calls for scaled ones."""
    for call in scaled:
        elements, _, unit, _, free, blocks = call.arguments
        components = blocks.shape[1]
        matrix = np.ones((*free.shape[:2], unit.shape[2], components, components))
        vectors = [np.zeros((int(elements.node.max(initial=0)) + 1, components)) for _ in range(2)]
        yield Call("add_dense_blocks", [elements, matrix, blocks])
        yield Call("add_dense_products", [elements, matrix, vectors[0], False, vectors[1]])
        row = np.ones((len(elements.node), components))
        yield Call("add_outer_blocks", [elements, row, row.copy(), blocks])


def direct_calls() -> Iterator[Call]:
    """Calls of the functions that problems do not call, or not as they are called here."""
    random = np.random.default_rng(1)
    law, state, tensor = parameters("von_mises"), np.zeros((3, 0)), 1e-2 * random.random((3, 6))
    queries = ("threads", "parallel_from", "basis_names", "corner_basis_names", "materials")
    for name in (*queries, "Checked"):
        yield Call(name, [])
    yield Call("shape_functions", [random.random((4, 2)), np.full((4, 2), 0.5)])
    yield Call("set_threads", [2])
    yield Call("set_parallel_from", [0])
    yield Call("UserCode", ["a law"], [("__enter__", []), ("__exit__", [None, None, None])])
    yield Call("set_user_code_note", ["", -1])
    for basis in ("linear", "gimp"):
        position, keys = 4.0 * random.random((5, 2)), np.zeros(5, dtype=np.int64)
        half = np.full((5, 2), 0.2)
        yield Call("support_keys", [basis, position, half, Grid(np.zeros(2), np.ones(2)), keys])
    yield Call("volumetric_strains", [tensor])
    yield Call("elastic_deformation_of", ["3d", "von_mises", law, tensor, state, tensor.copy()])
    yield Call("elastic_moduli", [
        "3d", "von_mises", law, tensor, state, np.zeros(3), np.zeros(3), np.zeros(3)
    ])  # fmt: skip
    yield Call("return_to_law", [
        "3d", "von_mises", law, tensor, np.zeros((3, 2)), state, tensor.copy(), np.zeros((3, 2)),
        state.copy(), np.zeros((3, 6)), np.zeros(3, dtype=bool),
    ])  # fmt: skip
    yield Call("initial_state", ["3d", "von_mises", law, tensor, state.copy()])
    yield Call("update_of_gradients", [
        "3d", "von_mises", law, 1e-2 * random.random((3, 3, 3)), tensor, np.zeros((3, 2)), state,
        tensor.copy(), np.zeros((3, 2)), state.copy(), np.zeros((3, 6)), np.zeros((3, 6, 9)),
        np.array([0.0, 1.0, 0.5]),
    ])  # fmt: skip
    yield Call("principal_update", [
        "von_mises", law, tensor[:, :3].copy(), np.zeros((3, 2)), state, state.copy(),
        np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 9)), np.zeros(3, dtype=bool),
    ])  # fmt: skip
    start, row = np.array([0, 2, 4], dtype=np.int32), np.array([0, 1, 0, 1], dtype=np.int32)
    value, x = np.array([4.0, 1.0, 1.0, 3.0]), np.ones(2)
    yield Call("column_product", [start, row, value, x, np.zeros(2)])
    solve = ("solve", [x, np.zeros(2)])
    yield Call("BandFactors", [start, row], [("widths", []), ("factorise", [value]), solve])
    rows, column, blocks = start.astype(np.int64), row.copy(), value[:, None, None].copy()
    free = np.zeros((2, 1), dtype=bool)
    vectors = [x[:, None].copy() for _ in range(2)]
    yield Call("block_product", [1, rows, column, blocks, free, *vectors])
    yield Call("asymmetry", [1, rows, column, blocks, free, *vectors])
    yield Call("connected_parts", [rows, column])
    pair = [x[:, None].repeat(2, axis=1) for _ in range(2)]
    yield Call("symmetric_product", [rows, column, value, *pair])
    known, right = np.zeros((2, 4), dtype=bool), np.ones((2, 4))
    yield Call("project", [rows, column, value, 0.0, known, 1e-6, 20, right.copy(), right])
    line = np.array([[0, 0, 0], [1, 0, 0]])
    cycle = ("cycle", [vectors[0], vectors[1].copy()])
    rest = [("sizes", []), ("bytes", []), ("begin", [])]
    yield Call("Multigrid", [2, 1, line, rows, column, free], [("fill", [blocks]), cycle, *rest])
    coarse = _core.CoarsePart(2, 1, line, rows, column, free, ~free.ravel()).pattern()[0]
    yield Call(
        "CoarsePart", [2, 1, line, rows, column, free, ~free.ravel()],
        [
            ("pattern", []), ("blocks", [blocks]), ("restricted", [vectors[0]]),
            ("interpolated", [np.zeros((len(coarse), 1))]),
        ],
    )  # fmt: skip
    half, corner = np.full((3, 2), 0.2), random.random((3, 4, 2)) - 0.5
    for corners in (corner, np.zeros((0, 4, 2))):
        at, normal = [2.0 * random.random((3, 2)) for _ in range(2)], np.tile([0.6, -0.8], (3, 1))
        yield Call("measure_gap", [
            at[0], normal, np.full(3, 0.5), 1.5, at[1], half, corners,
            Grid(np.zeros(2), np.ones(2)), 0.05,
        ])  # fmt: skip
    two, place = np.arange(2), np.full((2, 2), 0.5)
    yield Call("trace_of_domains", [
        np.array([0, 1, 2]), place + 0.1, two, 0 * two, place, 0.3 * corner[:2],
        Grid(np.zeros(2), np.ones(2)), _core.node_keys(np.zeros((1, 3), dtype=np.int64)),
        _core.node_keys(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])),
        np.array([0, 2]), np.array([[0, 1, 2, 3]], dtype=np.int32), random.random((2, 4)),
    ])  # fmt: skip
    yield Call("inner", [x, x.copy()])
    yield Call("two_inner", [x, x.copy(), x.copy()])
    yield Call("combine", [1.0, x, 2.0, x.copy()])
    yield Call("advance", [0.5, x, x.copy(), x.copy(), x.copy()])
    yield Call("gather", [np.array([1, 0]), x, np.zeros(2)])
    yield Call("scatter_in_cells", [
        np.array([0, 2]), np.array([[0, 1, 2, 3]], dtype=np.int32), random.random((2, 4)),
        random.random((2, 2)), np.zeros((4, 2)),
    ])  # fmt: skip
    for rule in ("determinant", "deformation_gradient", "right_stretch", "left_stretch"):
        gradient, half = np.tile(np.eye(3), (3, 1, 1)), np.full((3, 2), 0.2)
        yield Call("stretch_domains", ["plane_strain", rule, gradient, half, half.copy()])


def changed_array(array: np.ndarray, random: np.random.Generator) -> Any:
    """An array with other entries, number of entries, shape, order or type."""
    array, kind = array.copy(), int(random.integers(14))
    if kind <= 4 and array.size:  # some entries
        at = random.integers(array.size, size=1 + int(random.integers(3)))
        if array.dtype.kind == "f":
            special = [np.nan, np.inf, -np.inf, 1e300, -1e300, 0.0, -1.0, 1e9]
            with np.errstate(all="ignore"):
                array.flat[at] = random.choice(special)
        elif array.dtype.kind == "b":
            array.flat[at] = ~array.flat[at]
        else:
            limits = np.iinfo(array.dtype)
            numbers = [-1, 0, 1, 2, array.size, 2**20, 2**31 - 1, limits.min, limits.max]
            array.flat[at] = np.clip(random.choice(numbers), limits.min, limits.max)
        return array
    if kind == 5 and array.size:  # all entries
        return random.permutation(array.ravel()).reshape(array.shape)
    choices: list[Callable[[], Any]] = [
        lambda: array[:-1].copy() if array.ndim else array,
        lambda: np.concatenate([array, array]) if array.ndim else array,
        lambda: array[:0].copy() if array.ndim else array,
        lambda: array.ravel(),
        lambda: array[..., None],
        lambda: np.asfortranarray(array) if array.ndim > 1 else np.repeat(array, 2)[::2],
        lambda: array.astype(random.choice([np.float32, np.int16, np.float64, np.int64, bool])),
        lambda: np.array(array.flat[0] if array.size else 0, dtype=array.dtype),
        lambda: np.zeros((0,) * int(random.integers(1, 4)), dtype=array.dtype),
        lambda: array.T,
        lambda: array.tolist(),
        lambda: None,
    ]
    with np.errstate(all="ignore"):
        return choices[int(random.integers(len(choices)))]()


def changed_argument(argument: Any, random: np.random.Generator) -> Any:
    """An argument of the same or another type with another value."""
    if isinstance(argument, np.ndarray):
        return changed_array(argument, random)
    if isinstance(argument, SimpleNamespace) and vars(argument):
        fields = vars(argument)
        name = list(fields)[int(random.integers(len(fields)))]
        return SimpleNamespace(**{**fields, name: changed_argument(fields[name], random)})
    choices: list[Any]
    if isinstance(argument, bool):
        choices = [not argument, None, 2]
    elif isinstance(argument, int):
        choices = [-1, 0, 1, argument + 1, 4, 7, 2**31 - 1, -(2**31), 2**63 - 1, 2**100, 1.5, None]
    elif isinstance(argument, float):
        choices = [np.nan, np.inf, -1e300, 0.0, None, "1"]
    elif isinstance(argument, str):
        choices = ["", "other", "3d", "plane_strain", "axisymmetric", "gimp", "a" * 1000, None, 1]
    else:
        choices = [None, 0, "", np.zeros(3), SimpleNamespace()]
    return choices[int(random.integers(len(choices)))]


def make_fixed(argument: Any) -> None:
    """Makes the index arrays of an object read-only."""
    if isinstance(argument, SimpleNamespace):
        for array in vars(argument).values():
            if isinstance(array, np.ndarray) and array.dtype.kind == "i":
                array.flags.writeable = False


def changed_call(call: Call, random: np.random.Generator) -> Call:
    """A copy of a call with one to three changes, in its arguments or those of its methods."""
    call = copy.deepcopy(call)
    if random.random() < 0.3:  # as in a step: the core has checked its objects before
        for argument in call.arguments:
            make_fixed(argument)
        call.make()
    for _ in range(1 + int(random.integers(3))):
        lists = [call.arguments, *(arguments for _, arguments in call.methods)]
        arguments = lists[int(random.integers(len(lists)))]
        what = int(random.integers(10))
        if what == 0 and call.methods:  # methods in another order, or not all of them
            order = random.integers(len(call.methods), size=len(call.methods))
            call.methods = [copy.deepcopy(call.methods[i]) for i in order]
        elif what == 1 and len(arguments) > 1:
            i, j = random.choice(len(arguments), 2, replace=False)
            arguments[i], arguments[j] = arguments[j], arguments[i]
        elif what == 2 and arguments:
            arguments.pop(int(random.integers(len(arguments))))
        elif arguments:
            i = int(random.integers(len(arguments)))
            arguments[i] = changed_argument(arguments[i], random)
    return call


def make_random_calls(
    calls: dict[str, list[Call]], number: int, seed: int, show: bool = False
) -> tuple[int, int]:
    """Makes changed calls of all functions in turn; returns how many returned and how many raised.

    Other than ordinary exceptions are not caught.
    """
    random, order = np.random.default_rng(seed), sorted(calls)
    threads, parallel_from = _core.threads(), _core.parallel_from()
    returned = raised = 0
    try:
        for i in range(number):
            own = calls[order[i % len(order)]]
            call = changed_call(own[int(random.integers(len(own)))], random)
            if show:
                print(i, call.name, flush=True)
            _core.set_threads(2)
            _core.set_parallel_from(0)
            try:
                with np.errstate(all="ignore"):
                    call.make()
                returned += 1
            except ORDINARY:
                raised += 1
    finally:
        _core.set_threads(threads)
        _core.set_parallel_from(parallel_from)
    return returned, raised


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("calls", type=int, help="number of calls")
    parser.add_argument("--seed", type=int, default=1, help="of the random numbers")
    parser.add_argument("--show", action="store_true", help="print each function before its call")
    given = parser.parse_args()
    faulthandler.enable()
    returned, raised = make_random_calls(valid_calls(), given.calls, given.seed, given.show)
    print(f"{given.calls} calls: {returned} returned, {raised} raised an ordinary exception")


if __name__ == "__main__":
    main()
