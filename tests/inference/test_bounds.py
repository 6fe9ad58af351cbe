"""A fit does not lose an effect for good by a step that goes beyond its bound."""

import pytest

from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import begin
from tests.imagined import RIG, imagined

TAU, ZETA = 1.5e-4, 1.2


@pytest.fixture(scope="module")
def lagging() -> Observations:
    return imagined("sensor_lag", (TAU, ZETA))


def fit_from(observations: Observations, tau: float, **options: int) -> Fit:
    return fit(observations, ("sensor_lag",), begin(RIG.values, [tau, 0.8]), **options)


@pytest.mark.parametrize("start", [1e-4, 1e-3, 4e-3])
def test_a_lag_is_found_from_far_too_slow_a_sensor(lagging: Observations, start: float) -> None:
    assert fit_from(lagging, start).theta[4] == pytest.approx(TAU, rel=0.05)


def test_the_first_step_leaves_some_of_the_effect(lagging: Observations) -> None:
    assert fit_from(lagging, 4e-3, iterations=1).theta[4] >= 4e-4 * (1 - 1e-9)


def test_an_effect_that_is_not_there_goes_to_its_bound() -> None:
    found = fit_from(imagined("gravity", (0.0,)), 5e-4)
    assert found.at_bound[4] or found.theta[4] < 2e-6


def test_a_stop_that_opposes_all_it_held_is_found_and_at_no_bound() -> None:
    found = fit(imagined("end_stop", (0.3, 0.3)), ("end_stop",), begin(RIG.values, [0.6, 0.2]))
    assert found.theta[4:6] == pytest.approx([0.3, 0.3], abs=0.01)
    assert not found.at_bound[4:6].any()
