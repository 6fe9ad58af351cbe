"""The trials as arrays: what is compared with the simulator, and how noisy it is."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from acf_jax.dataset import GapDataset, Noise, Quality, RigPrior

LONGEST = 24.0  # of a trace that is compared, in units of 1/omega: about four periods
ONSET = (
    0.9  # samples nearer to first contact than this share of the interval are left out: the jump falls there
)
TRIGGER = 0.5  # standard deviation of a trial's trigger time about the common one, in sampling intervals
COMMON_TRIGGER = 0.5  # standard deviation of the delay that all triggers share, in sampling intervals


@dataclass(frozen=True)
class Observations:
    """Trials padded to the same length; a peaks-only trial has one 'sample', its peak.

    Trials of the same condition share a `condition` number.
    """

    names: tuple[str, ...]
    v_e: np.ndarray  # (trials,) commanded contact velocity, m/s
    f_p: np.ndarray  # (trials,) commanded pretension, N
    condition: np.ndarray  # (trials,) int
    time: np.ndarray  # (trials, n) s after first contact
    force: np.ndarray  # (trials, n) N
    used: np.ndarray  # (trials, n) bool
    peak_only: np.ndarray  # (trials,) bool
    interval: np.ndarray  # (trials,) sampling interval, s
    rel_std: tuple[float, float]  # spread of velocity and pretension, trial to trial
    noise: Noise
    prior: RigPrior

    @property
    def n_used(self) -> int:
        """Number of compared samples."""
        return int(self.used.sum())

    def subset(self, keep: np.ndarray) -> "Observations":
        """The trials for which `keep` is true."""
        index = np.flatnonzero(keep)
        rows = ("v_e", "f_p", "condition", "time", "force", "used", "peak_only", "interval")
        return replace(
            self,
            names=tuple(self.names[i] for i in index),
            **{name: getattr(self, name)[index] for name in rows},
        )


def observe(dataset: GapDataset, quality: Quality) -> Observations:
    """What of a data set is compared: the impact phase of each sound trial, or its peak where there is no trace."""
    numbers = {condition: k for k, condition in enumerate(dataset.conditions)}
    chosen = [i for i in quality.used if quality.trials[i].phase or dataset.trials[i].peak_force is not None]
    trials = [dataset.trials[i] for i in chosen]
    longest = LONGEST / np.pi * dataset.rig.impact_time
    rows = []
    for i, trial in zip(chosen, trials, strict=True):
        look = quality.trials[i]
        if trial.trace is None or look.phase is None:
            rows.append((np.zeros(1), np.array([trial.peak_force]), np.ones(1, bool), 0.0, True))
            continue
        time, force = trial.trace.time, trial.trace.force - quality.noise.offset
        interval = float(np.median(np.diff(time)))
        late = interval * round((look.trigger_offset or 0.0) / interval)
        time = time - late
        part = slice(look.phase.start, look.phase.stop)
        used = (time[part] > ONSET * interval) & (time[part] < longest)
        rows.append((time[part][used], force[part][used], np.ones(used.sum(), bool), interval, False))
    n = max(len(row[0]) for row in rows)

    def padded(k: int) -> np.ndarray:
        return np.stack([np.pad(row[k], (0, n - len(row[k]))) for row in rows])

    return Observations(
        names=tuple(t.name for t in trials),
        v_e=np.array([t.contact_velocity for t in trials]),
        f_p=np.array([t.pretension for t in trials]),
        condition=np.array([numbers[t.condition] for t in trials]),
        time=padded(0),
        force=padded(1),
        used=padded(2),
        peak_only=np.array([row[4] for row in rows]),
        interval=np.array([row[3] for row in rows]),
        rel_std=(dataset.measurement.contact_velocity_rel_std, dataset.measurement.pretension_rel_std),
        noise=quality.noise,
        prior=dataset.rig,
    )


def whiten(values: np.ndarray, times: np.ndarray, used: np.ndarray, noise: Noise) -> np.ndarray:
    """Residuals and derivatives (rows, n) of one trial in units of independent noise; unused samples become zero."""
    count = int(used.sum())
    out = np.zeros_like(values)
    if noise.is_white or count < 2:
        out[:, :count] = values[:, :count] / noise.std
    else:
        factor = np.linalg.cholesky(noise.covariance(times[:count]))
        out[:, :count] = solve_triangular(factor, values[:, :count].T, lower=True).T
    return out
