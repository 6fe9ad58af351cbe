"""The colour of noise that the samples before contact hardly show."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.dataset import Noise, Trace
from acf_jax.diagnosis.candidates import fit_nominal
from acf_jax.diagnosis.search import settled
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.noise_colour import colour
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import begin
from tests.imagined import NOISE, RATE, RIG, imagined

MEMORY = 0.6  # of a sample's noise in the next one
TRUE = Noise(NOISE, share=1.0, correlation_time=-1 / (RATE * np.log(MEMORY)))


def drawn(random: np.random.Generator, shape: tuple[int, ...], memory: float) -> np.ndarray:
    noise = random.standard_normal(shape)
    for k in range(1, shape[-1]):
        noise[..., k] = memory * noise[..., k - 1] + np.sqrt(1 - memory**2) * noise[..., k]
    return NOISE * noise


def recorded(memory: float, before: int = 12, trials: int = 8) -> tuple[Observations, list[Trace]]:
    """Trials without any effect, and their few samples before contact."""
    random = np.random.default_rng(3)
    ideal = imagined("gravity", (0.0,))
    noisy = replace(ideal, force=ideal.force + drawn(random, ideal.force.shape, memory) * ideal.used)
    time = np.arange(-before, 0) / RATE
    approaches = [Trace(time, force) for force in drawn(random, (trials, before), memory)]
    return noisy, approaches


Coloured = tuple[Observations, list[Trace], Fit]


@pytest.fixture(scope="module")
def coloured() -> Coloured:
    """Trials with coloured noise, and their fit as if it were white."""
    observations, approaches = recorded(MEMORY)
    return observations, approaches, fit_nominal(observations)


def test_colour_is_told_by_what_a_fit_leaves(coloured: Coloured) -> None:
    observations, approaches, fitted = coloured
    found = colour(observations, fitted, approaches)
    memory = np.exp(-1 / (RATE * found.correlation_time))
    assert found.share * memory == pytest.approx(MEMORY, abs=0.06)
    assert found.std == NOISE
    assert found.samples == observations.n_used + 8 * 12


@pytest.mark.long
def test_white_noise_stays_white() -> None:
    observations, approaches = recorded(0.0)
    assert colour(observations, fit_nominal(observations), approaches).is_white


@pytest.mark.long
def test_a_known_colour_stays_as_it_is() -> None:
    observations, approaches = recorded(MEMORY)
    known = replace(observations, noise=TRUE)
    found = colour(known, fit_nominal(known), approaches)
    assert (found.share, found.correlation_time) == (TRUE.share, TRUE.correlation_time)


@pytest.mark.long
def test_all_fits_are_made_again_with_the_new_noise(coloured: Coloured) -> None:
    observations, approaches, fitted = coloured
    after, (again,) = settled(observations, [fitted], approaches)
    assert not after.noise.is_white
    assert 2 * again.objective / observations.n_used == pytest.approx(1.0, abs=0.15)
    assert again.objective == pytest.approx(fit_nominal(after).objective, rel=1e-3)


def test_what_no_explanation_fits_says_nothing_of_noise(coloured: Coloured) -> None:
    observations, approaches, _ = coloured
    wrong = [fit(observations, (), begin(1.3 * RIG.values), warm=True, iterations=0)]
    after, fits = settled(observations, wrong, approaches)
    assert after is observations and fits == wrong


def test_samples_before_contact_say_nothing_of_what_repeats_differ_by(coloured: Coloured) -> None:
    observations, approaches, fitted = coloured
    from_repeats = replace(observations, noise=replace(observations.noise, std=10 * NOISE, source="repeats"))
    after, fits = settled(from_repeats, [fitted], approaches)
    assert after is from_repeats and fits == [fitted]
