"""What the gap is made of: shares that add up, and agree with the figures that are printed beside them."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.diagnosis import Diagnosis
from acf_jax.diagnosis.candidates import fit_more
from acf_jax.diagnosis.contributions import BACKGROUND, SCATTER, _interval, _shares, contributions
from acf_jax.evidence.posterior import UNKNOWN, Scored
from acf_jax.inference.baseline import Ground
from tests.diagnosis.conftest import KEPT

LEFT = np.linspace(0.01, 0.1, 100)  # of the gap's mean square


def test_shares_are_those_of_the_mean_squares() -> None:
    """Of 100 N^2 the effects explain 80, split 3 to 1; 5 are beyond the scatter of 15."""
    shares = _shares(np.array([100.0]), np.array([20.0]), np.array([15.0]), np.array([[30.0], [10.0]]))
    assert shares[:, 0] == pytest.approx([0.6, 0.2, 0.05, 0.15])


@pytest.mark.parametrize(
    ("left", "floor", "by_effect", "expected"),
    [
        (130.0, 20.0, [50.0], [0.0, 0.8, 0.2]),  # the corrected model is worse
        (10.0, 20.0, [50.0], [0.9, 0.0, 0.1]),  # it leaves less than scatter does
        (40.0, 20.0, [-5.0, 10.0], [0.0, 0.6, 0.2, 0.2]),  # one effect makes the other's error
        (40.0, 20.0, [0.0], [0.6, 0.2, 0.2]),
    ],
)
def test_no_part_is_negative(
    left: float, floor: float, by_effect: list[float], expected: list[float]
) -> None:
    shares = _shares(np.array([100.0]), np.array([left]), np.array([floor]), np.array(by_effect)[:, None])
    assert shares[:, 0] == pytest.approx(expected)


def test_an_effect_that_may_be_absent_may_have_no_share() -> None:
    draws = np.linspace(0.5, 0.7, 1001)
    assert _interval(draws, 0.0) == pytest.approx((0.505, 0.695))
    low, high = _interval(draws, 0.3)
    assert low == 0.0 and high == pytest.approx(0.5 + 0.2 * 0.675 / 0.7)


def test_shares_agree_with_the_gap(diagnosed: Diagnosis) -> None:
    d = diagnosed
    gravity, background, scatter = d.contributions
    assert (gravity.name, background.name, scatter.name) == ("gravity", BACKGROUND, SCATTER)
    assert gravity.share + background.share + scatter.share == pytest.approx(1)
    before, after = (d.gap[name].force_rms_n or 0.0 for name in ("recalibrated", "corrected"))
    assert gravity.share == pytest.approx(1 - after**2 / before**2)
    assert sum(c.force_rms_n**2 for c in d.contributions) == pytest.approx(before**2)
    assert all(c.ci95[0] <= c.share <= c.ci95[1] for c in d.contributions)
    assert background.component is not None and sum(background.component.values()) == pytest.approx(1)
    assert len(gravity.of_condition) == len(d.gap_map.conditions)


def test_an_effect_adds_to_the_peak_what_it_changes_there(diagnosed: Diagnosis) -> None:
    """A constant force on the flange moves the peak by less than itself."""
    d = diagnosed
    force = d.corrected.physical[4]
    assert 0.05 * abs(force) < d.contributions[0].peak_n < abs(force)


def test_two_effects_share_what_they_explain(diagnosed: Diagnosis) -> None:
    """A second effect that does nothing takes nothing, whatever the order of adding."""
    d = diagnosed
    two = fit_more(Ground.of(d.observations, d.corrected), "sensor_scale", [np.array([0.01])])
    scored = [Scored(two.explanation, 1.0)]
    recalibrated = [d.fits[0]]
    found = contributions(d.observations, recalibrated, two, d.held, LEFT, scored, d.component, KEPT, 0)
    by_name = {c.name: c for c in found}
    assert by_name["gravity"].share == pytest.approx(d.contributions[0].share, abs=0.1)
    assert by_name["sensor_scale"].share < 0.1
    gravity, background, scatter = contributions(
        d.observations, recalibrated, two, d.held, LEFT, [Scored(("gravity",), 1.0)], d.component, KEPT, 0
    )
    assert (background, scatter) == (by_name[BACKGROUND], by_name[SCATTER])
    both = by_name["gravity"].share + by_name["sensor_scale"].share
    assert gravity.share == pytest.approx(both)  # what is not named leaves its part to what is


def test_an_unknown_cause_is_all_background(diagnosed: Diagnosis) -> None:
    d = diagnosed
    curve = next(f for f in d.fits if f.explanation == ("unknown_actuator",))
    where = {"actuator": 0.6, "contact": 0.0, "robot": 0.0, "sensor": 0.2}
    background, scatter = contributions(
        d.observations, [d.fits[0]], curve, d.held, LEFT, [Scored(UNKNOWN, 1.0)], where, KEPT, 0
    )
    assert background.component == pytest.approx({"actuator": 0.75, "contact": 0, "robot": 0, "sensor": 0.25})
    assert background.share + scatter.share == pytest.approx(1) and scatter.share < background.share


def test_what_no_law_explains_is_as_uncertain_as_the_shrinkage(diagnosed: Diagnosis) -> None:
    """Between a fiftieth and a third of what is beyond the scatter."""
    d = diagnosed
    draws = np.linspace(0.02, 0.33, 2001)
    _, background, scatter = contributions(
        d.observations, [d.fits[0]], d.corrected, d.held, draws, d.scored, d.component, KEPT, 0
    )
    beyond = 1 - scatter.share
    assert background.ci95[1] == pytest.approx(0.32 * beyond, rel=0.1)
    assert background.ci95[0] <= min(background.share, 0.04 * beyond)


@pytest.mark.parametrize("changes", [{"peak_only": np.ones(20, bool)}, {"condition": np.zeros(20, int)}])
def test_peaks_alone_and_one_condition_have_nothing_to_share_out(
    changes: dict[str, np.ndarray], diagnosed: Diagnosis
) -> None:
    d = diagnosed
    few = {name: value[: len(d.observations.names)] for name, value in changes.items()}
    o = replace(d.observations, **few)
    assert contributions(o, d.fits, d.corrected, d.held, LEFT, d.scored, d.component, KEPT, 0) == ()
