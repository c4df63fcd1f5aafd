# SPDX-License-Identifier: BSD-3-Clause
"""The samples of a study: places in the case, combinations, draws, and what is refused."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tilth import BadInput, HistoryOutcome, Place, Study
from tilth.case import case_entries, load_study
from tilth.studies.key_paths import changed, value_at
from tilth.studies.outcomes import value_of
from tilth.studies.samples import make_samples, values_of_samples
from tilth.studies.statistics import running_mean, statistics

EXAMPLE = Path(__file__).parents[2] / "examples" / "random_field_slope"
OUTCOMES = [{"type": "history", "name": "s", "column": "settlement of the crest"}]


def study(*vary: dict[str, Any], **entries: Any) -> Study:
    return Study.from_dict({"format": 1, "vary": list(vary), "outcomes": OUTCOMES, **entries})


@pytest.fixture(scope="module")
def case() -> dict[str, Any]:
    return case_entries(EXAMPLE / "case.toml")


def test_places_are_named_by_key_name_and_number(case: dict[str, Any]) -> None:
    for key in ("bodies.slope.points_per_cell", "bodies.0.points_per_cell"):
        assert changed(case, key, 3)["bodies"][0]["points_per_cell"] == 3
    assert case["bodies"][0]["points_per_cell"] == 2  # a copy was changed
    weight = changed(case, "loads.0.acceleration.1", -5.0)["loads"][0]["acceleration"]
    assert weight == [0.0, -5.0]
    assert value_at(case, "boundaries.left.axis") == "x"
    assert value_at(case, "analysis.tolerance") is None


@pytest.mark.parametrize(
    ("key", "remedy"),
    [
        ("materials.caly.density", "did you mean `clay`?"),
        ("bodies.slop.points_per_cell", "did you mean `slope`?"),
        ("bodies.1.points_per_cell", "there are: slope, 0"),
        ("materials.clay.densty", "did you mean `density`?"),
        ("materials.clay.density.mean", "leave out what follows it"),
        ("grid.cell_sise", "did you mean `cell_size`?"),
    ],
)
def test_a_misspelt_key_gives_a_near_name(case: dict[str, Any], key: str, remedy: str) -> None:
    with pytest.raises(BadInput) as caught:
        make_samples(study({"key": key, "values": [1.0]}), case)
    assert remedy in str(caught.value)


def test_every_sample_is_validated_before_any_runs(case: dict[str, Any]) -> None:
    wrong = study({"key": "materials.clay.density", "name": "rho", "values": [1e3, 2e3, -1e3]})
    with pytest.raises(BadInput, match=r"sample 3: rho = -1000\.0") as caught:
        make_samples(wrong, case)
    assert caught.value.key == "materials.clay.density"


def test_grids_and_zipped_lists() -> None:
    first = {"key": "a", "values": [1, 2]}
    second = {"key": "b", "range": {"start": 1, "stop": 100, "count": 3, "spacing": "log"}}
    assert values_of_samples(study(first, second)) == [
        (1, 1), (1, 10), (1, 100), (2, 1), (2, 10), (2, 100),
    ]  # fmt: skip
    third = {"key": "b", "range": {"start": 0.0, "stop": 0.5, "count": 2}}
    assert values_of_samples(study(first, third, combine="zip")) == [(1, 0.0), (2, 0.5)]
    with pytest.raises(BadInput, match="they have 2, 3"):
        study(first, second, combine="zip")


@pytest.mark.parametrize("kind", ["normal", "lognormal"])
def test_draws_have_the_declared_mean_and_deviation(kind: str) -> None:
    drawn = {"type": kind, "mean": 20e3, "standard_deviation": 6e3}
    count = 4000
    samples = values_of_samples(study({"key": "a", "distribution": drawn}, samples=count))
    values = np.array([value for (value,) in samples])
    assert abs(values.mean() - 20e3) < 4.0 * 6e3 / math.sqrt(count)
    assert values.std(ddof=1) == pytest.approx(6e3, rel=0.07)
    logarithms = np.log(values) if kind == "lognormal" else values
    z = (logarithms - logarithms.mean()) / logarithms.std()
    assert abs((z**3).mean()) < 4.0 * math.sqrt(6.0 / count)  # skewness


def test_draws_depend_on_seed_number_and_key_alone() -> None:
    drawn = {"key": "a", "distribution": {"type": "uniform", "lower": 0.0, "upper": 1.0}}
    seed = {"key": "b", "new_seed": True}
    few = values_of_samples(study(drawn, seed, samples=3, seed=5))
    more = values_of_samples(study(drawn, seed, samples=6, seed=5))
    assert more[:3] == few
    assert len({s for _, s in more}) == 6
    assert [(b, a) for a, b in few] == values_of_samples(study(seed, drawn, samples=3, seed=5))
    assert values_of_samples(study(drawn, seed, samples=3, seed=6))[0] != few[0]
    both = values_of_samples(study(drawn, {"key": "c", "values": [1, 2]}, samples=3, seed=5))
    assert [a for a, _ in both] == [a for a, _ in few for _ in range(2)]  # for both values


@pytest.mark.parametrize(
    ("entries", "problem"),
    [
        ({"vary": [{"key": "a"}]}, "has no values"),
        ({"vary": [{"key": "a", "values": [1], "new_seed": True}]}, "has values and new_seed"),
        ({"vary": [{"key": "a", "new_seed": True}]}, "samples: missing"),
        ({"vary": [{"key": "a", "values": [1]}], "samples": 3}, "there is no random entry"),
        ({"vary": [{"key": "a", "values": [1]}] * 2}, "is given twice"),
        ({"vary": [{"key": "a", "name": "status", "values": [1]}]}, "another column"),
        ({"vary": [{"key": "a", "value": [1]}]}, "did you mean `values`?"),
        ({"vary": [{"key": "a", "range": {"start": 0, "stop": 1, "count": 2, "spacing": "log"}}]},
         "must be greater than zero"),
        ({"outcomes": [{"type": "history", "name": "s", "column": "c", "take": "last",
                        "at_time": 1.0}]}, "has `take` and `at_time`"),
    ],
)  # fmt: skip
def test_a_wrong_study_is_refused(entries: dict[str, Any], problem: str) -> None:
    right = {"vary": [{"key": "a", "values": [1]}], "outcomes": OUTCOMES}
    with pytest.raises(BadInput) as caught:
        Study.from_dict({"format": 1, **right, **entries})
    assert problem in str(caught.value)


def test_outcomes_of_a_history(tmp_path: Path) -> None:
    rows = ["step,time,iterations,load [kN],settlement [m]"]
    rows += ["0,0.0,0,0.0,0.0", "1,0.5,2,10.0,0.1", "2,1.0,2,8.0,0.4"]
    (tmp_path / "history.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")

    def of(**entries: Any) -> float:
        return value_of(HistoryOutcome(name="x", column="load", **entries), tmp_path)

    assert of() == 8.0
    assert of(take="largest") == 10.0
    assert of(take="smallest") == 0.0
    assert of(at_time=0.25) == 5.0
    assert of(at_time=0.125) == 2.5  # nearer to the first of two rows
    assert of(at_time=0.875) == 8.5  # nearer to the second
    assert of(at=Place(column="settlement [m]", value=0.25)) == 9.0
    assert of(at=Place(column="settlement", value=0.1)) == 10.0
    with pytest.raises(BadInput, match=r"never reaches 0\.5: it lies between 0 and 0\.4"):
        of(at=Place(column="settlement", value=0.5))


def test_statistics_of_what_there_is() -> None:
    outcomes = np.array([3.0, np.nan, 1.0, 2.0, 6.0])
    found = statistics("x", "m", [1, 2, 3, 4, 5], outcomes, "largest")
    assert (found.count, found.without, found.mean) == (4, 1, 3.0)
    assert found.standard_deviation == pytest.approx(math.sqrt(14.0 / 3.0))
    assert found.standard_error == pytest.approx(math.sqrt(14.0 / 12.0))
    assert (found.worst, found.worst_sample) == (6.0, 5)
    assert statistics("x", "m", [1, 2, 3, 4, 5], outcomes, "smallest").worst_sample == 3
    assert found.quantiles[2] == 2.5
    none = statistics("x", "", [1], np.array([np.nan]), "largest")
    assert (none.count, none.worst_sample) == (0, None)


def test_running_means() -> None:
    numbers = np.random.default_rng(3).normal(1e6, 1.0, 20)
    mean, error = running_mean(numbers)
    for n in (2, 7, 20):
        assert mean[n - 1] == pytest.approx(numbers[:n].mean(), rel=1e-14)
        expected = numbers[:n].std(ddof=1) / math.sqrt(n)
        assert error[n - 1] == pytest.approx(expected, rel=1e-9)
    assert np.isnan(error[0])


def test_the_example_is_a_valid_study() -> None:
    declared = load_study(EXAMPLE / "studies" / "monte_carlo.toml")
    assert Study.from_dict(declared.to_dict()) == declared
    samples = make_samples(declared, case_entries(str(declared.case)))
    assert len(samples) == 200
    seeds = {s.entries["materials"]["clay"]["undrained_shear_strength"]["random"]["seed"]
             for s in samples}  # fmt: skip
    assert len(seeds) == 200
