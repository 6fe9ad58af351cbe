"""The colour of the noise as the best explanation shows it, too: the samples before contact may be too few to tell."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from acf_jax.dataset import Noise, Trace
from acf_jax.inference.fit import Fit
from acf_jax.inference.linear import Linearisation, half_chi_square, normal_equations
from acf_jax.inference.observations import Observations, Waves
from acf_jax.inference.whitening import Whitener

WORTH = 6.0  # log likelihood that another colour has to gain: 0.25 % false alarms of two parameters
STARTS = [
    (share, steps) for share in (0.3, 0.9) for steps in (1.0, 3.0)
]  # share, correlation time in samples
SHORTEST, LONGEST = 0.2, 100.0  # correlation time in samples
SHARE = 0.999  # of the variance that is correlated, at most
MARGIN = 0.05  # by which the chi-square of a sample may exceed 1: the noise's size is known from few samples


def noise_level(samples: int, doubt: float = 0.0) -> float:
    """The chi-square that noise alone may leave: three deviations above its mean, and a little for what is not known.

    **Arguments:** `doubt`: share by which it may be more since the noise's colour is hardly known (`Noise.doubt`).
    """
    return float(samples * (1 + MARGIN + doubt + 3 * np.sqrt(2 / samples)))


def colour(observations: Observations, best: Fit, approaches: Sequence[Trace]) -> Noise:
    """The noise whose colour makes the approaches and what the best explanation leaves most probable.

    The likelihood is that of the residuals with all that was fitted integrated out to first order, so that what a fit
    took of slow noise does not count as calm. The standard deviation stays as it is known.

    **Arguments:** `best`: a fit that leaves nothing but noise. `approaches`: the samples before contact.

    **Returns:** the noise as it is known where another colour gains too little, with the number of samples that
    now stand behind it.
    """
    known = observations.noise
    raw = replace(observations, noise=Noise(1.0), censored=None)  # a bound says nothing of the noise
    linear = replace(best, observations=raw).linearised()
    before = _Approach(approaches, known.offset)

    def loss(noise: Noise) -> float:
        return -_log_likelihood(observations, best, linear, noise) - before.log_likelihood(noise)

    found = most_probable(known, float(np.median(observations.spacings)), loss)
    if loss(known) - loss(found) < WORTH:
        found = known
    return replace(found, offset_std=before.offset_std(found), samples=before.samples + observations.n_used)


def most_probable(known: Noise, step: float, loss: Callable[[Noise], float]) -> Noise:
    """The colour of least loss, all else as known; `step`: s between samples."""

    def noise(x: np.ndarray) -> Noise:
        share = SHARE / (1 + np.exp(-np.clip(x[0], -9, 9)))
        steps = np.exp(np.clip(x[1], np.log(SHORTEST), np.log(LONGEST)))
        return replace(known, share=float(share), correlation_time=float(step * steps))

    starts = [np.array([np.log(share / (1 - share)), np.log(steps)]) for share, steps in STARTS]
    begin = min(starts, key=lambda x: loss(noise(x)))
    options = {"xatol": 1e-2, "fatol": 1e-2}
    return noise(minimize(lambda x: loss(noise(x)), begin, method="Nelder-Mead", options=options).x)


class _Approach:
    """The samples before contact, padded to one length."""

    def __init__(self, traces: Sequence[Trace], offset: float):
        n = max(trace.time.size for trace in traces)
        self.used = np.array([np.arange(n) < trace.time.size for trace in traces])
        self.time = np.stack([np.pad(trace.time, (0, n - trace.time.size)) for trace in traces])
        self.force = np.stack([np.pad(trace.force - offset, (0, n - trace.time.size)) for trace in traces])
        self.samples = int(self.used.sum())

    def offset_std(self, noise: Noise) -> float:
        """Standard deviation of the mean, N; 0 where there are no samples."""
        weight = float((Whitener(self.time, self.used, noise)(np.ones_like(self.force)[:, None]) ** 2).sum())
        return weight**-0.5 if weight else 0.0

    def log_likelihood(self, noise: Noise) -> float:
        whiten = Whitener(self.time, self.used, noise)
        return -0.5 * float((whiten(self.force[:, None]) ** 2).sum()) - whiten.log_volume


def _log_likelihood(observations: Observations, best: Fit, linear: Linearisation, noise: Noise) -> float:
    """Of the compared samples, parameters and nuisances integrated out; `linear`: the model about the fit, in N."""
    whiten = Whitener(observations.time, observations.used, noise)
    rows = whiten(np.concatenate([linear.residual[:, None], linear.by_parameter, linear.by_nuisance], axis=1))
    residual, by_law, by_motion, own = np.split(
        rows, np.cumsum([1, len(best.u), linear.by_motion.shape[1]]), axis=1
    )
    waves = Waves.of_both(own, own.shape[1])
    white = replace(linear, residual=residual[:, 0], by_law=by_law, by_motion=by_motion, waves=waves)
    normal = normal_equations(white, best.u, best.nuisance)
    volume = np.linalg.slogdet(normal.nuisance_inverse)[1].sum() - np.linalg.slogdet(normal.hessian)[1]
    left = half_chi_square(white, best.u, best.nuisance) - 0.5 * normal.gain
    return float(0.5 * volume - left - whiten.log_volume)
