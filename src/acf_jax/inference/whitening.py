"""Coloured noise made independent: what each sample says beyond the samples before it.

Noise that is correlated in time is a process of one state behind white noise, so a Kalman filter gives the same as
the inverse of the covariance's Cholesky factor, at a cost in proportion to the samples (Anderson and Moore, Optimal
Filtering, 1979, chapter 5). The noise of `acf_jax.dataset.Noise` is one such process, the rough part of a discrepancy
is another.
"""

from typing import NamedTuple

import numpy as np

from acf_jax.dataset import Noise

AT_ONCE = 16  # samples: few products of matrices are quicker than many of numbers


class Rough(NamedTuple):
    """A process that is forgotten exponentially (Ornstein-Uhlenbeck)."""

    std: np.ndarray  # (trials, n) N
    correlation_time: float  # s


class Whitener:
    """Turns forces in N into units of independent noise of unit variance."""

    def __init__(self, times: np.ndarray, used: np.ndarray, noise: Noise, rough: Rough | None = None):
        """`times`: (trials, n) s, increasing where `used` (trials, n): samples first, padding after them."""
        self.used, self.noise = used[:, None], noise
        # of the standard deviations of all samples beyond what those before them say
        self.log_volume = float(used.sum() * np.log(noise.std))
        states = [] if noise.is_white else [(noise.std * np.sqrt(noise.share), noise.correlation_time)]
        states += [] if rough is None else [rough]
        self.states = len(states)
        if not states:
            return
        steps = np.where(used[:, 1:], np.diff(times), np.inf)
        steps = np.pad(steps, ((0, 0), (0, 1)), constant_values=np.inf)
        size = np.stack([np.broadcast_to(std, times.shape) for std, _ in states])  # (states, trials, n)
        decay = np.stack([np.exp(-steps / time) for _, time in states])
        gain, scale = np.empty_like(size), np.empty_like(times)
        alone = np.eye(self.states)[:, :, None]
        variance = np.tile(alone, len(times))  # of the states, (states, states, trials)
        independent = noise.std**2 * (1 - noise.share)
        for k in range(times.shape[1]):
            with_sample = np.einsum("abi,bi->ai", variance, size[:, :, k])
            of_sample = (size[:, :, k] * with_sample).sum(0) + independent
            gain[:, :, k] = with_sample / of_sample
            scale[:, k] = 1 / np.sqrt(of_sample)
            variance -= gain[:, None, :, k] * with_sample
            pair = decay[:, None, :, k] * decay[None, :, :, k]
            variance = pair * variance + (1 - pair) * alone
        self.log_volume = -float(np.log(scale[used]).sum())
        parts = (slice(first, first + AT_ONCE) for first in range(0, times.shape[1], AT_ONCE))
        self.steps = [_over(*(a[..., part] for a in (size, decay, gain, scale))) for part in parts]

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """Residuals and derivatives (trials, rows, n), zero where unused."""
        if not self.states:
            return np.asarray(values * self.used / self.noise.std)
        white, state, first = np.empty_like(values), np.zeros((*values.shape[:2], self.states)), 0
        for step in self.steps:
            part = slice(first, first := first + step.shape[1] - self.states)
            found = np.concatenate([values[:, :, part], state], axis=2) @ step
            white[:, :, part], state = np.split(found, [-self.states], axis=2)
        white *= self.used
        return white


def _over(size: np.ndarray, decay: np.ndarray, gain: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """(trials, k + s, k + s) what takes k samples and the s states before them to white ones and the states behind.

    **Arguments:** of the filter: `size`, `decay`, `gain` (s, trials, k), `scale` (trials, k).
    """
    states, trials, count = size.shape
    values = np.eye(count + states)
    white, state = np.empty((trials, count + states, count)), values[:, count:].T[:, None]
    for k in range(count):
        new = values[:, k] - (size[:, :, k, None] * state).sum(0)
        white[:, :, k] = new * scale[:, k, None]
        state = decay[:, :, k, None] * (state + gain[:, :, k, None] * new)
    return np.concatenate([white, np.moveaxis(state, 0, 2)], axis=2)
