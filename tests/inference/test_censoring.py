"""Readings at the end of the sensor's range: the exact likelihood of 'at least this much'."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.stats import norm

from acf_jax.dataset import Noise, assess_dataset
from acf_jax.errors import InputError
from acf_jax.inference.censoring import at_least
from acf_jax.inference.discrepancy import discrepancy
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.linear import linearise, residuals
from acf_jax.inference.observations import Observations, observe
from acf_jax.inference.parameters import begin
from tests.dataset.impacts import made_up
from tests.imagined import NOISE, RIG, imagined

GRAVITY = (-9.0,)


def clipped(share: float, colour: Noise) -> tuple[Observations, Observations]:
    """Trials with gravity and noise, whole and by a sensor whose range ends at a share of the largest force."""
    o = replace(imagined("gravity", GRAVITY), noise=colour)
    rng = np.random.default_rng(5)
    factor = np.linalg.cholesky(colour.covariance(o.time[0]))
    whole = replace(o, force=o.force + rng.standard_normal(o.force.shape) @ factor.T)
    end = share * o.force[o.used].max()
    censored = o.used & (whole.force >= end)
    short = replace(whole, force=np.minimum(whole.force, end), used=o.used & ~censored, censored=censored)
    return whole, short


def gravity(o: Observations) -> Fit:
    return fit(o, ("gravity",), begin(RIG.values, [5.0]))


def test_it_is_the_likelihood_of_a_censored_reading() -> None:
    z = np.array([-2e4, -9e3, -40.0, -3.0, -0.5, 0.0, 1.0, 4.0, 9.0, 60.0])
    r, slope = at_least(z)
    assert 0.5 * r**2 == pytest.approx(-norm.logcdf(z), rel=1e-12)
    step = 1e-4
    there = z[:-2]  # beyond, differences are rounding
    difference = (at_least(there - step)[0] - at_least(there + step)[0]) / (2 * step)
    assert slope[:-2] == pytest.approx(difference, rel=1e-5, abs=1e-5)
    assert slope[0] == 1.0 and slope[-1] == 0.0 and np.isfinite(slope).all()


def test_a_force_that_only_just_reaches_the_range_is_not_pulled_down() -> None:
    """Half of its readings are bounds; with max(-z, 0) for these, the other half alone would say where it is."""
    force, end = 100.0, 100.0
    readings = force + np.random.default_rng(0).standard_normal(4000)
    cut = readings >= end

    def loss(mu: float, one_sided: bool) -> float:
        bound = max(end - mu, 0.0) if one_sided else float(at_least(np.array(mu - end))[0])
        return float(((readings[~cut] - mu) ** 2).sum() + cut.sum() * bound**2)

    right, simple = (minimize_scalar(loss, (99.0, 101.0), args=(x,)).x for x in (False, True))
    assert abs(right - force) < 4 / np.sqrt(4000) < abs(simple - force)


@pytest.mark.parametrize("colour", [Noise(NOISE), Noise(NOISE, 0.6, 3e-4)], ids=["white", "coloured"])
def test_a_clipped_set_has_the_same_parameters(colour: Noise) -> None:
    whole, short = clipped(0.55, colour)
    assert 0.2 < short.censored.sum() / whole.n_used < 0.4  # type: ignore[union-attr]
    one, other = gravity(whole), gravity(short)
    std = np.sqrt(np.diag(other.covariance))
    assert (np.abs(one.theta - other.theta) < 2.5 * std).all()
    assert abs(other.physical[4] - GRAVITY[0]) < 3 * std[4]
    assert other.objective / short.n_used < 1.2 * one.objective / whole.n_used


def test_a_prediction_below_the_range_is_as_wrong_as_below_a_reading() -> None:
    """Above it bounds cost next to nothing, and parameters and rings there tell nothing."""
    _, short = clipped(0.55, Noise(NOISE))
    fitted = gravity(short)
    at = fitted.coordinates

    def whitened(gain: float) -> tuple[np.ndarray, np.ndarray]:
        scaled = replace(short, force=short.force * gain)
        linear = linearise(scaled, ("gravity",), at, fitted.u, fitted.nuisance, fitted.grid)
        (alone,) = residuals(scaled, ("gravity",), fitted.theta[None], fitted.nuisance, fitted.grid)
        assert alone == pytest.approx(linear.residual, abs=1e-9)
        return linear.residual[short.censored], linear.by_parameter.swapaxes(1, 2)[short.censored]

    far_above, slopes_above = whitened(0.8)
    far_below, slopes_below = whitened(2.0)
    assert np.abs(far_above).max() < 1e-6 and np.abs(slopes_above).max() < 1e-4
    limit = 2.0 * short.force[short.censored]
    reading = replace(short, force=2.0 * short.force, used=short.weighed, censored=None)
    plain = linearise(reading, ("gravity",), at, fitted.u, fitted.nuisance, fitted.grid)
    assert limit.min() > 0
    assert far_below == pytest.approx(plain.residual[short.censored], rel=0.02)
    assert slopes_below == pytest.approx(
        plain.by_parameter.swapaxes(1, 2)[short.censored], rel=0.02, abs=1e-3
    )


def test_waves_of_a_discrepancy_act_on_bounds_as_on_readings() -> None:
    """Those that all trials share, and those of each: derivatives equal finite differences of the residual."""
    _, short = clipped(0.55, Noise(NOISE))
    o = replace(short, discrepancy=discrepancy(short, 0.01))
    fitted = gravity(o)
    higher = replace(o, force=np.where(o.censored, 1.01 * o.force, o.force))  # near what is predicted
    linear = linearise(higher, ("gravity",), fitted.coordinates, fitted.u, fitted.nuisance, fitted.grid)

    def left(shared: float, own: float) -> np.ndarray:
        theta, nuisance = fitted.theta.copy(), fitted.nuisance.copy()
        theta[-o.n_shared] += shared
        nuisance[:, -o.n_shared] += own
        return residuals(higher, ("gravity",), theta[None], nuisance, fitted.grid)[0]

    step, bounds = 1e-4, o.censored
    assert o.discrepancy is not None and o.n_shared == o.discrepancy.own.shape[1]
    for found, ahead, behind in (
        (linear.by_parameter[:, -o.n_shared], left(step, 0.0), left(-step, 0.0)),
        (linear.waves.own[:, -o.n_shared], left(0.0, step), left(0.0, -step)),
    ):
        assert found == pytest.approx((behind - ahead) / (2 * step), rel=1e-4, abs=1e-5)
        assert np.abs(found[bounds]).max() > 0.1


def test_the_range_as_stated_makes_bounds_of_readings_near_it() -> None:
    """Noise behind the amplifier lies about the range's end: what is three deviations below is a bound as well."""
    dataset = made_up(0)
    rng = np.random.default_rng(1)

    def read(trial):  # type: ignore[no-untyped-def]
        force = np.minimum(trial.trace.force, 200.0) + 0.5 * rng.standard_normal(trial.trace.force.size)
        return replace(trial, trace=replace(trial.trace, force=force), peak_force=None)

    measurement = replace(dataset.measurement, range_n=200.0)
    cut = replace(dataset, measurement=measurement, trials=tuple(map(read, dataset.trials)))
    quality = assess_dataset(cut)
    o = observe(quality)
    assert quality.excluded == {} and quality.damaged == () and len(o.names) == 20
    assert o.force[o.used].max() < 197.0 <= o.force[o.censored].min() + 0.2  # type: ignore[index]
    assert any(
        line.startswith("the end of the sensor's range is reached in 10 of 20") for line in quality.warnings
    )
    assert quality.doubts == ()


def test_peaks_at_the_range_are_bounds() -> None:
    dataset = made_up(0)
    peaks = tuple(replace(t, trace=None, peak_force=min(t.peak_force, 200.0)) for t in dataset.trials)
    stated = replace(dataset.measurement, range_n=200.0)
    o = observe(assess_dataset(replace(dataset, measurement=stated, trials=peaks)))
    near = np.array(
        [p.peak_force >= 197.0 for p in peaks]
    )  # noise of 1 N may have lowered the range's end so far
    assert o.censored is not None and np.array_equal(o.censored[:, 0], near) and near.sum() == 10
    told = observe(assess_dataset(replace(dataset, trials=peaks)))
    assert told.censored is not None and told.censored.sum() == 8
    fitted = fit(o, (), begin(o.prior.values))
    assert fitted.theta[:4] == pytest.approx([2.1, 60.0, 800.0, 3.4e5], rel=0.3)
    nearly_all = tuple(replace(t, peak_force=min(t.peak_force or 0.0, 60.0)) for t in peaks)
    low = replace(dataset.measurement, range_n=60.0)
    with pytest.raises(InputError, match="only 0 trials show an impact within the sensor's range"):
        observe(assess_dataset(replace(dataset, measurement=low, trials=nearly_all)))
