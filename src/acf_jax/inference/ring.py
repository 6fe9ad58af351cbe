"""A ring: what decays in each trial with a phase and a size of its own, so that no model can predict it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np


class Ring(NamedTuple):
    """A e^{-t/tau} cos(2 pi f t) + B e^{-t/tau} sin(2 pi f t) with A and B normal, drawn anew in each trial.

    The fixture on the sensor rings so after each impact; a sway of the control is a ring whose period is longer than
    the trial.
    """

    frequency: float  # Hz
    decay: float  # tau, s
    size: float  # N, standard deviation of A and of B in a trial of the typical force
    typical: float  # N
    power: int  # 1: it grows with a trial's largest force; 0: it does not

    def columns(self, time: np.ndarray, largest: np.ndarray) -> np.ndarray:
        """(trials, 2, n) N, one standard deviation of either part; `time`: (trials, n) s, `largest`: (trials,) N."""
        size = self.size * (largest[:, None] / self.typical) ** self.power
        angle = 2 * np.pi * self.frequency * time
        return np.asarray(
            np.stack([np.cos(angle), np.sin(angle)], 1) * (size * np.exp(-time / self.decay))[:, None]
        )


def ringing(rings: Sequence[Ring], time: np.ndarray, largest: np.ndarray) -> np.ndarray:
    """(trials, 2 rings, n) N, the columns of several rings; arguments as of `Ring.columns`."""
    none = np.empty((len(time), 0, time.shape[1]))
    return np.concatenate([none, *(ring.columns(time, largest) for ring in rings)], axis=1)
