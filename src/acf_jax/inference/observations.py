"""The trials as arrays: what is compared with the simulator, and how noisy it is."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from acf_jax.dataset import GapDataset, LowPass, Noise, Quality, RigPrior, Trial, TrialQuality
from acf_jax.dataset.low_pass import Filter, is_kept, settling_time
from acf_jax.errors import InputError, shown
from acf_jax.inference.forward import SAMPLES, step_for
from acf_jax.inference.parameters import COMMON, Measures
from acf_jax.inference.ring import Ring, ringing
from acf_jax.inference.robot_motion import WALKS, RobotMotion, robot_motion, velocity_std
from acf_jax.inference.unfinished import digest
from acf_jax.inference.whitening import Rough, Whitener

LEAST_TRIALS = 3  # two leave nothing to check four parameters of a rig by
AT_LEAST, AT_MOST = 24.0, 45.0  # of a trace that is compared, in units of 1/omega: four to seven periods
ONSET = (
    0.9  # samples nearer to first contact than this share of the interval are left out: the jump falls there
)
TRIGGER = 0.5  # largest standard deviation of a trial's trigger about the common one, in sampling intervals
SHORTEST_INTERVAL, LONGEST_INTERVAL = 1e-7, 10.0  # s, between samples: beyond, time is in another unit
SIMULATED = 1e-5  # of the largest force: so far the simulation is trusted, and noise counts as no less
PEAK_WITHIN = 6.0  # of a trial without trace the response is computed for this many 1/omega
NO_TIME = 1e-6  # s, in place of a sampling interval where peaks are all there is
TIMING = 2  # which nuisance is the trigger time
N_NUISANCE = 3  # of every trial: velocity, pretension, trigger time; a motion's and rings' come behind
COMMON_TRIGGER = 0.15  # standard deviation of the delay that all triggers share, in sampling intervals


class Discrepancy(NamedTuple):
    """What a form's error may add to the force: one standard deviation of each of its waves, (trials, k, n) N."""

    own: np.ndarray  # of each trial
    shared: np.ndarray  # the same in all trials
    rough: Rough | None = None  # of each trial, faster than any wave

    def of(self, index: np.ndarray) -> "Discrepancy":
        """That of some of the trials."""
        rough = self.rough and Rough(self.rough.std[index], self.rough.correlation_time)
        return Discrepancy(self.own[index], self.shared[index], rough)


class Waves(NamedTuple):
    """Whitened signals of rings and waves, in which a prediction is linear: the same at every point."""

    both: np.ndarray  # (trials, k + w, n) those of each trial, then those that all share
    n_own: int  # k
    gram: np.ndarray  # (trials, k + w, k + w) their inner products

    @classmethod
    def of_both(cls, both: np.ndarray, n_own: int) -> "Waves":
        """Of signals of which the first `n_own` are each trial's own."""
        return cls(both, n_own, both @ both.swapaxes(1, 2))

    @property
    def own(self) -> np.ndarray:
        """(trials, k, n) of each trial."""
        return self.both[:, : self.n_own]

    @property
    def shared(self) -> np.ndarray:
        """(trials, w, n) of all trials."""
        return self.both[:, self.n_own :]

    def of(self, trials: np.ndarray) -> "Waves":
        """Those of some trials, given by index."""
        return Waves(self.both[trials], self.n_own, self.gram[trials])


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
    used: np.ndarray  # (trials, n) bool, readings of a force
    peak_only: np.ndarray  # (trials,) bool
    interval: np.ndarray  # (trials,) sampling interval, s
    rel_std: tuple[float, float]  # spread of velocity and pretension, trial to trial
    noise: Noise
    prior: RigPrior
    trigger_std: float = TRIGGER  # of a trial's trigger about the common one, in sampling intervals
    rings: tuple[Ring, ...] = ()  # what trials of one condition do not share
    discrepancy: Discrepancy | None = None
    low_pass: LowPass | None = None  # that the readings have been through
    tool_mass: float | None = None  # kg, of the moving mass, between contact and sensor
    robot: RobotMotion | None = None  # how it was measured to move in addition to the commanded velocities
    censored: np.ndarray | None = (
        None  # (trials, n) bool, none of `used`: the force is at least that; None: none is
    )

    @cached_property
    def digest(self) -> str:
        """What tells these observations from others."""
        return digest(self)

    @cached_property
    def simulated(self) -> np.ndarray:
        """(trials,) int, which simulation each is of: one a condition, or, of measured motions, one a trial."""
        of = np.arange(len(self.names)) if self.robot else self.condition
        return np.unique(of, return_inverse=True)[1]

    @property
    def n_used(self) -> int:
        """Number of compared samples; a lower bound hardly counts as one."""
        return int(self.used.sum())

    @property
    def measures(self) -> Measures:
        """What is typical of these trials."""
        m, _, _, k_c = self.prior.values
        frequency = np.sqrt(k_c / m) / (2 * np.pi)
        largest = float(self.force[self.used].max())
        return Measures(largest, frequency, 100.0 / k_c, 0.1 / frequency, largest / k_c)

    @property
    def nuisance_std(self) -> np.ndarray:
        """(trials, 3 + q) prior standard deviation of each trial's velocity, m/s, pretension, N, and trigger time, s.

        Behind them that of a measured motion's errors, which are in units of it.
        """
        known = [self.rel_std[0] * self.v_e, self.rel_std[1] * self.f_p, self.trigger_std * self.interval]
        return np.column_stack([*known, np.ones((len(self.names), self.n_moving - N_NUISANCE))])

    @property
    def n_moving(self) -> int:
        """Nuisances that change the motion: velocity, pretension, trigger time, errors of a measured motion."""
        return N_NUISANCE + (WALKS if self.robot else 0)

    @property
    def n_common(self) -> int:
        """What all trials share but for waves: the sensor's zero, the delay of all triggers, that of a motion."""
        return COMMON + (self.robot is not None)

    @property
    def n_nuisances(self) -> int:
        """Of a trial: what changes the motion, two a ring, one of a filter, the waves of a discrepancy."""
        waves = 0 if self.discrepancy is None else self.discrepancy.own.shape[1]
        return self.n_moving + 2 * len(self.rings) + (self.low_pass is not None) + waves

    @property
    def weighed(self) -> np.ndarray:
        """(trials, n) all samples that have a likelihood: readings and lower bounds."""
        return self.used if self.censored is None else self.used | self.censored

    @cached_property
    def ends(self) -> np.ndarray:
        """(trials,) s after first contact, up to which the response of each is to be known."""
        late = 3 * self.trigger_std * self.interval
        ends = np.where(self.weighed, self.time + late[:, None], 0.0).max(1)
        ends[self.peak_only] = PEAK_WITHIN / np.pi * self.prior.impact_time
        if self.low_pass and self.low_pass.zero_phase:  # readings know what comes after them
            ends[:] = ends.max() + settling_time(self.low_pass)
        return ends

    @property
    def along(self) -> np.ndarray:
        """(trials, n) those of them that are of a trace."""
        return self.weighed & ~self.peak_only[:, None]

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
        parts = [ringing(self.rings, self.time, largest)]
        if self.low_pass:
            parts.append(self._step()[:, None])
        waves = [] if self.discrepancy is None else [self.discrepancy.own]
        return np.concatenate([*(part * self.along[:, None] for part in parts), *waves], axis=1)

    def _step(self) -> np.ndarray:
        """(trials, n) N, what a filter makes of not knowing when within an interval the force stepped to F_P.

        A digital filter is given samples: to it the step falls in the middle between two, up to half an interval off.
        """
        assert self.low_pass is not None
        filters = [Filter(self.low_pass, max(interval, NO_TIME)) for interval in self.interval]
        left = [one.after_one_sample(time) for one, time in zip(filters, self.time, strict=True)]
        return np.array(left) * self.f_p[:, None] / np.sqrt(12)

    @cached_property
    def whitened_waves(self) -> "Waves":
        """Rings and waves in units of independent noise, zero where unused."""
        return self.whiten_waves(np.ones_like(self.time))

    def whiten_waves(self, share: np.ndarray) -> "Waves":
        """The same of that share (trials, n) of each that counts."""
        both = np.concatenate([self.ringing, self.shared], axis=1)
        return Waves.of_both(self.whiten(both * (share * self.weighed)[:, None]), self.ringing.shape[1])

    @property
    def traced(self) -> np.ndarray:
        """(trials, n) the compared samples that are of a trace."""
        return self.used & ~self.peak_only[:, None]

    @property
    def intervals(self) -> np.ndarray:
        """(traces,) sampling intervals, s."""
        return self.interval[~self.peak_only]

    @property
    def spacings(self) -> np.ndarray:
        """(traces,) s between compared samples: of readings behind a low-pass not all are."""
        if self.low_pass is None:
            return self.intervals
        return np.array([Filter(self.low_pass, i).stride * i for i in self.intervals])

    @cached_property
    def whiten(self) -> Whitener:
        """Forces (trials, rows, n) in units of independent noise."""
        # bounds far below the force count as noise of zero there: a few samples in hundreds
        return Whitener(self.time, self.weighed, self.noise, self.discrepancy and self.discrepancy.rough)

    def subset(self, keep: np.ndarray) -> "Observations":
        """The trials for which `keep` is true."""
        index = np.flatnonzero(keep)
        rows = ("v_e", "f_p", "condition", "time", "force", "used", "peak_only", "interval")
        return replace(
            self,
            names=tuple(self.names[i] for i in index),
            **{name: getattr(self, name)[index] for name in rows},
            robot=self.robot and self.robot.of(index),
            discrepancy=self.discrepancy and self.discrepancy.of(index),
            censored=None if self.censored is None else self.censored[index],
        )


class _Row(NamedTuple):
    time: np.ndarray
    force: np.ndarray
    censored: np.ndarray
    interval: float
    peak_only: bool
    late: float = 0.0  # s, first contact after time 0 of the trial's files

    @property
    def tells(self) -> bool:
        """Whether there is something to compare: in a trace of nothing but lower bounds there is next to nothing."""
        return bool(self.time.size and (self.peak_only or not self.censored.all()))


def observe(quality: Quality) -> Observations:
    """What of a data set is compared: the impact phase of each sound trial, or its peak where there is no trace.

    Left out is a trial of which neither can be: its trace shows no impact, or nothing behind first contact. Readings
    at the end of the sensor's range are lower bounds.

    **Raises:** `InputError` when fewer than three trials show an impact.
    """
    dataset = quality.dataset
    numbers = {trial.name: k for trial, k in zip(dataset.trials, dataset.condition_of, strict=True)}
    longest = compared_time(dataset.rig)
    looks = [(dataset.trials[i], quality.trials[i]) for i in quality.used]
    low_pass = dataset.measurement.low_pass
    compared = [(trial, _row(trial, look, quality.noise.offset, longest, low_pass)) for trial, look in looks]
    compared = [(trial, row) for trial, row in compared if row.tells]
    trials, rows = [trial for trial, _ in compared], [row for _, row in compared]
    if sum(not row.censored.all() for row in rows) < LEAST_TRIALS:
        raise InputError(
            f"{dataset.folder / 'trials.csv'}: only {sum(not row.censored.all() for row in rows)} trials show an impact"
            f" within the sensor's range, {LEAST_TRIALS} are needed: check that time 0 is first contact, that traces go"
            " on behind it, and that force is positive in contact"
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
        used=padded([~row.censored for row in rows]),
        censored=padded([row.censored for row in rows]) if any(row.censored.any() for row in rows) else None,
        peak_only=np.array([row.peak_only for row in rows]),
        interval=np.array([row.interval for row in rows]),
        rel_std=(dataset.measurement.contact_velocity_rel_std, dataset.measurement.pretension_rel_std),
        noise=replace(quality.noise, std=max(quality.noise.std, SIMULATED * largest)),
        prior=dataset.rig,
        low_pass=low_pass,
        tool_mass=dataset.measurement.tool_mass_kg,
        robot=_robot(dataset, trials, rows, longest),
    )


def _robot(dataset: GapDataset, trials: list[Trial], rows: list[_Row], longest: float) -> RobotMotion | None:
    """How the robot moved; `InputError` where nothing tells how well that was measured."""
    motions = [trial.motion for trial in trials]
    std = dataset.measurement.robot_velocity_std_m_per_s or velocity_std(motions)
    if std is None and any(motions):
        raise InputError(
            f"{dataset.folder / 'dataset.yaml'}: measurement.robot_velocity_std_m_per_s: is missing, and the files of"
            " `motion` hold too few samples before contact to tell it; state it"
        )
    v_e, late = [trial.contact_velocity for trial in trials], [row.late for row in rows]
    end = max((float(row.time[-1]) for row in rows if not row.peak_only), default=longest)
    return robot_motion(motions, np.array(v_e), std or 0.0, np.array(late), end)


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


def _row(trial: Trial, look: TrialQuality, offset: float, longest: float, low_pass: LowPass | None) -> _Row:
    if trial.trace is None or look.phase is None:
        peak = np.array([] if trial.peak_force is None else [trial.peak_force])
        return _Row(np.zeros_like(peak), peak, np.full(peak.shape, look.peak_is_bound), 0.0, True)
    interval = trial.trace.step
    late = interval * round((look.trigger_offset or 0.0) / interval)
    part = slice(look.phase.start, look.phase.stop)
    time, force = trial.trace.time[part] - late, trial.trace.force[part] - offset
    # a late trigger leaves samples of no force behind time 0: comparison begins where force does
    begin = max(ONSET * interval, look.phase.onset - late - 0.5 * interval)
    used = (time > begin) & (time < longest)
    if trial.motion is not None:  # later it is not known how the robot moved
        used &= trial.trace.time[part] <= trial.motion.time[-1]
    if low_pass:
        used &= is_kept(trial.trace.time[part], interval, low_pass)
        if low_pass.zero_phase:  # what came after the recording's end is not known to have been filtered
            used &= trial.trace.time[part] < trial.trace.time[-1] - settling_time(low_pass)
    end = np.inf if look.phase.cut_off is None else look.phase.cut_off - offset
    force = np.minimum(force[used], end)
    return _Row(time[used], force, force == end, interval, False, late)
