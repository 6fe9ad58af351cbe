"""The impact phase of a trace: from first contact until it is lost, and what can be read off there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acf_jax.dataset.trials import Array, Trace

NEGATIVE = 0.03  # of the peak: so far below zero a reading has passed through it


@dataclass(frozen=True)
class ImpactPhase:
    """First contact until it is lost, as samples `start:stop` of the trace."""

    start: int
    stop: int
    onset: float  # s, first sample that is clearly above the noise
    contact_lost: float | None  # s; None: the trace ends in contact
    second_contact: float | None  # s; None: not within the trace
    peak_force: float  # N, largest sample, as the sensor reads it
    peak_time: float  # s
    lowest_force: float  # N, of a moving mean
    missed_peak: float  # N, how far the force may rise between the samples about the peak
    impulse: float  # N s, over the phase, sensor offset removed
    impulse_ratio: float | None  # impulse after the crest over that before it, once contact is lost
    offset: float = 0.0  # N, what the unloaded sensor reads
    cut_off: float | None = (
        None  # N, reading at which the force is cut off: a lower bound, as is the peak then
    )

    @property
    def height(self) -> float:
        """The peak above what the unloaded sensor reads, N."""
        return self.peak_force - self.offset


def find_impact(
    trace: Trace, noise_std: float, impact_time: float, offset: float = 0.0
) -> ImpactPhase | None:
    """Find the impact phase of a trace; None when no impact is seen.

    Contact counts as lost when a moving mean over 0.15 impact times falls to the noise or to 1 % of the
    peak: ringing about a positive force is not a loss, and a low saddle of the force is not either. Nor is a
    reading that goes on falling below zero: nothing pulls there, so contact lasts and the sensor errs.

    **Arguments:** `trace`: sensed force. `noise_std`: noise of one sample, N. `impact_time`: how long an impact
    lasts, roughly, s. `offset`: sensor offset to remove, N.
    """
    time, force = trace.time, trace.force - offset
    step = trace.step
    first = int(np.searchsorted(time, -0.5 * step))
    width = int(min(0.15 * impact_time / step, time.size)) | 1
    smooth = moving_mean(force, width)
    near = smooth[first : max(int(np.searchsorted(time, 3.0 * impact_time)), first + 1)]
    if near.size == 0 or near.max() <= 5.0 * noise_std / width**0.5:
        return None
    top = float(near.max())
    above = np.flatnonzero(force[max(first - 2, 0) :] > max(6.0 * noise_std, 0.02 * top))
    if above.size == 0:
        return None
    onset = int(above[0]) + max(first - 2, 0)
    start = min(first, onset)
    threshold = max(2.5 * noise_std, 0.01 * top)
    lost = _lost(smooth, start, top, threshold, width)
    stop = time.size
    if lost is not None:
        early = max(lost - width // 2 - 1, start + 1)
        stop = early + int(np.argmax(np.append(np.abs(force[early:lost]) <= threshold, True)))
    again = (
        None if lost is None else _above(smooth, stop + width, max(10.0 * noise_std, 0.2 * top), threshold)
    )
    peak = start + int(np.argmax(force[start:stop]))
    impulse = _integral(time[start:stop], force[start:stop])
    crest = start + int(np.argmax(smooth[start:stop]))
    before = _integral(time[start : crest + 1], force[start : crest + 1])
    return ImpactPhase(
        start=start,
        stop=stop,
        onset=float(time[onset]),
        contact_lost=None if lost is None else float(time[stop]),
        second_contact=None if again is None else float(time[again]),
        peak_force=float(trace.force[peak]),
        peak_time=float(time[peak]),
        lowest_force=float(smooth[start:stop].min()),
        missed_peak=missed_peak(force[start:stop], peak - start, noise_std),
        impulse=impulse,
        impulse_ratio=None if lost is None or before <= 0.0 else (impulse - before) / before,
        offset=offset,
    )


def moving_mean(values: Array, width: int) -> Array:
    """Mean over `width` (odd) samples about each sample, over fewer at the ends."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    index = np.arange(values.size)
    low, high = np.maximum(index - width // 2, 0), np.minimum(index + width // 2 + 1, values.size)
    return np.asarray((total[high] - total[low]) / (high - low))


def missed_peak(force: Array, peak: int, noise_std: float) -> float:
    """How far a force may rise above its largest sample, N.

    A parabola of curvature F'' that is sampled every h rises at most |F''| h^2/8 above its largest sample.
    h^2 F'' is the second difference at the peak where noise does not hide it, else that of a parabola
    through up to 11 samples.
    """
    if force.size < 3:
        return 0.0
    middle = min(max(peak, 1), force.size - 2)
    bend = float(2.0 * force[middle] - force[middle - 1] - force[middle + 1])
    if bend <= 5.0 * 6.0**0.5 * noise_std:
        half = min(5, middle, force.size - 1 - middle)
        if half >= 2:
            around = np.arange(-half, half + 1.0)
            bend = -2.0 * float(np.polyfit(around, force[middle - half : middle + half + 1], 2)[0])
    return max(bend, 0.0) / 8.0


def _lost(smooth: Array, start: int, top: float, threshold: float, width: int) -> int | None:
    """First sample at which the smoothed force stays near zero; None if it only passes through, or never is."""
    up = start + int(np.argmax(smooth[start:] > max(0.3 * top, 2.0 * threshold)))
    through = -max(threshold, NEGATIVE * top)
    lost = _first(smooth <= threshold, up)
    while lost is not None and (ahead := smooth[lost : lost + 2 * width]).min() < through:
        back = _first(smooth > -threshold, lost + int(np.argmin(ahead)))
        above = None if back is None else _first(smooth[: back + 2 * width] > threshold, back)
        lost = back if above is None else _first(smooth <= threshold, above)
    return lost


def _above(smooth: Array, start: int, clear: float, threshold: float) -> int | None:
    """Where a smoothed force that becomes clear after `start` had left the threshold; None if it does not."""
    clearly = _first(smooth > clear, start)
    if clearly is None:
        return None
    low = np.flatnonzero(smooth[start:clearly] <= threshold)
    return start + (int(low[-1]) + 1 if low.size else 0)


def _first(is_so: NDArray[np.bool_], start: int) -> int | None:
    """Index of the first sample from `start` on of which it is so; None if there is none."""
    found = np.flatnonzero(is_so[start:])
    return start + int(found[0]) if found.size else None


def _integral(time: Array, force: Array) -> float:
    return float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(time)))
