"""What models leave of conditions that they did not see."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from acf_jax.diagnosis import Diagnosis
from acf_jax.diagnosis.heldout import HeldOut, hold_out, pure_error
from acf_jax.inference.fit import fit
from acf_jax.inference.linear import predict
from acf_jax.inference.observations import TIMING
from acf_jax.inference.parameters import begin


def test_what_repeats_share_is_missed_and_what_they_differ_by_is_floor() -> None:
    """However large the noise is thought to be; a condition that was not repeated keeps what is thought."""
    random = np.random.default_rng(0)
    condition, samples = np.repeat(np.arange(40), 3), 200
    shared = random.normal(0, 2.0, (40, samples))[condition]
    residual = shared + random.normal(0, 3.0, shared.shape)
    residual[-3:], condition[-3:] = 5.0, [39, 40, 41]
    held = HeldOut(residual, np.full(residual.shape, 100.0), np.ones(120), np.ones(120))
    interval = np.full(120, 1e-4)
    trials: Any = SimpleNamespace(
        condition=condition, traced=np.ones(residual.shape, bool), interval=interval
    )
    floor = pure_error(trials, held)
    assert floor[:-3].mean() == pytest.approx(9.0, rel=0.05)
    assert (held.residual**2 - floor)[:-3].mean() == pytest.approx(4.0, rel=0.05)
    assert (floor[-3:] == 100.0).all()
    interval *= 1 + 1e-14 * np.arange(120)  # of times that are rounded: the same rate
    assert np.array_equal(pure_error(trials, held), floor)
    interval[:] = 1e-4 * (1 + np.arange(120))  # sampled at other times each: no sample is repeated
    assert (pure_error(trials, held) == 100.0).all()


def test_each_trial_is_shifted_to_where_it_fits_best(diagnosed: Diagnosis) -> None:
    """A ring of four samples a period, seen two samples late: a Gauss-Newton step from on time goes astray."""
    o, effect = replace(diagnosed.observations, trigger_std=1.0), ("sensor_resonance",)
    period = 4 * float(np.median(o.interval))
    theta = begin(o.prior.values, [0.5, 0.0, 1 / period, 2.0, 0.01, 0.02])
    fitted = fit(o, effect, theta, warm=True, iterations=0)
    on_time = np.zeros((len(o.names), o.n_nuisances))
    force = predict(o, effect, fitted.theta, on_time, fitted.grid)
    late = np.resize([-2.0, -1.0, 1.5, 2.0], len(o.names)) * o.nuisance_std[:, TIMING]
    moved = replace(o, force=force, time=o.time + late[:, None])
    held = hold_out(moved, fitted, np.ones(len(o.names)), fitted, refit=False)
    assert np.abs(held.residual).max() < 0.05 * np.abs(force).max()
