"""What a fit owes to having seen the data, against fits that have not seen it."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.dataset import Noise
from acf_jax.diagnosis.candidates import fit_nominal, fit_single
from acf_jax.evidence.optimism import MOST, optimism
from acf_jax.inference.baseline import Ground
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.linear import half_chi_square, linearise, normal_equations
from acf_jax.inference.observations import Observations
from tests.imagined import imagined

NAMES = ("sensor_scale", "unknown_sensor")


@pytest.fixture(scope="module")
def measured() -> Observations:
    """A gain error of 10 % beside 1 N of noise, one trial at each of twelve conditions."""
    ideal = imagined("sensor_scale", (0.1,))
    noise = np.random.default_rng(3).standard_normal(ideal.force.shape)
    return replace(ideal, noise=Noise(1.0), force=ideal.force + noise * ideal.used)


@pytest.fixture(scope="module")
def fits(measured: Observations) -> list[Fit]:
    ground = Ground.of(measured, fit_nominal(measured))
    return [fit_single(ground, name) for name in NAMES]


def unseen(observations: Observations, fitted: Fit, out: np.ndarray) -> float:
    """Chi-square of the trials `out` under a real fit of the others, their nuisances fitted to them."""
    refit = fit(observations.subset(~out), fitted.explanation, fitted.theta, fitted.nuisance[~out], warm=True)
    left, nuisance, none = observations.subset(out), fitted.nuisance[out], np.zeros_like(refit.u)
    linear = linearise(left, fitted.explanation, refit.coordinates, refit.u, nuisance, fitted.grid)
    return (
        2 * half_chi_square(linear, none, nuisance) - normal_equations(linear, none, nuisance).nuisance_gain
    )


def test_it_is_what_real_fits_of_the_other_conditions_leave_more(
    measured: Observations, fits: list[Fit]
) -> None:
    for fitted in fits:
        left = sum(unseen(measured, fitted, measured.condition == one) for one in measured.condition)
        assert optimism(fitted, measured.condition) == pytest.approx(left - fitted.chi2.sum(), rel=0.1)


def test_a_free_curve_owes_more_than_a_law(measured: Observations, fits: list[Fit]) -> None:
    law, curve = (optimism(fitted, measured.condition) for fitted in fits)
    assert 0.0 < law < 0.5 * curve < 0.5 * MOST


def test_where_nothing_is_left_to_predict_from_nothing_is_owed(fits: list[Fit]) -> None:
    assert optimism(fits[0], np.zeros(len(fits[0].chi2))) == 0.0


def test_a_step_too_long_for_first_order_counts_as_so_much_at_most(fits: list[Fit]) -> None:
    """The free curve, half of which the slower trials say nothing of."""
    assert optimism(fits[1], np.arange(len(fits[1].chi2)) // 6) == MOST
