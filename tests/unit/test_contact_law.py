# SPDX-License-Identifier: BSD-3-Clause
"""The law of contact: every branch with values by hand, its slopes, and its derivative."""

from __future__ import annotations

import numpy as np
import pytest

from tilth.arrays import Floats
from tilth.boundaries.contact.law import (
    LARGEST_SLOPE,
    ContactLaw,
    ContactResponse,
    first_slip,
    respond,
)
from tilth.boundaries.contact.surface import parameters
from tilth.model import Contact

E_N, E_T = 100.0, 40.0
COHESION, SLOPE = 8.0, 0.5  # of the soil


def law(
    cohesion: float = 0.0,
    friction: float = 0.0,
    limit: float = np.inf,
    tension: float = 0.0,
    bilateral: bool = False,
) -> ContactLaw:
    numbers = (np.array([value]) for value in (cohesion, friction, limit, tension))
    return ContactLaw(*numbers, np.array([bilateral]))


def respond_to(
    given: ContactLaw, trial: list[float], slip: Floats | None = None
) -> ContactResponse:
    """The response of one multiplier to s_n and s_t."""
    array = np.array([trial])
    last = np.zeros((1, len(trial) - 1)) if slip is None else slip
    return respond(given, array, np.array([[E_N, E_T]]), last)


@pytest.mark.parametrize(
    ("given", "pressure", "strength", "slope"),
    [
        (law(friction=0.5), 10.0, 5.0, 0.5),
        (law(friction=0.5, limit=3.0), 10.0, 3.0, 0.0),
        (law(cohesion=8.0, friction=0.5), 10.0, 13.0, 0.5),
        (law(cohesion=8.0), 10.0, 8.0, 0.0),
        # an adhesion increases with the pressure where soil can separate
        (law(cohesion=8.0), 0.2, 0.2 * LARGEST_SLOPE, LARGEST_SLOPE),
        (law(cohesion=np.inf), 0.2, 0.2 * LARGEST_SLOPE, LARGEST_SLOPE),
        (law(cohesion=8.0), 0.0, 0.0, 0.0),
        (law(cohesion=8.0, tension=3.0), -2.0, 0.0, 0.0),
        # not where it cannot
        (law(cohesion=8.0, bilateral=True), 0.2, 8.0, 0.0),
        (law(cohesion=8.0, bilateral=True), -4.0, 8.0, 0.0),
        (law(friction=0.5, bilateral=True), -4.0, 0.0, 0.0),
        (law(cohesion=8.0, friction=0.5, bilateral=True), -4.0, 6.0, 0.5),
        (law(cohesion=np.inf, bilateral=True), 1.0, np.inf, 0.0),
    ],
)
def test_shear_strength(given: ContactLaw, pressure: float, strength: float, slope: float) -> None:
    found, derivative = given.strength(np.array([pressure]))
    assert found[0] == pytest.approx(strength, rel=1e-15)
    assert derivative[0] == slope


@pytest.mark.parametrize(
    ("given", "trial", "traction", "closed", "sliding"),
    [
        (law(friction=0.5), [-10.0, 3.0, 0.0], [-10.0, 3.0, 0.0], True, False),
        (law(friction=0.5), [-10.0, 6.0, 8.0], [-10.0, 3.0, 4.0], True, True),
        (law(friction=0.5), [-10.0, -9.0], [-10.0, -5.0], True, True),
        (law(), [-10.0, -9.0], [-10.0, 0.0], True, True),
        (law(friction=0.5), [1e-9, 5.0], [0.0, 0.0], False, False),
        (law(friction=0.5, bilateral=True), [4.0, 5.0], [4.0, 0.0], True, True),
        (law(cohesion=2.0, bilateral=True), [4.0, 5.0], [4.0, 2.0], True, True),
        (law(cohesion=np.inf, bilateral=True), [4.0, 500.0], [4.0, 500.0], True, False),
        # tension up to the strength, none at all beyond it
        (law(tension=3.0), [2.9, 0.0], [2.9, 0.0], True, False),
        (law(tension=3.0), [3.1, 0.0], [0.0, 0.0], False, False),
    ],
)
def test_tractions(
    given: ContactLaw, trial: list[float], traction: list[float], closed: bool, sliding: bool
) -> None:
    found = respond_to(given, trial)
    assert found.traction[0] == pytest.approx(traction, abs=1e-13)
    assert (found.closed[0], found.sliding[0]) == (closed, sliding)
    assert sliding == (np.linalg.norm(found.slip[0]) == pytest.approx(1.0))


@pytest.mark.slow
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize(
    "given",
    [
        law(),
        law(friction=0.3),
        law(friction=0.3, limit=2.0),
        law(cohesion=3.0, friction=0.2),
        law(cohesion=3.0),
        law(cohesion=np.inf),
        law(cohesion=3.0, bilateral=True),
        law(cohesion=3.0, friction=0.2, bilateral=True),
        law(cohesion=np.inf, bilateral=True),
        law(friction=0.3, tension=1.0),
    ],
    ids=str,
)
def test_derivative(dim: int, given: ContactLaw) -> None:
    """Against central differences wherever the law is smooth: 200 random trial tractions."""
    random = np.random.default_rng(dim)
    stiffness = np.array([E_N] + [E_T] * (dim - 1))
    step, states = 1e-6, set()
    for _ in range(200):
        trial = random.normal(0.0, 4.0, dim)
        at = respond_to(given, trial.tolist())
        states.add((bool(at.closed[0]), bool(at.sliding[0])))
        for k, unit in enumerate(np.eye(dim)):
            ends = [respond_to(given, (trial + way * step * unit).tolist()) for way in (1.0, -1.0)]
            if len({(end.closed[0], end.sliding[0]) for end in [at, *ends]}) > 1:
                continue
            slopes = {
                float(given.strength(-(trial[:1] + way * step))[1][0]) for way in (0.0, 1.0, -1.0)
            }
            if len(slopes) > 1:
                continue
            difference = (ends[0].traction[0] - ends[1].traction[0]) / (2.0 * step)
            np.testing.assert_allclose(
                at.derivative[0, :, k], stiffness[k] * difference, rtol=0, atol=1e-6 * E_N
            )
    assert len(states) >= (1 if given.bilateral[0] and np.isinf(given.cohesion[0]) else 2)


def test_derivative_of_sliding_in_space() -> None:
    """tau = mu p s_t / |s_t|: it grows with the pressure, and along the slip with nothing else."""
    found = respond_to(law(friction=0.5), [-10.0, 6.0, 8.0])
    along, half = np.array([0.6, 0.8]), 0.5  # direction, and strength over the trial's size
    across = np.array([[0.64, -0.48], [-0.48, 0.36]])
    expected = np.zeros((3, 3))
    expected[0, 0] = E_N
    expected[1:, 0] = -0.5 * along * E_N  # by s_n, which is -p
    expected[1:, 1:] = half * across * E_T
    np.testing.assert_allclose(found.derivative[0], expected, rtol=0, atol=1e-12)
    flat = respond_to(law(friction=0.5), [-10.0, -8.0])
    np.testing.assert_allclose(flat.derivative[0], [[E_N, 0.0], [0.5 * E_N, 0.0]], atol=1e-12)
    stuck = respond_to(law(friction=0.5), [-10.0, 3.0, 0.0])
    np.testing.assert_allclose(stuck.derivative[0], np.diag([E_N, E_T, E_T]), atol=1e-12)


def test_a_slip_that_turns_round_sticks_first() -> None:
    given = law(friction=0.5)
    last = respond_to(given, [-10.0, 9.0]).slip
    assert last[0] == pytest.approx([1.0])
    back = respond_to(given, [-10.0, -9.0], last)
    assert not back.sliding[0]
    assert back.traction[0] == pytest.approx([-10.0, -9.0])
    assert respond_to(given, [-10.0, -9.0], back.slip).traction[0] == pytest.approx([-10.0, -5.0])
    smooth = respond_to(law(), [-10.0, -9.0], last)  # what never sticks does not stick now
    assert smooth.traction[0] == pytest.approx([-10.0, 0.0])


def test_a_given_strength_does_not_change_with_the_pressure() -> None:
    given = law(friction=0.5)
    trial, stiffness, still = np.array([[-10.0, 9.0]]), np.array([[E_N, E_T]]), np.zeros((1, 1))
    found = respond(given, trial, stiffness, still, given=np.array([2.0]))
    assert found.traction[0] == pytest.approx([-10.0, 2.0])
    assert found.derivative[0, 1, 0] == 0.0
    opened = respond(given, -trial, stiffness, still, given=np.array([2.0]))
    assert not opened.traction.any()


def test_what_slides_at_the_start_of_a_step() -> None:
    given = law(friction=0.5)
    assert first_slip(given, np.array([[-10.0, -5.0]]))[0] == pytest.approx([-1.0])
    assert first_slip(given, np.array([[-10.0, 3.0, 4.0]]))[0] == pytest.approx([0.6, 0.8])
    assert not first_slip(given, np.array([[-10.0, -4.9]])).any()
    assert not first_slip(given, np.zeros((1, 2))).any()


@pytest.mark.parametrize(
    ("declared", "expected"),
    [
        ({"tangential": "smooth"}, (0.0, 0.0, np.inf, 0.0)),
        ({"tangential": "friction", "friction": 0.3}, (0.0, 0.3, np.inf, 0.0)),
        ({"tangential": "friction", "friction": 0.3, "shear_limit": 2.0}, (0.0, 0.3, 2.0, 0.0)),
        ({"tangential": "friction", "friction": 0.3, "adhesion_factor": 0.5},
         (0.0, 0.3, 0.5 * COHESION, 0.0)),
        ({"tangential": "adhesion", "adhesion_factor": 0.5}, (0.5 * COHESION, 0.0, np.inf, 0.0)),
        ({"tangential": "adhesion", "shear_limit": 2.0}, (2.0, 0.0, np.inf, 0.0)),
        ({"tangential": "rough"}, (COHESION, SLOPE, np.inf, 0.0)),
        ({"tangential": "bonded"}, (np.inf, 0.0, np.inf, 0.0)),
        ({"tangential": "smooth", "tensile_strength": 4.0}, (0.0, 0.0, np.inf, 4.0)),
    ],
    ids=str,
)  # fmt: skip
def test_parameters_of_a_declared_law(declared: dict, expected: tuple[float, ...]) -> None:
    contact = Contact.model_validate({"normal": "unilateral", **declared})
    found = parameters(contact, np.array([COHESION]), np.array([SLOPE]))
    assert [float(np.broadcast_to(each, (1,))[0]) for each in found] == list(expected)
