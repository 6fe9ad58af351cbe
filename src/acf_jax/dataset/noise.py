"""Force noise, from the samples before contact: its size, and whether neighbouring samples share it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from acf_jax.dataset.trials import Array, Trace

OF_MEDIAN = 1.4826  # standard deviation over median of what noise gives, signs left out
_LONGEST = 200  # samples of one approach that enter the fit; more would only cost time
_COLOURED = 12.0  # twice the gain in log likelihood that colour must bring: under 1 % false alarms
_CONTRADICTS = 8.0  # the same by which samples contradict a stated standard deviation: 0.5 % false alarms
_BY_CHANCE = 1e-4  # probability above which equal readings may be chance


@dataclass(frozen=True)
class Noise:
    """White noise plus noise of a correlation time (an Ornstein-Uhlenbeck process).

    cov(t, t') = std^2 ((1 - share) [t = t'] + share exp(-|t - t'|/correlation_time))

    Stated in time rather than in samples, it holds for every sampling rate of a data set.
    """

    std: float  # N, of one sample
    share: float = 0.0  # of the variance that is correlated; 0: white
    correlation_time: float = 0.0  # s
    offset: float = 0.0  # N, of the approach over all trials, as far as it is beyond chance
    offset_std: float = 0.0  # N, of that offset; 0: nothing is said of it
    samples: int = 0  # samples that the estimate rests on
    source: str = "approach"  # or stated, differences, repeats, assumed

    @property
    def is_white(self) -> bool:
        """Whether samples are independent."""
        return self.share == 0.0

    @property
    def doubt(self) -> float:
        """By which share a mean square of whitened noise may exceed 1, since its colour is told from few samples.

        Two standard deviations of the mean square of as many samples; 0 where noise is white.
        """
        return 0.0 if self.is_white else 2 * float(np.sqrt(2 / max(self.samples, 2)))

    def covariance(self, time: Array) -> Array:
        """Covariance of the samples at `time` (s, shape (N,)), N^2, shape (N, N)."""
        return self.std**2 * _correlation(np.asarray(time, float), self.share, self.correlation_time)

    def samples_per_independent(self, step: float) -> float:
        """Integrated autocorrelation: how many samples `step` seconds apart count as one for a mean."""
        if self.is_white:
            return 1.0
        decay = float(np.exp(-step / self.correlation_time))
        return 1.0 + 2.0 * self.share * decay / (1.0 - decay)


@dataclass(frozen=True)
class Approach:
    """What the samples before contact say about the sensor."""

    samples: int
    noise_std: float  # N, about the straight line below
    offset: float  # N, mean
    drift: float  # N/s, slope
    drift_std: float  # N/s, for independent samples


def approach_samples(trace: Trace) -> Trace:
    """The samples surely before contact: the last four before time 0 may hold a late trigger or ringing."""
    last = max(int(np.searchsorted(trace.time, 0.0)) - 4, 0)
    return Trace(trace.time[:last], trace.force[:last])


def constant_approaches(traces: Sequence[Trace]) -> list[bool]:
    """Which approaches tell nothing of the noise, as their readings differ by no more than rounding.

    Not those that are constant by chance, which the other approaches show where readings are coarse.
    """
    forces = [approach_samples(trace).force[-_LONGEST:] for trace in traces]
    still = [bool(np.allclose(force, force[:1], rtol=1e-9, atol=1e-9)) for force in forces]
    if all(still):
        return still
    changing = np.concatenate([force for force, is_still in zip(forces, still, strict=True) if not is_still])
    share = np.unique(changing, return_counts=True)[1] / changing.size
    return [
        is_still and float((share**force.size).sum()) < _BY_CHANCE
        for force, is_still in zip(forces, still, strict=True)
    ]


def look_at_approach(trace: Trace) -> Approach | None:
    """Offset, drift and noise of one trial's approach; None with fewer than five samples."""
    before = approach_samples(trace)
    n = before.time.size
    if n < 5:
        return None
    time = before.time - before.time.mean()
    offset = float(before.force.mean())
    spread = float(time @ time)
    drift = float(time @ before.force) / spread
    rest = before.force - offset - drift * time
    variance = float(rest @ rest) / (n - 2)
    std = variance**0.5
    return Approach(n, std, offset, drift, std / spread**0.5)


def fit_noise(traces: Sequence[Trace], stated: float | None = None) -> Noise | None:
    """Maximum likelihood noise of all approaches together; None with fewer than ten samples.

    White unless the correlated part earns its two parameters. An offset of its own in each trial reads
    as a correlation time longer than the approach. A standard deviation that is `stated` (N) and that these samples
    do not contradict is held: of correlated samples it is poorly known, and an error in it goes into the correlation.
    Constant approaches tell nothing and are left out; where all are constant, the answer has a std of 0.
    """
    constant = constant_approaches(traces)
    told = [trace for trace, is_still in zip(traces, constant, strict=True) if all(constant) or not is_still]
    groups = _group([approach_samples(trace) for trace in told])
    count = sum(force.size for force, _ in groups)
    if count < 10:
        return None
    white = _fit(groups, 0.0, 1.0)
    if all(constant):
        return Noise(0.0, offset=white.offset, samples=count)
    step = min(step for _, step in groups)
    window = max(step * force.shape[1] for force, step in groups)
    starts = [(share, tau) for share in (0.1, 0.3, 0.6, 0.95) for tau in np.geomspace(step, 2 * window, 7)]

    def coloured(held: float | None) -> tuple[float, float, float]:
        """Loss, share and correlation time."""
        from scipy.optimize import minimize  # slow to import, and not every command reads traces

        share, tau = min(starts, key=lambda start: _fit(groups, start[0], start[1], held).loss)
        start = [np.log(share / (1 - share)), np.log(tau)]
        best = minimize(lambda x: _fit(groups, *at(x), held).loss, start, method="Nelder-Mead")
        return float(best.fun), *at(best.x)

    def at(x: Array) -> tuple[float, float]:
        tau = float(np.exp(np.clip(x[1], np.log(0.2 * step), np.log(10.0 * window))))
        return 0.999 / (1.0 + float(np.exp(-np.clip(x[0], -9, 9)))), tau

    loss, share, tau = coloured(None)
    if 2.0 * (white.loss - loss) < _COLOURED:
        return Noise(white.std, offset=white.offset, offset_std=white.offset_std, samples=count)
    found = _fit(groups, share, tau)
    if stated:
        loss_held, *held = coloured(stated)
        if 2.0 * (loss_held - loss) < _CONTRADICTS:
            share, tau = held
            found = _fit(groups, share, tau, stated)
    return Noise(found.std, share, tau, found.offset, found.offset_std, count)


def difference_noise(traces: Sequence[Trace]) -> Noise | None:
    """White noise from third differences within the contact, for traces that start at time 0.

    A smooth force has none; for independent samples the variance of a third difference is 20 std^2.
    """
    thirds = [np.diff(trace.force[trace.time >= 0.0][2:], 3) for trace in traces]
    pooled = np.concatenate([third for third in thirds if third.size >= 8] or [np.empty(0)])
    if pooled.size < 10:
        return None
    std = robust_std(pooled) / 20.0**0.5
    return Noise(std, samples=pooled.size, source="differences")


def robust_std(away: Array) -> float:
    """Standard deviation of normal values about zero by the median of their sizes, which a few odd ones hardly move."""
    return OF_MEDIAN * float(np.median(np.abs(away)))


def shrunk(mean: float, variance: float) -> float:
    """A mean less what noise of this variance alone would make of it: James and Stein's estimate, never beyond zero."""
    return mean * max(0.0, 1.0 - variance / mean**2) if mean else 0.0


def quantisation_step(force: Array) -> float:
    """The step by which force readings differ, N; 0 where there is none. One in ten may be off it."""
    gaps = np.diff(np.unique(force))
    gaps = gaps[gaps > 1e-9 * max(1.0, float(np.abs(force).max()))]
    for step in np.sort(gaps)[:5]:
        ratios = gaps / step
        if np.mean(np.abs(ratios - np.round(ratios)) < 0.05) > 0.9:
            return float(step)
    return 0.0


def _correlation(time: Array, share: float, tau: float) -> Array:
    identity = np.eye(time.size)
    if share == 0.0:
        return identity
    lags = np.abs(time[:, None] - time[None, :])
    return np.asarray((1.0 - share) * identity + share * np.exp(-lags / tau))


def _group(traces: Sequence[Trace]) -> list[tuple[Array, float]]:
    """Approaches of one length and step stacked, shape (trials, samples), each with its step in s."""
    groups: dict[tuple[int, float], list[Array]] = {}
    for trace in traces:
        if trace.time.size >= 3:
            step = trace.step
            force = trace.force[-_LONGEST:]
            groups.setdefault((force.size, float(f"{step:.2g}")), []).append(force)
    return [(np.stack(forces), step) for (_, step), forces in groups.items()]


class _Told(NamedTuple):
    """What approaches say at one correlation."""

    loss: float  # negative log likelihood
    offset: float  # N
    offset_std: float
    std: float  # N, of one sample


def _fit(groups: list[tuple[Array, float]], share: float, tau: float, std: float | None = None) -> _Told:
    """What approaches say at one correlation; offset and std are profiled out, the latter where it is not given.

    The offset is shrunk: a sensor that was zeroed keeps its zero, instead of an error that all readings would share.
    """
    whitened, count, logdet = [], 0, 0.0
    for force, step in groups:
        time = step * np.arange(force.shape[1], dtype=float)
        factor = np.linalg.cholesky(_correlation(time, share, tau))
        both = np.linalg.solve(factor, np.vstack([force, np.ones(force.shape[1])]).T).T
        whitened.append((both[:-1], both[-1]))
        count += force.size
        logdet += 2.0 * force.shape[0] * float(np.log(np.diag(factor)).sum())
    weight = sum(z.shape[0] * float(one @ one) for z, one in whitened)
    mean = sum(float((z @ one).sum()) for z, one in whitened) / weight
    variance = sum(float(((z - mean * one) ** 2).sum()) for z, one in whitened) / (count - 1)
    spread = max(variance, 1e-300) if std is None else std**2
    by_chance = spread / weight  # variance of the mean
    loss = 0.5 * (count * (float(np.log(spread)) + variance / spread) + logdet)
    return _Told(loss, shrunk(mean, by_chance), by_chance**0.5, spread**0.5)
