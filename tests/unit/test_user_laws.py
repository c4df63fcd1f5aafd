# SPDX-License-Identifier: BSD-3-Clause
"""Laws of the user: each of the how-to's is the same as the core's, in whole runs and by itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from resumed_runs import assert_same_results
from small_problems import assert_same_bits, block_entries, plane
from user_laws import BUILT_IN, ELASTIC, LAWS, library, material

from tilth import BadInput, ElementCase, Model, UserPython, _core, element, resume, run
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.element_tests.check import check_tangents
from tilth.model.python_law import PythonLaw
from tilth.mpm.points import MaterialPoints
from tilth.output import read_results
from tilth.report.fields import field_values

every_law = pytest.mark.parametrize("law", LAWS)

STEPS = 3


def squeezed(soil: dict[str, Any], kind: str, basis: str = "gimp", **body: Any) -> dict[str, Any]:
    """A block that a rough plate squeezes and shears far beyond yielding."""
    vertical, across = ("z", {"x": 0.3, "y": 0.0}) if kind == "3d" else ("y", {"x": 0.3})
    if kind == "axisymmetric":
        across = {"x": 0.0}
    entries = block_entries(kind, basis, "von_mises", boundaries=[
        plane("base", vertical, 0.0, condition="fixed"),
        plane("top", vertical, 2.0, condition="prescribed",
              displacement={**across, vertical: -0.3}),
    ])  # fmt: skip
    entries["materials"]["soil"] = soil
    entries["bodies"][0] |= body
    return {**entries, "schedule": {"steps": STEPS}}


def final(entries: dict[str, Any]) -> tuple[MaterialPoints, int]:
    """Points at the end, and the number of Newton iterations."""
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    found = [simulation.advance(k / STEPS, (k + 1) / STEPS) for k in range(STEPS)]
    return simulation.state.points, sum(step.equilibrium.iterations for step in found)


@pytest.mark.slow
@every_law
@pytest.mark.parametrize(
    ("kind", "basis", "anti_locking"),
    [
        ("plane_strain", "gimp", "none"),
        ("plane_strain", "cpdi2", "f_bar"),
        ("axisymmetric", "linear", "none"),
        ("3d", "gimp", "f_bar"),
    ],
)
def test_a_run_is_that_of_the_law_of_the_core(
    law: str, kind: str, basis: str, anti_locking: str, tmp_path: Path
) -> None:
    expected, iterations = final(squeezed(BUILT_IN, kind, basis, anti_locking=anti_locking))
    soil = material(law, tmp_path)
    found, taken = final(squeezed(soil, kind, basis, anti_locking=anti_locking))
    assert expected.plastic[:, 0].min() > 0.01
    assert taken == iterations
    size = np.abs(expected.stress).max()
    np.testing.assert_allclose(found.stress, expected.stress, rtol=0, atol=1e-13 * size)
    np.testing.assert_allclose(found.plastic, expected.plastic, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.position, expected.position, rtol=0, atol=1e-13)
    assert found.stored_energy() == pytest.approx(expected.stored_energy(), rel=1e-12)
    strength = (found.state[:, 0] - 60.0) / 40.0 if "umat" not in law else found.state[:, 0]
    if anti_locking == "none":  # the smoothing of F-bar adds flow and its hardening alike
        np.testing.assert_allclose(strength, expected.plastic[:, 0], rtol=0, atol=1e-12)


def updated(law: str, folder: Path, trial: Floats) -> tuple[Floats, Floats, Floats]:
    """Stress, elastic strain and tangent of trial strains (n, 3) from the state at the start."""
    entries = squeezed(material(law, folder), "plane_strain")
    range_ = Simulation(Model.from_dict(entries)).state.points.ranges[0]
    n, k = len(trial), len(range_.law.state_variables)
    state, parameters = np.zeros((n, k)), range_.parameters
    assert parameters is not None
    given = range_.law.core, parameters
    assert _core.initial_state("3d", *given, np.zeros((n, 6)), state) == -1
    stress, elastic, tangent = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
    good, after = np.zeros(n, dtype=bool), state.copy()
    _core.principal_update(
        *given, trial, np.zeros((n, 2)), state, after, stress, elastic, tangent, good
    )
    assert good.all()
    return stress, elastic, tangent


@pytest.mark.slow
@every_law
def test_the_tangent_is_the_derivative_of_the_stress(law: str, tmp_path: Path) -> None:
    random = np.random.default_rng(4)
    trial = random.normal(size=(60, 3)) * 10.0 ** random.uniform(-2, 0, (60, 1))
    step = 1e-6
    _, elastic, tangent = updated(law, tmp_path, trial)
    flows = np.any(elastic != trial, axis=1)
    assert 10 < np.count_nonzero(flows) < 60, "both elastic and plastic points"
    for axis, direction in enumerate(step * np.eye(3)):
        ahead, behind = (updated(law, tmp_path, trial + sign * direction)[0] for sign in (1, -1))
        slope = (ahead - behind) / (2 * step)
        np.testing.assert_allclose(tangent[:, :, axis], slope, rtol=0, atol=1e-5 * 1000.0)


@pytest.mark.parametrize("law", ["user_python", "user_compiled", "umat_in_c"])
@pytest.mark.usefixtures("every_loop_in_parallel")
def test_the_same_bits_with_one_thread_and_with_two(law: str, tmp_path: Path) -> None:
    entries = squeezed(material(law, tmp_path), "plane_strain", anti_locking="f_bar")
    entries["grid"]["cell_size"] = 0.25
    found = []
    for threads in (1, 2, 2):
        _core.set_threads(threads)
        found.append(final(entries)[0])
    for other in found[1:]:
        assert_same_bits(found[0], other)


@every_law
def test_a_starting_stress(law: str, tmp_path: Path) -> None:
    stress = [-40.0, -60.0, -45.0, 5.0]
    initial = {"stress": [{"type": "given", "body": "block", "stress": stress}]}
    points = [
        Simulation(
            Model.from_dict({**squeezed(soil, "plane_strain"), "initial": initial})
        ).state.points
        for soil in (BUILT_IN, material(law, tmp_path))
    ]
    expected, found = (each.elastic_deformation for each in points)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-15)
    for each in points:
        np.testing.assert_allclose(each.elastic_moduli().bulk, 1000.0 / 1.2, rtol=1e-14)


@pytest.mark.slow
@every_law
def test_a_resumed_run_and_its_results(law: str, tmp_path: Path) -> None:
    """State variables by name: in the results with their unit, in colour_by and in the history."""
    entries = squeezed(material(law, tmp_path), "plane_strain", anti_locking="f_bar")
    name = "plastic_memory" if "umat" in law else "strength"
    entries["units"] = {"stress": "kPa"}
    entries["output"] = {"colour_by": name}
    at = {"at": [1.0, 1.0]}
    entries["track"] = [{"name": "soil", "quantity": "state", "variable": name, **at}]
    model = Model.from_dict(entries)
    whole = run(model, tmp_path / "whole", threads=1, quiet=True)
    run(model, tmp_path / "parts", threads=1, until=0.4, quiet=True)
    resume(tmp_path / "parts", threads=1, quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "parts")

    unit = "-" if "umat" in law else "kPa"
    results = read_results(tmp_path / "whole" / "results.vtkhdf")
    values, title = field_values(results.snapshot(len(results) - 1), name, results.units)
    assert title == f"{name.replace('_', ' ').capitalize()} [{unit}]"
    np.testing.assert_array_equal(values, whole.points.state[whole.points.point_id.argsort(), 0])
    heading = "soil [kPa]" if unit == "kPa" else "soil"
    assert values.min() <= whole.history[heading][-1] <= values.max()
    assert f"coloured by {name}" in (tmp_path / "whole" / "report.html").read_text("utf-8")


OWN_ELASTICITY = """
import numpy as np

class Elastic:
    def __init__(self, bulk, shear):
        self.bulk, self.shear = bulk, shear

    def update(self, trial, plastic_strain, state):
        assert plastic_strain.shape == (len(trial),) and state.shape == (len(trial), 0)
        volume = trial.sum(axis=1, keepdims=True)
        stress = self.bulk * volume + 2 * self.shear * (trial - volume / 3)
        tangent = self.bulk + 2 * self.shear * (np.eye(3) - 1 / 3)
        return stress, trial, np.tile(tangent, (len(trial), 1, 1)), state

    def moduli(self, strain, state):
        return self.bulk, np.full(len(strain), self.shear)

    def energy(self, strain, state):
        volume = strain.sum(axis=1)
        shape = strain - volume[:, None] / 3
        return self.bulk / 2 * volume**2 + self.shear * (shape**2).sum(axis=1)

    def elastic_strain(self, stress, state):
        mean = stress.mean(axis=1, keepdims=True)
        return mean / (3 * self.bulk) + (stress - mean) / (2 * self.shear)
"""


def test_a_python_class_can_have_its_own_elasticity(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(OWN_ELASTICITY, encoding="utf-8")
    soil = {
        "model": "user_python",
        "class": f"{tmp_path}/own.py:Elastic",
        "parameters": {"bulk": 1000.0 / 1.2, "shear": 1000.0 / 2.6},
    }
    initial = {"stress": [{"type": "given", "body": "block", "stress": [-4.0, -6.0, -4.0, 0.5]}]}
    elastic = {"model": "hencky_elastic", **ELASTIC}
    (expected, _), (found, _) = (
        final({**squeezed(each, "plane_strain"), "initial": initial}) for each in (elastic, soil)
    )
    size = np.abs(expected.stress).max()
    np.testing.assert_allclose(found.stress, expected.stress, rtol=0, atol=1e-13 * size)
    assert found.stored_energy() == pytest.approx(expected.stored_energy(), rel=1e-13)
    moduli, wanted = found.elastic_moduli(), expected.elastic_moduli()
    np.testing.assert_allclose(moduli.young, wanted.young, rtol=1e-14)


C_FUNCTION = """
int law(const double *parameters, const double *trial, double plastic_strain,
        const double *state_before, double *state, double *kirchhoff, double *elastic,
        double *tangent) {
  const double bulk = parameters[0] / (3 * (1 - 2 * parameters[1]));
  const double shear = parameters[0] / (2 * (1 + parameters[1]));
  const double volume = trial[0] + trial[1] + trial[2];
  for (int a = 0; a < 3; ++a) {
    elastic[a] = trial[a];
    kirchhoff[a] = bulk * volume + 2 * shear * (trial[a] - volume / 3);
    for (int b = 0; b < 3; ++b)
      tangent[3 * a + b] = bulk + 2 * shear * ((a == b) - 1.0 / 3);
  }
  return parameters[2] == 7 && state[0] == state_before[0] ? 0 : 1;
}
"""


def test_a_function_in_c(tmp_path: Path) -> None:
    """By `ctypes`, as the how-to says; `state` holds the state before."""
    made = library(tmp_path, C_FUNCTION, "law")
    (tmp_path / "c.py").write_text(f"import ctypes\nlaw = ctypes.CDLL({str(made)!r}).law\n")
    soil = {
        "model": "user_compiled",
        "function": f"{tmp_path}/c.py:law",
        **ELASTIC,
        "parameters": [7.0],
        "state_variables": 1,
    }
    expected, _ = final(squeezed({"model": "hencky_elastic", **ELASTIC}, "plane_strain"))
    found, _ = final(squeezed(soil, "plane_strain"))
    size = np.abs(expected.stress).max()
    np.testing.assert_allclose(found.stress, expected.stress, rtol=0, atol=1e-13 * size)
    assert found.state_variables() == ["plastic_strain", "state_1"]


def test_declared_in_python_it_is_the_same_model(tmp_path: Path) -> None:
    """The key `class` is `class_` there; a stored model has the keys of a case file."""
    entries = material("user_python", tmp_path)
    soil = UserPython(
        class_=entries["class"], parameters=entries["parameters"], density=entries["density"]
    )
    model = Model.from_dict(squeezed(entries, "plane_strain"))
    assert model.materials["soil"] == soil == soil.model_copy(update={"density": 2.0})
    stored = model.to_dict()
    assert stored["materials"]["soil"] == entries
    assert Model.from_dict(stored) == model


def test_the_moduli_of_a_python_class_are_positive(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(OWN_ELASTICITY, encoding="utf-8")
    law = PythonLaw(f"{tmp_path}/own.py:Elastic", {"bulk": -1.0, "shear": 1.0}, "materials.soil")
    with pytest.raises(BadInput, match="`moduli` of the law `Elastic`"):
        law.moduli(np.zeros((2, 3)), np.zeros((2, 0)))


@every_law
def test_element_tests_and_their_tangents(law: str, tmp_path: Path) -> None:
    """`tilth element` uses the law as an analysis does, and `--check` its tangent."""
    names = ["core", "own"]
    common = {"material": names, "start": {"isotropic": 10.0}, "steps": 12}
    triaxial = {"type": "triaxial", "drainage": "drained", "direction": "compression"}
    tests = [
        {**common, "name": "triaxial", **triaxial, "axial_strain": 0.2},
        {**common, "name": "shear", "type": "simple_shear", "drainage": "undrained",
         "shear_strain": 0.3},
    ]  # fmt: skip
    materials = dict(zip(names, (BUILT_IN, material(law, tmp_path)), strict=True))
    case = ElementCase.from_dict({"materials": materials, "tests": tests})
    found = element(case)
    for expected, own in (found[:2], found[2:]):
        assert not own.stopped
        assert own.columns["plastic_strain"][-1] > 0.05
        for column, values in expected.columns.items():
            np.testing.assert_allclose(own.columns[column], values, rtol=1e-10, atol=1e-10)
    assert all(check.passed for check in check_tangents(case))


def test_an_elastic_modulus_that_varies(tmp_path: Path) -> None:
    """Of a compiled function it varies from point to point; a UMAT has its own constants."""
    by_height = {"axis": "y", "values": [[0.0, 500.0], [2.0, 1500.0]]}
    given = {"young_modulus": by_height}
    expected, _ = final(squeezed({**BUILT_IN, **given}, "plane_strain"))
    own = material("user_compiled", tmp_path, **given)
    found, _ = final(squeezed(own, "plane_strain"))
    size = np.abs(expected.stress).max()
    np.testing.assert_allclose(found.stress, expected.stress, rtol=0, atol=1e-12 * size)
    with pytest.raises(BadInput, match=r"materials\.soil: .* with the stress"):
        final(squeezed(material("umat_in_c", tmp_path, **given), "plane_strain"))
