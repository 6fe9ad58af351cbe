"""Which trials are left out because of what they do to the fits."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.diagnosis import candidates
from acf_jax.diagnosis.outliers import outliers, without_each
from acf_jax.inference.baseline import Ground
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.observations import Observations
from tests.imagined import NOISE, imagined


def _few_trials(mislabelled: int | None) -> Observations:
    """Eight noisy trials through a lagging sensor; one may carry the trace of the first."""
    plain = imagined("sensor_lag", (1e-3, 0.8))
    few = plain.subset(np.arange(len(plain.names)) % 3 != 1)
    force = few.force + NOISE * np.random.default_rng(0).standard_normal(few.force.shape)
    if mislabelled is not None:
        force[mislabelled] = force[0]
    return replace(few, force=force)


def _fits(observations: Observations) -> list[Fit]:
    nominal = candidates.fit_nominal(observations)
    ground = Ground.of(observations, nominal)
    return [nominal, *(candidates.fit_single(ground, name) for name in ("sensor_lag", "end_stop"))]


def test_a_wrong_label_that_bends_every_fit_is_found() -> None:
    """Here the wrong trial stands out in no fit: each is bent towards it."""
    observations = _few_trials(mislabelled=4)
    found = outliers(observations, _fits(observations))
    assert list(found) == [observations.names[4]]
    assert "without it the others agree" in found[observations.names[4]]


def test_no_trial_is_left_out_where_an_effect_explains_all() -> None:
    observations = _few_trials(mislabelled=None)
    assert outliers(observations, _fits(observations)) == {}


def test_the_fastest_trial_alone_may_have_gone_beyond_a_limit() -> None:
    """Where no other trial as fast has as high and as low a pretension, what it shows may be physics."""
    plain = _few_trials(mislabelled=None)
    found = []
    for i in (3, 7):
        force = plain.force.copy()
        force[i] = np.minimum(force[i], 0.95 * force[i].max())  # a sensor at its limit reads no more
        changed = replace(plain, force=force)
        fits = _fits(changed)
        whole, without = without_each(fits[1])
        assert without.argmin() == i and whole > 5 * without[i]
        found.append(list(outliers(changed, fits)))
    assert found == [[plain.names[3]], []]


def test_the_fastest_trial_is_left_out_where_it_goes_wrong_from_its_beginning() -> None:
    plain = _few_trials(mislabelled=None)
    force = plain.force.copy()
    force[7] *= 0.6  # a loose cable
    changed = replace(plain, force=force)
    assert list(outliers(changed, _fits(changed))) == [plain.names[7]]


def _missed(plain: Observations, i: int, change: np.ndarray) -> list[str]:
    """What is left out where trial `i` alone differs so, N, from the explanation that fits the others."""
    force = plain.force.copy()
    force[i] += change
    changed, right = replace(plain, force=force), _fits(plain)[1]
    fitted = fit(changed, right.explanation, right.theta, warm=True)
    return list(outliers(changed, [replace(fitted, objective=right.objective)]))  # not so much that all look


def test_a_trial_that_the_best_explanation_misses_is_kept_where_it_alone_may_show_a_limit() -> None:
    """An end stop that only the hardest impact reaches; the same misfit of another trial is a fault."""
    plain = _few_trials(mislabelled=None)
    change = 10 * NOISE * np.random.default_rng(1).standard_normal(plain.force.shape[1])
    assert [_missed(plain, i, change) for i in (3, 7)] == [[plain.names[3]], []]


def test_a_trial_is_not_left_out_for_what_an_inexact_form_would_do_to_it() -> None:
    plain = _few_trials(mislabelled=None)
    slow = 0.06 * plain.force[3].max() * np.sin(3 * np.arange(plain.force.shape[1]) / plain.used[3].sum())
    assert np.abs(slow).max() > 10 * NOISE  # by the noise alone it would be
    assert _missed(plain, 3, slow) == []


def test_of_two_repeats_of_the_hardest_impact_the_higher_one_may_show_a_limit() -> None:
    """A pad that only just bottoms out does so in one of them; a loose cable reads too little."""
    plain = _few_trials(mislabelled=None)
    fitted = _fits(plain)[1]
    again = np.array([0, 1, 2, 3, 4, 5, 7, 7])  # the seventh trial takes the place of a repeat of the last
    rows = {name: getattr(plain, name)[again] for name in ("v_e", "f_p", "condition", "force", "used")}
    chi2 = fitted.chi2[again] * np.array([1, 1, 1, 1, 1, 1, 1, 80])
    found = []
    for share in (1.2, 0.8):
        force = rows["force"].copy()
        force[-1] *= share
        changed = replace(plain, **rows | {"force": force})
        found.append(list(outliers(changed, [replace(fitted, chi2=chi2)])))
    assert found == [[], [plain.names[7]]]


def test_leaving_out_a_trial_is_predicted_as_a_fit_to_the_others_finds_it() -> None:
    observations = _few_trials(mislabelled=None)
    fitted = fit(observations, ("sensor_lag",), _fits(observations)[1].theta, warm=True)
    whole, without = without_each(fitted)
    assert whole == pytest.approx(2 * fitted.objective, rel=1e-3)
    others = observations.subset(np.arange(len(observations.names)) != 3)
    again = fit(others, ("sensor_lag",), fitted.theta, warm=True)
    assert without[3] == pytest.approx(2 * again.objective, rel=1e-2)
