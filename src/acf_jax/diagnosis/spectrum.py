"""The gap and what no model can predict, by frequency."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from acf_jax.inference.observations import Observations
from acf_jax.inference.repeats import alike

THIRD = 2 ** (1 / 3)  # of an octave


class Spectrum(NamedTuple):
    """RMS force in bands of a third of an octave, N, shape (bands,)."""

    edges: np.ndarray  # (bands + 1,) Hz
    gap: dict[str, np.ndarray]  # what each model misses on held-out conditions
    scatter: np.ndarray | None  # that repeats of a condition do not share; None without repeats


def spectrum(observations: Observations, residual: dict[str, np.ndarray]) -> Spectrum | None:
    """By the periodogram of each trace; the squares of all bands add up to that of the whole.

    **Arguments:** `residual`: (trials, n) N, by model, zero where unused.

    **Returns:** None where no trial has a trace.
    """
    o = observations
    traces = np.flatnonzero(o.traced.any(1))
    if not traces.size:
        return None
    interval = float(np.median(o.spacings))
    longest = int(o.traced.sum(1).max())
    count = max(1, int(np.ceil(np.log(longest / 2) / np.log(THIRD))))
    edges = 0.5 / interval / THIRD ** np.arange(count, -1, -1.0)

    def of(rows: Iterable[np.ndarray]) -> np.ndarray:
        samples, power = 0, np.zeros(count)
        for row in rows:
            amplitude = np.abs(np.fft.rfft(row)) ** 2 / len(row)
            amplitude[1 : (len(row) + 1) // 2] *= 2  # of either sign
            band = np.searchsorted(edges[1:-1], np.fft.rfftfreq(len(row), interval), side="right")
            power += np.bincount(band, amplitude, count)
            samples += len(row)
        return np.asarray(np.sqrt(power / samples))

    gap = {name: of(values[i, o.traced[i]] for i in traces) for name, values in residual.items()}
    differences = [row for one in alike(o) for row in one.contrasts]
    return Spectrum(edges, gap, of(differences) if differences else None)
