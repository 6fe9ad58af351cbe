"""Coloured noise made independent."""

import numpy as np
import pytest

from acf_jax.dataset import Noise
from acf_jax.inference.whitening import Rough, Whitener


@pytest.mark.parametrize(
    "noise", [Noise(0.7), Noise(1.3, share=0.4, correlation_time=8e-4), Noise(0.5, 1.0, 2e-3)]
)
def test_whitening_leaves_independent_noise_of_unit_size(noise: Noise) -> None:
    """At times even and uneven, the second of two trials being shorter than the first."""
    even = 1.25e-4 * np.arange(90.0)
    uneven = np.cumsum(np.random.default_rng(0).uniform(0.3, 2.0, 90)) * 1.25e-4
    used = np.arange(90) < np.array([[90], [60]])
    noises = [np.linalg.cholesky(noise.covariance(times)) for times in (even, uneven)]
    padded = np.where(used, np.stack([even, uneven]), 0.0)
    white = Whitener(padded, used, noise)(np.stack(noises).transpose(0, 2, 1))
    np.testing.assert_allclose(white[0].T @ white[0], np.eye(90), atol=1e-9)
    np.testing.assert_allclose(white[1, :, :60].T @ white[1, :, :60], np.eye(60), atol=1e-9)
    assert not white[1, :, 60:].any()


@pytest.mark.parametrize("noise", [Noise(0.7), Noise(1.3, share=0.4, correlation_time=8e-4)])
def test_a_rough_discrepancy_is_made_independent_too(noise: Noise) -> None:
    """It is larger where the force is; the log volume is that of all samples together."""
    times = 1.25e-4 * np.arange(60.0)
    rough = Rough(3.0 * np.sin(np.pi * np.arange(60) / 60)[None], 4e-4)
    apart = np.abs(times[:, None] - times) / rough.correlation_time
    covariance = noise.covariance(times) + np.exp(-apart) * np.outer(rough.std[0], rough.std[0])
    root = np.linalg.cholesky(covariance)
    whiten = Whitener(times[None], np.ones((1, 60), bool), noise, rough)
    white = whiten(root.T[None])[0]
    np.testing.assert_allclose(white.T @ white, np.eye(60), atol=1e-9)
    assert whiten.log_volume == pytest.approx(np.log(np.diag(root)).sum())
