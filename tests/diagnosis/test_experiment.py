"""The next trial is one at which both explanations say something."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

from acf_jax.diagnosis import experiment
from acf_jax.diagnosis.candidates import fit_nominal
from acf_jax.diagnosis.experiment import error_probability
from acf_jax.inference.fit import Fit
from acf_jax.inference.linear import Linearisation
from tests.imagined import imagined


def test_no_trial_is_proposed_where_a_prediction_goes_astray(monkeypatch: pytest.MonkeyPatch) -> None:
    observations = imagined("gravity", (5.0,))
    fitted = fit_nominal(observations)
    other = replace(fitted, u=fitted.u + 0.5)
    plain = experiment.propose(observations, (fitted, 0.6), (other, 0.4))
    assert plain is not None
    linearise = experiment.linearise

    def astray_there(planned: Any, *rest: Any) -> Linearisation:
        found = linearise(planned, *rest)
        return replace(found, residual=1e9 * found.residual) if planned.v_e[0] > 0.9 * plain.v_e else found

    monkeypatch.setattr(experiment, "linearise", astray_there)
    elsewhere = experiment.propose(observations, (fitted, 0.6), (other, 0.4))
    assert elsewhere is not None and elsewhere.v_e <= 0.9 * plain.v_e
    assert np.isfinite(elsewhere.error_after)


def test_repeats_help_against_noise_but_not_against_unsure_parameters(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    observations = imagined("gravity", (5.0,))
    fitted = fit_nominal(observations)
    sure = replace(fitted, hessian=1e8 * fitted.hessian)

    def error_after(fitted: Fit, repeats: int) -> float:
        monkeypatch.setattr(experiment, "REPEATS", repeats)
        proposed = experiment.propose(observations, (fitted, 0.6), (replace(fitted, u=fitted.u + 0.01), 0.4))
        assert proposed is not None
        return proposed.error_after

    gain_if_sure = error_after(sure, 1) - error_after(sure, 12)
    gain = error_after(fitted, 1) - error_after(fitted, 12)
    assert gain_if_sure > 0.01 and gain < 0.5 * gain_if_sure


def test_error_probability_against_sampling() -> None:
    p, q, d = 0.7, 0.2, 1.5
    rng = np.random.default_rng(0)
    n = 400_000
    first = rng.random(n) < p / (p + q)
    signal = rng.normal(size=n) + np.where(first, 0.0, d)
    says_first = np.log(p / q) - d * signal + d**2 / 2 > 0
    assert error_probability(p, q, d) == pytest.approx((says_first != first).mean(), abs=3e-3)
    assert error_probability(0.5, 0.5, d) == pytest.approx(norm.sf(d / 2))
    assert error_probability(p, q, 0.0) == pytest.approx(q / (p + q))
    assert error_probability(1.0, 0.0, d) == 0.0 and error_probability(1.0, 1e-310, d) < 1e-300
