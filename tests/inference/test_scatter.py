"""What repeats differ by beyond rings and triggers counts as noise."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.dataset import Noise
from acf_jax.diagnosis.candidates import fit_nominal
from acf_jax.inference.observations import Observations
from acf_jax.inference.scatter import with_scatter
from tests.repeated import NOISE, repeated


def beside_a_fit(o: Observations) -> Observations:
    """What repeats differ by beside the recalibrated model."""
    return with_scatter(o, fit_nominal(o))


def scattering(size: float, trials: slice = slice(None)) -> np.ndarray:
    """Force, N, to which each trial adds what no repeat shares and no ring is: twenty levels and lines between."""
    o, random = repeated(0.0), np.random.default_rng(3)
    added = np.zeros(o.force.shape)
    for trial in np.arange(len(o.names))[trials]:
        bumps = random.standard_normal(20)
        added[trial] = np.interp(o.time[trial], np.linspace(o.time[0, 0], o.time[0, -1], 20), bumps)
    return o.force + size * added


def test_repeats_that_differ_say_how_well_a_model_can_do():
    o = repeated(0.0)
    quiet = Noise(0.05, share=0.9, correlation_time=0.3)  # before contact, and slow
    found = beside_a_fit(replace(o, force=scattering(60.0), noise=quiet))
    assert found.noise.source == "repeats" and found.noise.correlation_time < 0.01  # that of its own
    # lines between independent normal values have two thirds of their variance
    left = found.noise.std
    assert 0.3 * 60.0 < left < 1.1 * 60.0
    assert beside_a_fit(found).noise.std == pytest.approx(left, rel=0.25)


def test_noise_that_repeats_confirm_stays_as_it_is():
    for scatter in (0.0, 0.3):
        assert beside_a_fit(repeated(scatter)).noise.std == NOISE


def test_one_faulty_condition_does_not_make_all_noisy():
    o = repeated(0.0)
    assert beside_a_fit(replace(o, force=scattering(60.0, slice(0, 3)))).noise.std == NOISE


def test_without_repeats_nothing_is_said():
    o = repeated(0.0, conditions=12, repeats=1)
    assert beside_a_fit(replace(o, noise=Noise(1e-3))).noise.std == 1e-3
