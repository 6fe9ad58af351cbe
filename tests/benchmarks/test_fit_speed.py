"""The fits that are timed against each other are the same: residuals of the SciPy peer, and its optimum."""

import numpy as np
import pytest

from acf_jax.dataset import assess_dataset
from acf_jax.diagnosis.candidates import fit_nominal
from acf_jax.inference.fit import grid_for
from acf_jax.inference.linear import linearise
from acf_jax.inference.observations import Observations, observe
from acf_jax.inference.parameters import begin, starts
from benchmarks import fit_speed
from benchmarks.drawn_set import draw_set
from benchmarks.peers import scipy_fit


@pytest.fixture(scope="module")
def few() -> Observations:
    dataset = draw_set(5)
    return observe(assess_dataset(dataset))


def test_the_drawn_set_repeats_its_conditions_and_itself():
    small, large = draw_set(3), draw_set(13)
    assert len(large.conditions) == 10 and [t.condition for t in large.trials[:3]] == [
        t.condition for t in small.trials
    ]
    for one, other in zip(small.trials, large.trials, strict=False):
        assert np.array_equal(one.trace.force, other.trace.force)


@pytest.mark.parametrize("explanation", fit_speed.EXPLANATIONS, ids=str)
@pytest.mark.parametrize("simulate", [scipy_fit.one_by_one, scipy_fit.all_at_once])
def test_both_have_the_same_residuals_and_derivatives(few, explanation, simulate):
    problem = scipy_fit.Problem(few, explanation, simulate)
    start = np.mean(starts(explanation[0]), axis=0) if explanation else []
    u = problem.at.coordinate(begin(few.prior.values, start))
    nuisance = 0.5 * np.random.default_rng(0).standard_normal((len(few.names), 3))
    ours = linearise(few, explanation, problem.at, u, nuisance, grid_for(few, problem.explanation))
    x = np.concatenate([u, nuisance.ravel()])
    residuals, slopes, n = problem.residuals(x), problem.jacobian(x), few.n_used
    # beside the loss of contact their derivatives may be on the other side of it
    np.testing.assert_allclose(residuals[:n], ours.residual[few.used], atol=0.1)  # of the noise
    inside = few.used & (ours.predicted > 30)
    rows = inside[few.used]
    by_parameter = np.moveaxis(ours.by_parameter, 1, 2)[inside]
    np.testing.assert_allclose(
        -slopes[:n, : len(u)][rows], by_parameter, atol=0.04 * np.abs(by_parameter).max()
    )
    by_nuisance = np.moveaxis(ours.by_nuisance, 1, 2)[inside]
    summed = slopes[:n, len(u) :].reshape(n, -1, 3).sum(1)  # of a sample only its own trial's are not zero
    np.testing.assert_allclose(-summed[rows], by_nuisance, atol=0.04 * np.abs(by_nuisance).max())
    np.testing.assert_array_equal(residuals[n:], x)


def test_both_find_the_same_optimum(few):
    ours = fit_nominal(few)
    theirs = scipy_fit.fit(few, (), scipy_fit.all_at_once)
    assert theirs.objective == pytest.approx(ours.objective, rel=1e-3)
    np.testing.assert_allclose(theirs.u, ours.u, atol=0.1, rtol=0.02)
