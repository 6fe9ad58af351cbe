"""The trials as arrays: what is compared with the simulator, and how noisy it is."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from acf_jax.dataset import GapDataset, Noise, Quality, RigPrior, Trial, TrialQuality
from acf_jax.errors import InputError, shown
from acf_jax.inference.forward import SAMPLES, step_for
from acf_jax.inference.parameters import Measures
from acf_jax.inference.ring import Ring, ringing
from acf_jax.inference.whitening import Whitener

LEAST_TRIALS = 3
AT_LEAST, AT_MOST = 24.0, 45.0  # of a trace that is compared, in units of 1/omega: four to seven periods
ONSET = (
    0.9  # samples nearer to first contact than this share of the interval are left out: the jump falls there
)
TRIGGER = 0.5  # largest standard deviation of a trial's trigger about the common one, in sampling intervals
SHORTEST_INTERVAL, LONGEST_INTERVAL = 1e-7, 10.0  # s, between samples: beyond, time is in another unit
SIMULATED = 1e-5  # of the largest force: so far the simulation is trusted, and noise counts as no less
N_NUISANCE = 3  # of every trial: velocity, pretension, trigger time; those of rings come behind
COMMON_TRIGGER = 0.15  # standard deviation of the delay that all triggers share, in sampling intervals


class Discrepancy(NamedTuple):
    """What a form's error may add to the force: one standard deviation of each of its waves, (trials, k, n) N."""

    own: np.ndarray  # of each trial
    shared: np.ndarray  # the same in all trials


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
    trigger_std: float = TRIGGER  # of a trial's trigger about the common one, in sampling intervals
    rings: tuple[Ring, ...] = ()  # what trials of one condition do not share
    discrepancy: Discrepancy | None = None

    @property
    def n_used(self) -> int:
        """Number of compared samples."""
        return int(self.used.sum())

    @property
    def measures(self) -> Measures:
        """What is typical of these trials."""
        m, _, _, k_c = self.prior.values
        frequency = np.sqrt(k_c / m) / (2 * np.pi)
        return Measures(float(self.force[self.used].max()), frequency, 100.0 / k_c, 0.1 / frequency)

    @property
    def nuisance_std(self) -> np.ndarray:
        """(trials, 3) prior standard deviation of each trial's velocity, m/s, pretension, N, and trigger time, s."""
        return np.column_stack(
            [self.rel_std[0] * self.v_e, self.rel_std[1] * self.f_p, self.trigger_std * self.interval]
        )

    @property
    def n_nuisances(self) -> int:
        """Of a trial: velocity, pretension, trigger time, two of each ring, and the waves of a discrepancy."""
        waves = 0 if self.discrepancy is None else self.discrepancy.own.shape[1]
        return N_NUISANCE + 2 * len(self.rings) + waves

    @property
    def n_shared(self) -> int:
        """Waves of a discrepancy that all trials share."""
        return self.shared.shape[1]

    @property
    def shared(self) -> np.ndarray:
        """(trials, k, n) N, one standard deviation of each of these waves."""
        if self.discrepancy is None:
            return np.zeros((len(self.names), 0, self.time.shape[1]))
        return self.discrepancy.shared

    @cached_property
    def ringing(self) -> np.ndarray:
        """(trials, k, n) N, one standard deviation of each ring's two parts and of each wave of a discrepancy.

        Zero where there is no trace.
        """
        largest = np.where(self.used, self.force, 0.0).max(1)
        of_rings = np.where(self.traced[:, None], ringing(self.rings, self.time, largest), 0.0)
        waves = [] if self.discrepancy is None else [self.discrepancy.own]
        return np.concatenate([of_rings, *waves], axis=1)

    @cached_property
    def whitened_ringing(self) -> np.ndarray:
        """(trials, k, n) the same in units of independent noise, zero where unused."""
        return self.whiten(self.ringing * self.used[:, None])

    @cached_property
    def whitened_shared(self) -> np.ndarray:
        """(trials, k, n) the waves that all trials share, in units of independent noise, zero where unused."""
        return self.whiten(self.shared * self.used[:, None])

    @property
    def traced(self) -> np.ndarray:
        """(trials, n) the compared samples that are of a trace."""
        return self.used & ~self.peak_only[:, None]

    @property
    def intervals(self) -> np.ndarray:
        """(traces,) sampling intervals, s."""
        return self.interval[~self.peak_only]

    @cached_property
    def whiten(self) -> Whitener:
        """Forces (trials, rows, n) in units of independent noise."""
        return Whitener(self.time, self.used, self.noise)

    def subset(self, keep: np.ndarray) -> "Observations":
        """The trials for which `keep` is true."""
        index = np.flatnonzero(keep)
        rows = ("v_e", "f_p", "condition", "time", "force", "used", "peak_only", "interval")
        return replace(
            self,
            names=tuple(self.names[i] for i in index),
            **{name: getattr(self, name)[index] for name in rows},
            discrepancy=self.discrepancy and Discrepancy(*(waves[index] for waves in self.discrepancy)),
        )


class _Row(NamedTuple):
    time: np.ndarray
    force: np.ndarray
    interval: float
    peak_only: bool


def observe(quality: Quality) -> Observations:
    """What of a data set is compared: the impact phase of each sound trial, or its peak where there is no trace.

    Left out is a trial of which neither can be: its trace shows no impact, or nothing behind first contact; and of a
    trial whose force is cut off the readings that are.

    **Raises:** `InputError` when fewer than three trials show an impact.
    """
    dataset = quality.dataset
    numbers = {trial.name: k for trial, k in zip(dataset.trials, dataset.condition_of, strict=True)}
    longest = compared_time(dataset.rig)
    looks = [(dataset.trials[i], quality.trials[i]) for i in quality.used]
    compared = [(trial, _row(trial, look, quality.noise.offset, longest)) for trial, look in looks]
    compared = [(trial, row) for trial, row in compared if row.time.size]
    trials, rows = [trial for trial, _ in compared], [row for _, row in compared]
    if len(trials) < LEAST_TRIALS:
        raise InputError(
            f"{dataset.folder / 'trials.csv'}: only {len(trials)} trials show an impact, {LEAST_TRIALS} are needed:"
            " check that time 0 is first contact, that traces go on behind it, and that force is positive in contact"
        )
    _check(dataset, trials, rows)
    n = max(len(row.time) for row in rows)
    largest = max(float(row.force.max()) for row in rows)

    def padded(arrays: list[np.ndarray]) -> np.ndarray:
        return np.stack([np.pad(a, (0, n - len(a))) for a in arrays])

    return Observations(
        names=tuple(t.name for t in trials),
        v_e=np.array([t.contact_velocity for t in trials]),
        f_p=np.array([t.pretension for t in trials]),
        condition=np.array([numbers[t.name] for t in trials]),
        time=padded([row.time for row in rows]),
        force=padded([row.force for row in rows]),
        used=padded([np.ones(len(row.time), bool) for row in rows]),
        peak_only=np.array([row.peak_only for row in rows]),
        interval=np.array([row.interval for row in rows]),
        rel_std=(dataset.measurement.contact_velocity_rel_std, dataset.measurement.pretension_rel_std),
        noise=replace(quality.noise, std=max(quality.noise.std, SIMULATED * largest)),
        prior=dataset.rig,
    )


def _check(dataset: GapDataset, trials: list[Trial], rows: list[_Row]) -> None:
    """What can neither be simulated nor written, as a data set built from arrays may hold it: `InputError`."""
    faults = []
    for trial, row in zip(trials, rows, strict=True):
        where = f"{dataset.folder / 'trials.csv'}: trial {shown(trial.name)}"
        if not (0 < trial.contact_velocity < np.inf and 0 <= trial.pretension < np.inf):
            faults.append(
                f"{where}: needs a velocity above 0 m/s and a pretension of 0 N or more; correct it"
            )
        if not row.peak_only and not SHORTEST_INTERVAL <= row.interval <= LONGEST_INTERVAL:
            faults.append(
                f"{where}: its samples are {row.interval:.3g} s apart, not {SHORTEST_INTERVAL:g} to"
                f" {LONGEST_INTERVAL:g} s; give time_s in seconds"
            )
    spreads = dataset.measurement.contact_velocity_rel_std, dataset.measurement.pretension_rel_std
    if not all(0 <= spread <= 1 for spread in spreads):
        faults.append(
            f"{dataset.folder / 'dataset.yaml'}: measurement: a relative spread is a share from 0 to 1"
        )
    if faults:
        raise InputError(faults)


def compared_time(rig: RigPrior) -> float:
    """How long after first contact a trace is compared, s: seven periods, where the simulation's steps reach so far.

    They are small where the damper is strong. Four periods are compared in any case, with longer steps then.
    """
    radian = rig.impact_time / np.pi
    return float(np.clip(SAMPLES * step_for(*rig.values), AT_LEAST * radian, AT_MOST * radian))


def _row(trial: Trial, look: TrialQuality, offset: float, longest: float) -> _Row:
    if trial.trace is None or look.phase is None:
        peak = np.array([] if trial.peak_force is None else [trial.peak_force])
        return _Row(np.zeros_like(peak), peak, 0.0, True)
    interval = float(np.median(np.diff(trial.trace.time)))
    late = interval * round((look.trigger_offset or 0.0) / interval)
    part = slice(look.phase.start, look.phase.stop)
    time, force = trial.trace.time[part] - late, trial.trace.force[part] - offset
    # a late trigger leaves samples of no force behind time 0: comparison begins where force does
    begin = max(ONSET * interval, look.phase.onset - late - 0.5 * interval)
    used = (time > begin) & (time < longest)
    if look.phase.cut_off is not None:
        used &= trial.trace.force[part] < look.phase.cut_off
    return _Row(time[used], force[used], interval, False)
