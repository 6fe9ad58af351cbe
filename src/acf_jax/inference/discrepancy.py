"""Model discrepancy: what laws whose form is a little wrong, and effects too small to be told, add to the force.

Every rig has small effects beside its large ones, whose shapes are known (`small_effects`), and no form is exact. What
a form gets wrong is not known, but how large it is, and how fast: a share of the force, slow beside the noise except
right after contact, where everything has only begun. Half of its variance is the same share of the force in all trials,
since a law is wrong in one way; the other half differs between conditions. As a Gaussian process it is noise of its own
kind, beside which a law has to explain more than that to be named (Kennedy and O'Hagan, 'Bayesian calibration of
computer models', J. R. Stat. Soc. B 63, 2001).

Where a cause is missing, nothing is known of how fast its force is: rings come besides, and last when the force is
over. Then as much again is rough: a process as large all over a trace, that is forgotten within the time in which the
fastest wave changes, so that its power falls with frequency.
"""

import numpy as np

from acf_jax.inference.observations import Discrepancy, Observations
from acf_jax.inference.whitening import Rough

SIZES = (0.001, 0.005, 0.03, 0.1, 0.3)  # shares of the force: a quadrature over what rigs have
FORMS = 0.03  # of these the largest that inexact forms and small effects add: beyond it a cause is missing
SMALL = 0.01  # share of the force that small effects add, unless forms are wrong by more: each is below that
FASTEST = (
    2.0  # times the frequency of the mass on the contact: faster ones are rings, but for the first moments
)
SHARED = 0.5  # of the variance, in all trials alike: nothing is known of it
MOST = 32  # waves, which bounds the time that long traces take


def discrepancy(observations: Observations, size: float, small: np.ndarray | None = None) -> Discrepancy:
    """What is as large as the share `size` of the force: waves of each trial and of all, beyond `FORMS` roughness, too.

    `small`: (trials, k, n) N, what `small_effects` add up to; they are as large again, and never above `FORMS`.

    Repeats share the waves of their condition; drawn anew in each of r repeats, and the root of r larger, they leave
    the mean of the repeats the same.
    """
    o = observations
    period = 1 / o.measures.frequency
    end = max(float(o.time[o.used].max()), period)  # of peaks alone there is no time
    count = int(np.clip(np.ceil(_turns(o, end)), 1, MOST))
    _, condition, repeats = np.unique(o.condition, return_inverse=True, return_counts=True)
    phase = np.pi * np.arange(count)[:, None] * (_turns(o, o.time) / _turns(o, end))[:, None]
    spacing = np.zeros(len(o.names))
    spacing[~o.peak_only] = o.spacings
    envelope = np.array([_envelope(o, i, period / 2, spacing[i]) for i in range(len(o.names))])
    waves = size * np.sqrt(2 / count) * np.cos(phase) * (envelope * o.along)[:, None]
    own = np.sqrt((1 - SHARED) * repeats[condition])[:, None, None]
    rough = None
    if size > FORMS:
        whole = np.sqrt((np.where(o.along, o.force, 0.0) ** 2).sum(1) / np.maximum(o.along.sum(1), 1))
        rough = Rough(size * whole[:, None] * o.along, 1 / (2 * np.pi * FASTEST * o.measures.frequency))
    shared = np.sqrt(SHARED) * waves
    if small is not None:
        shared = np.concatenate([shared, min(max(size, SMALL), FORMS) * small], axis=1)
    return Discrepancy(own * waves, shared, rough)


def _turns(o: Observations, time: np.ndarray | float) -> np.ndarray:
    """How often the fastest wave has changed its sign, s after first contact.

    Besides up to `FASTEST`, once in each factor of e of the time, from the first sample on: what has lasted for a time
    may have changed within it, and not faster.
    """
    spacing = np.median(o.spacings) if o.spacings.size else np.inf
    since = np.maximum(time, 0.0)
    return np.asarray(2 * FASTEST * o.measures.frequency * since + np.log1p(since / spacing))


def _envelope(o: Observations, i: int, window: float, spacing: float) -> np.ndarray:
    """(n,) N, the RMS force of a trial over a window of time, s, about each sample."""
    steps = int(np.clip(window / max(spacing, 1e-9), 1, o.force.shape[1]))
    square = np.where(o.used[i], o.force[i], 0.0) ** 2
    return np.sqrt(np.convolve(square, np.full(steps, 1 / steps), "same"))
