"""Coloured noise made independent: what each sample says beyond the samples before it.

The noise of `acf_jax.dataset.Noise` is a process of one state behind white noise, so a Kalman filter gives the same as
the inverse of the covariance's Cholesky factor, at a cost in proportion to the samples (Anderson and Moore, Optimal
Filtering, 1979, chapter 5).
"""

import numpy as np

from acf_jax.dataset import Noise


class Whitener:
    """Turns forces in N into units of independent noise of unit variance."""

    def __init__(self, times: np.ndarray, used: np.ndarray, noise: Noise):
        """`times`: (trials, n) s, increasing where `used` (trials, n): samples first, padding after them."""
        self.used, self.noise = used[:, None], noise
        # of the standard deviations of all samples beyond what those before them say
        self.log_volume = float(used.sum() * np.log(noise.std))
        if noise.is_white:
            return
        independent = 1 - noise.share
        steps = np.where(used[:, 1:], np.diff(times), np.inf)
        decay, gain, scale = np.zeros_like(times), np.empty_like(times), np.empty_like(times)
        decay[:, :-1] = np.exp(-steps / noise.correlation_time)
        variance = np.full(len(times), noise.share)  # of the state, in units of that of a sample
        for k in range(times.shape[1]):
            gain[:, k] = variance / (variance + independent)
            scale[:, k] = 1 / (noise.std * np.sqrt(variance + independent))
            again = decay[:, k] ** 2
            variance = again * gain[:, k] * independent + (1 - again) * noise.share
        self.log_volume = -float(np.log(scale[used]).sum())
        self.decay, self.gain, self.scale = (part.T[:, :, None] for part in (decay, gain, scale))

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """Residuals and derivatives (trials, rows, n), zero where unused."""
        if self.noise.is_white:
            return np.asarray(values * self.used / self.noise.std)
        values = np.ascontiguousarray(np.moveaxis(values, 2, 0))
        white, expected = np.empty_like(values), np.zeros(values.shape[1:])
        for k, value in enumerate(values):
            new = value - expected
            white[k] = new * self.scale[k]
            expected = self.decay[k] * (expected + self.gain[k] * new)
        return np.moveaxis(white, 0, 2) * self.used
