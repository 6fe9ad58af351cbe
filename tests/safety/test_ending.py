"""A check needs to know how the contact ends: what is allowed then, and what is said where it is open."""

import numpy as np
import pytest

from acf_jax.contact.ending import Ending
from acf_jax.contact.read import of_diagnosis, of_rig
from acf_jax.contact.stop import stop_of
from acf_jax.safety.assumptions import assumptions
from acf_jax.safety.check import LATE, OPEN_END, Checker
from acf_jax.safety.limits import read_limits
from acf_jax.safety.situation import Situation
from acf_jax.surrogate import load_surrogate
from tests.corrected import gap_model

LIMITS = read_limits()
NECK = Situation("", LIMITS.find("neck muscle"), "quasi_static", 0.98, 8.2)  # 50 N/mm, 150 N


@pytest.fixture(scope="module")
def checker() -> Checker:
    """Its first peak is 139 N; k_F x passes 150 N after 15 ms, and a flange whose robot stops then goes beyond it."""
    return Checker(of_rig({"m": 0.5357, "d": 0.714, "k_f": 9487.0, "k_c": 126122.0}, {}), load_surrogate())


def test_an_open_end_is_not_decidable_with_the_stop_that_would_do(checker: Checker) -> None:
    answer = checker(NECK)
    assert answer.verdict == "not decidable" and answer.reasons[0] == OPEN_END
    assert answer.force == pytest.approx(138.85, abs=0.01), "the first peak"
    assert answer.stop_by == pytest.approx(0.01079, rel=1e-3)  # k_F x alone would allow 15.2 ms
    assert "must have stopped within 10.7 ms or 10.5 mm" in answer.reasons[1]
    stopped = NECK._replace(ending=Ending(stop_after=answer.stop_by or 0.0))
    assert checker(stopped).verdict == "allowed"
    assert (
        checker(stopped._replace(ending=Ending(stop_after=1.01 * (answer.stop_by or 0)))).verdict
        == "not allowed"
    )


@pytest.mark.parametrize(
    "ending, verdict",
    [
        (Ending(stop_after=0.01), "allowed"),
        (Ending(travel=0.0098), "allowed"),
        (Ending(stop_after=0.03), "not allowed"),
        (Ending(travel=0.03), "not allowed"),
        (Ending(reaction=0.001, deceleration=150.0), "allowed"),
        (Ending(reaction=0.01, deceleration=10.0), "not allowed"),
        (Ending(stop_after=0.01, travel=0.005), "not decidable"),
    ],
)
def test_the_force_until_the_end_decides(checker: Checker, ending: Ending, verdict: str) -> None:
    answer = checker(NECK._replace(ending=ending))
    assert answer.verdict == verdict
    if verdict == "not allowed":
        assert answer.stop_by is not None and 0.005 < answer.stop_by < 0.016


@pytest.mark.parametrize("ending", [
    Ending(stop_after=0.001), Ending(travel=0.001), Ending(reaction=0.0, deceleration=200.0)
])  # fmt: skip
def test_an_early_stop_does_not_stop_the_flange(checker: Checker, ending: Ending) -> None:
    """After 1 ms the robot presses with 80 N; its flange has still to be stopped by the neck."""
    answer = checker(NECK._replace(ending=ending))
    k, k_f, m = 1 / (1 / 126122 + 1 / 50e3), 9487, 0.5357
    rest = 8.2 / (k + k_f)  # a mass on two springs, were the robot at rest at first contact
    alone = 8.2 + k * (np.sqrt(rest**2 + m * 0.98**2 / (k + k_f)) - rest)
    travel = k_f * stop_of(ending, 0.98).travel
    assert answer.force is not None and 0.98 * alone < answer.force < alone + travel
    assert answer.verdict == "allowed"
    faster = NECK._replace(v_e=1.2, ending=ending)
    assert checker(faster).verdict == "not allowed"


def test_the_lasting_force_stands_beside_the_peak(checker: Checker) -> None:
    answer = checker(NECK._replace(ending=Ending(stop_after=0.01)))
    assert answer.lasting == pytest.approx(8.2 + 9487 * 0.0098)
    free = Situation("", LIMITS.find("palm"), "transient", 0.2, 8.2, ending=Ending(stop_after=0.01))
    assert checker(free).lasting is None and checker(NECK).lasting is None


def test_an_open_end_is_allowed_where_no_force_can_ever_pass_the_limit(checker: Checker) -> None:
    """A hand brings little energy; a clamped neck is carried along, unless nothing pushes it back."""
    palm = Situation("", LIMITS.find("palm"), "transient", 0.2, 8.2)
    answer = checker(palm)
    k = 1 / (1 / 126122 + 1 / 75e3)
    assert answer.verdict == "allowed" and answer.upper == pytest.approx(np.sqrt(8.2**2 + k * 0.6 * 0.2**2))
    heavy = Situation("", LIMITS.find("sternum"), "transient", 0.9, 8.2)
    assert checker(heavy).verdict == "not decidable"
    without_spring = Checker(of_rig({"m": 0.5, "d": 2.0, "k_f": 0.0, "k_c": 1e5}, {}))
    assert without_spring(NECK._replace(v_e=0.9)).verdict == "allowed"
    assert Checker(of_rig({"m": 0.5, "d": 2.0, "k_f": 1.0, "k_c": 1e5}, {}))(NECK).verdict == "not decidable"


def test_a_force_without_a_first_peak_is_decidable_by_its_end() -> None:
    stuck = Checker(of_rig({"m": 4.0, "d": 1200.0, "k_f": 9000.0, "k_c": 2e4}, {}), load_surrogate())
    s = NECK._replace(v_e=0.05, f_p=10.0)
    assert stuck(s).verdict == "not decidable"
    assert stuck(s._replace(ending=Ending(stop_after=0.05))).verdict == "allowed"


def test_a_corrected_model_needs_an_end() -> None:
    corrected = Checker(of_diagnosis(gap_model()))
    s = Situation("", LIMITS.find("deltoid"), "transient", 0.2, 70.0)
    assert corrected(s).verdict == "not decidable"
    assert corrected(s._replace(ending=Ending(stop_after=0.03))).verdict == "allowed"
    late = corrected(s._replace(ending=Ending(stop_after=0.2)))
    assert LATE in late.cautions


def test_what_an_ending_takes_for_granted_is_said(checker: Checker) -> None:
    (area,) = NECK.areas
    said = [
        "\n".join(assumptions(checker.model, NECK._replace(ending=e), area, 0.975))
        for e in (Ending(), Ending(travel=0.0098), Ending(reaction=0.002, deceleration=60.0))
    ]
    assert "how the contact ends is not stated" in said[0]
    assert "has stopped 10 ms and 9.8 mm after" in said[1] and "keeps its speed" in said[1]
    assert "from 2 ms on it brakes with 60 m/s^2" in said[2]


def test_an_ending_that_cannot_be_is_refused(checker: Checker) -> None:
    with pytest.raises(ValueError, match=r"ending\.travel.*mm, divide by 1000"):
        checker(NECK._replace(ending=Ending(travel=30.0)))
