"""Whether the times of the force are those at which it was sampled, once and by one clock.

A sensor samples at one rate. Two stretches of time that lie over one another are twice as dense as the rest, whatever
their stamps say; samples of two sources in turn alternate; stamps that were set on arrival come in bursts.
"""

import numpy as np

from acf_jax.recording.level import BLOCK
from acf_jax.recording.series import Array, Nanoseconds, Series, usual_step

_LEAST = 200  # samples that tell
_RATE = 128  # samples whose number in their time is a rate
_REGULAR = 0.05  # of the usual step that half of the steps miss it by at most
_FINE = 8  # samples that are a rate where the steps are regular
_RARE = 0.02  # share of the recording that may have lost samples evenly, so that the rest looks dense
_GAP = 3.0  # usual steps; what is longer is a gap
_SHORT, _LONG = (
    0.1,
    0.002,
)  # shares of steps below half of the mean and of gaps; where samples are lost none is short
_ALTERNATES = 4.0  # times the squared difference of every other sample: of a hum only near half the rate


def sampling_fault(force: Series, where: str, impact_time: float) -> str | None:
    """Why the samples cannot be in the order and at the times at which they were taken; None when they can.

    **Arguments:** `where`: the signal in words. `impact_time`: how long an impact lasts, roughly, s.
    """
    usual = _slow_step(force.time)
    for first in range(0, force.time.size, BLOCK):
        part = force.at(slice(first, first + BLOCK + 2 * _RATE))
        if part.time.size < _LEAST:
            continue
        if stretch := _dense_stretch(part.time, usual):
            begin, end = (1e-9 * float(time - force.time[0]) for time in stretch[:2])
            return (
                f"{where}: from {begin:.4g} s to {end:.4g} s it has {stretch[2]:.2g} times as many samples a second as"
                " elsewhere: time steps back unnoticed, as when the clock is set or a recording is played in a loop, or"
                " two publishers send at once; cut the recording there, or record it again"
            )
        if _alternates(part.value):
            return (
                f"{where}: its values alternate from sample to sample, those of two publishers or of two stretches of"
                " time under one clock; record each under a name of its own"
            )
        if fault := _bursts(part.time, impact_time):
            return f"{where}: {fault}"
    return None


def _slow_step(time: Nanoseconds) -> float:
    """The usual step where samples lie furthest apart, ns; 0 where there are too few."""
    found = [np.zeros(0)]
    for first in range(0, time.size - _RATE, BLOCK):
        steps = np.diff(time[first : first + BLOCK + 1])
        found.append(np.median(steps[: steps.size // _RATE * _RATE].reshape(-1, _RATE), axis=1))
    medians = np.concatenate(found)
    return float(np.quantile(medians, 1.0 - _RARE, method="lower")) if medians.size else 0.0


def _dense_stretch(time: Nanoseconds, usual: float) -> tuple[int, int, float] | None:
    """Begin and end (ns) of samples that lie denser than by the step `usual`, ns, and by what factor."""
    steps = np.diff(time)
    middle = np.median(steps)
    is_regular = np.median(np.abs(steps - middle)) < _REGULAR * middle
    # two clocks are twice as dense; a few samples of them already are where steps are regular
    count, factor = (_FINE, 4.0 / 3.0) if is_regular else (_RATE, 1.6)
    dense = (time[count:] - time[:-count]) * factor < count * usual
    edges = np.flatnonzero(np.diff(dense, prepend=False, append=False))
    for first, last in zip(edges[::2].tolist(), (edges[1::2] + count - 1).tolist(), strict=True):
        lasts = float(time[last] - time[first])
        early = (last - first) * usual - lasts
        if (
            steps[max(first - _RATE, 0) : first + count].max() < 0.5 * early
        ):  # else they were held up, then came at once
            return int(time[first]), int(time[last]), (last - first) * usual / max(lasts, 1.0)
    return None


def _alternates(value: Array) -> bool:
    """Whether a sample resembles the one before the last more than the last."""
    neighbours, others = np.diff(value), value[2:] - value[:-2]
    return float(neighbours @ neighbours) > _ALTERNATES * float(others @ others)


def _bursts(time: Nanoseconds, impact_time: float) -> str | None:
    """Why the times are those of arrival; None where they are spaced as a sensor samples."""
    steps, mean = np.diff(time), usual_step(time)
    is_long = steps > _GAP * np.median(steps)
    lasts = np.diff(time[np.r_[0, np.flatnonzero(is_long) + 1]]) - steps[is_long]  # from gap to gap
    is_in_packets = steps[is_long].sum() > 0.5 * steps.sum() and np.median(lasts) < 1e9 * impact_time
    is_late = np.mean(steps < 0.5 * mean) > _SHORT and np.mean(is_long) > _LONG
    if not (is_in_packets or is_late or np.median(np.abs(steps - mean)) > 0.5 * mean):
        return None
    packets = 1 + np.count_nonzero(is_long if is_in_packets else steps > mean)
    return (
        f"its samples come in packets of about {time.size / packets:.4g}, one packet every"
        f" {1e-6 * (time[-1] - time[0]) / packets:.3g} ms: their times were set on arrival, not when the force was"
        " sampled (or two publishers send at once). Stamp each sample at the sensor; where none is missing, space them"
        f" evenly, {1e-6 * (time[-1] - time[0]) / (time.size - 1):.6g} ms apart"
    )
