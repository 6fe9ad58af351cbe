"""A Butterworth low-pass that readings have been through: an amplifier's, or one that was applied afterwards."""

from dataclasses import dataclass

import numpy as np
import scipy  # its parts load where they are used: a peak needs none of them
from numpy.typing import NDArray

from acf_jax.dataset.noise import Noise, approach_samples, shrunk
from acf_jax.dataset.trials import Array, LowPass, Trace

APPLIED_ORDER = 4  # of a filter whose cutoff alone is given: it leaves 1 % of a ring at three times that
SETTLED = 5.0  # e-folds of the slowest mode, after which a transient is over: 0.7 %
ROUNDING = 1e-6
PASSED = 0.9  # of half the sampling rate: a filter whose cutoff lies above passes all that is sampled


@dataclass(frozen=True)
class Filter:
    """What a `LowPass` does to values that are sampled every `interval` seconds."""

    low_pass: LowPass
    interval: float  # s

    @property
    def passes_all(self) -> bool:
        """Whether its cutoff lies above what the sampling holds."""
        return self.low_pass.cutoff_hz >= PASSED * 0.5 / self.interval

    @property
    def stride(self) -> int:
        """Samples of which one tells all that the filter leaves: two a period of the cutoff.

        White noise behind the filter is nearly independent from one such sample to the next. Between them the filter
        left next to nothing, of noise or of force: to compare every sample would count as certain what was taken out.
        """
        return max(1, int((0.5 + ROUNDING) / (self.low_pass.cutoff_hz * self.interval)))

    @property
    def gain(self) -> float:
        """Standard deviation of white noise behind the filter, over that before it."""
        return float(np.sqrt((self._of_one_sample**2).sum()))

    def after_one_sample(self, time: Array) -> Array:
        """What is left at times in s, shape (n,), of a single 1 that was sampled at time 0."""
        half = len(self._of_one_sample) // 2
        return np.interp(time, self.interval * np.arange(-half, half + 1), self._of_one_sample, 0.0, 0.0)

    @property
    def _of_one_sample(self) -> Array:
        n = int(2 * settling_time(self.low_pass) / self.interval) + 1
        return self(np.eye(1, 2 * n + 1, n)[0])

    def __call__(self, values: Array, before: float = 0.0) -> Array:
        """Filtered values, of the shape given, along the last axis; `before` the first one they had always been that.

        A filter without phase shift goes back over them from their end, as if they stayed what they are there.
        """
        if self.passes_all:
            return values
        start = self._at_rest(np.full(values.shape[:-1], before))
        once = scipy.signal.sosfilt(self._sections, values, axis=-1, zi=start)[0]
        if not self.low_pass.zero_phase:
            return np.asarray(once)
        back = once[..., ::-1]
        return np.asarray(
            scipy.signal.sosfilt(self._sections, back, axis=-1, zi=self._at_rest(back[..., 0]))[0][..., ::-1]
        )

    @property
    def _sections(self) -> Array:
        one = self.low_pass
        return np.asarray(scipy.signal.butter(one.order, one.cutoff_hz, fs=1 / self.interval, output="sos"))

    def _at_rest(self, values: Array) -> Array:
        """State of each section of a filter that has always been given these values (...): (sections, ..., 2)."""
        state = scipy.signal.sosfilt_zi(self._sections)
        return np.asarray(state.reshape(len(state), *[1] * values.ndim, 2) * values[..., None])


def settling_time(low_pass: LowPass) -> float:
    """How long a transient of the filter lasts, s."""
    slowest = 2 * np.pi * low_pass.cutoff_hz * np.sin(np.pi / (2 * low_pass.order))
    return float(SETTLED / slowest)


def is_even_enough(trace: Trace) -> bool:
    """Whether evenly spaced samples would be no more than twice as many: else most would be made up."""
    span = float(trace.time[-1] - trace.time[0])
    return span <= 2 * trace.time.size * trace.step


def low_passed(trace: Trace, low_pass: LowPass) -> Trace:
    """A trace behind the filter, evenly sampled; before it the sensor had read what it reads in the approach."""
    time, force = trace.time, trace.force
    interval = trace.step
    even = time[0] + interval * np.arange(int(np.floor((time[-1] - time[0]) / interval * (1 + 1e-9))) + 1)
    if even.size != time.size or np.abs(even - time).max() > 1e-3 * interval:
        force = np.interp(even, time, force)  # a reading was taken out, or the recorder's clock is uneven
        time = even
    before = approach_samples(trace).force
    return Trace(time, Filter(low_pass, interval)(force, float(before.mean()) if before.size else 0.0))


def approach_behind(trace: Trace, low_pass: LowPass) -> Trace:
    """The samples before contact that do not know of it, of a filtered trace: without phase shift some know."""
    approach = approach_samples(trace)
    if low_pass.zero_phase:
        early = approach.time < -settling_time(low_pass)
        approach = Trace(approach.time[early], approach.force[early])
    return approach


def thinned(trace: Trace, low_pass: LowPass) -> Trace:
    """The samples of a filtered trace that count as independent."""
    if trace.time.size < 2:
        return trace
    kept = is_kept(trace.time, trace.step, low_pass)
    return Trace(trace.time[kept], trace.force[kept])


def is_kept(time: Array, interval: float, low_pass: LowPass) -> NDArray[np.bool_]:
    """Whether samples at times in s, shape (n,), are compared: counted from time 0, so that repeats share them."""
    return np.asarray(np.round(time / interval).astype(int) % Filter(low_pass, interval).stride == 0)


def noise_behind(traces: list[Trace], low_pass: LowPass) -> Noise | None:
    """The noise of one sample behind a filter, from the approaches; None with fewer than two independent samples.

    Its size is the scatter about the mean of all, since neighbouring samples are alike and a single approach may be
    shorter than the noise is slow. Samples `Filter.stride` apart count as independent.
    """
    approaches = [approach_behind(trace, low_pass) for trace in traces]
    forces = np.concatenate([a.force for a in approaches] or [np.empty(0)])
    count = sum(a.time.size / Filter(low_pass, a.step).stride for a in approaches if a.time.size > 1)
    if count < 2:
        return None
    variance = float(forces.var()) * count / (count - 1)
    mean, by_chance = float(forces.mean()), variance / count
    return Noise(variance**0.5, offset=shrunk(mean, by_chance), offset_std=by_chance**0.5, samples=int(count))


def statement(low_pass: LowPass) -> str:
    """That data and model are filtered, in words."""
    way = "forwards and backwards" if low_pass.zero_phase else "forwards"
    return (
        f"data and model are low-passed at {low_pass.cutoff_hz:g} Hz (Butterworth, order {low_pass.order}, {way}): what"
        " is faster is left out, and peaks and predicted readings are those behind the filter"
    )
