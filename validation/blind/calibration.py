"""Do stated probabilities happen as often as they say?"""

from typing import NamedTuple

import numpy as np

BINS = 10
DRAWS = 4000


class Calibration(NamedTuple):
    """Stated against observed frequencies, in bins of about equally many cases."""

    stated: np.ndarray  # (bins,) mean stated probability
    observed: np.ndarray  # (bins,) share that was right
    cases: np.ndarray  # (bins,) how many
    error: float  # expected calibration error: mean of |observed - stated|, by count
    by_chance: float  # of it, what chance alone exceeds in one of twenty perfectly calibrated runs
    expected_by_chance: float  # its mean in such runs


def calibrate(stated: np.ndarray, right: np.ndarray, seed: int = 0) -> Calibration:
    """Expected calibration error of probabilities (n,) against outcomes (n,), with its sampling uncertainty.

    Naeini et al., 'Obtaining well calibrated probabilities using Bayesian binning', AAAI 2015. What chance does is
    drawn: outcomes that happen with the stated probabilities.
    """
    order = np.argsort(stated, kind="stable")
    groups = [g for g in np.array_split(order, min(BINS, len(order))) if len(g)]

    def error(outcome: np.ndarray) -> float:
        return float(sum(abs(outcome[g].mean() - stated[g].mean()) * len(g) for g in groups) / len(order))

    rng = np.random.default_rng(seed)
    chance = [error(rng.random(len(stated)) < stated) for _ in range(DRAWS)]
    return Calibration(
        np.array([stated[g].mean() for g in groups]),
        np.array([right[g].mean() for g in groups]),
        np.array([len(g) for g in groups]),
        error(right),
        float(np.quantile(chance, 0.95)),
        float(np.mean(chance)),
    )
