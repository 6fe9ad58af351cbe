"""Whether the force was sampled fast enough for its impacts, and how far too low their peaks may read otherwise."""

from collections.abc import Sequence

import numpy as np

from acf_jax.dataset.units import is_undersampled
from acf_jax.recording.cut import Cut

IN_MS = "if its times are in ms, set time_scale: 1.0e-3 in the --mapping file (us: 1.0e-6, ns: 1.0e-9)"
TOLD = 0.01  # of a peak; less is below what velocities and sensors are uncertain by
_MISSED = 1e-3  # of a peak, at the rate that is advised
_ROUND = (1.0, 2.0, 4.0, 5.0, 8.0, 10.0)


def missed_share(step: float, duration: float) -> float:
    """By which share of its peak a half-sine reads too low at most: 1 - cos(pi h/(2 T)).

    The peak lies midway between two samples at worst.

    **Arguments:** `step`: h, sampling interval, s. `duration`: T, of the half-sine, s.
    """
    return float(1.0 - np.cos(0.5 * np.pi * min(step / duration, 1.0)))


def advised_rate(duration: float) -> str:
    """A round sampling rate that misses a thousandth of a peak, in words. `duration`: of the half-sine, s."""
    least = np.pi / (2.0 * duration * np.arccos(1.0 - _MISSED))
    power = 10.0 ** np.floor(np.log10(least))
    rate = next(power * r for r in _ROUND if power * r >= 0.999 * least)
    return f"{1e-3 * rate:g} kHz" if rate >= 1000 else f"{rate:g} Hz"


def impact_duration(cuts: Sequence[Cut], step: float, impact_time: float) -> float:
    """How long an impact lasts, as a half-sine, s: three times what its force takes from the peak halfway down.

    As the peak is known to half a sample only, that leaves a range, in which what is expected counts.

    **Arguments:** `step`: sampling interval, s. `impact_time`: what is expected, s.
    """
    halves = [half for cut in cuts if (half := _half(cut, 3.0 * impact_time)) is not None]
    if not halves:
        return impact_time
    half = float(np.median(halves))
    return float(np.clip(impact_time, 3.0 * (half - 0.5 * step), 3.0 * (half + 0.5 * step)))


def too_slow(step: float, duration: float) -> str | None:
    """How far peaks may read too low, with the remedy; None where it hardly matters. Arguments as of `missed_share`."""
    missed = missed_share(step, duration)
    if missed < TOLD:
        return None
    in_ms = f", or {IN_MS}" if is_undersampled(step, duration) else ""
    return (
        f"the force has a sample every {1e3 * step:.3g} ms, and an impact lasts about {1e3 * duration:.2g} ms: peaks"
        f" are up to {float(f'{100 * missed:.2g}'):g} % too low; record it faster, at {advised_rate(duration)}{in_ms}"
    )


def _half(cut: Cut, longest: float) -> float | None:
    """The time from the highest sample to halfway down to the lowest behind it, s, both within `longest` of contact.

    The force may rest at the pretension rather than at zero; None where it does not fall.
    """
    time, force = cut.trace.time, cut.force
    first, end = (int(i) for i in np.searchsorted(time, (0.0, longest)))
    near = force[first:end]
    if near.size == 0 or near[(top := int(np.argmax(near))) :].min() == near[top]:
        return None
    middle = 0.5 * float(near[top] + near[top:].min())
    after = top + int(np.argmax(near[top:] <= middle))
    share = (near[after - 1] - middle) / (near[after - 1] - near[after])
    half = (
        time[first + after - 1] + share * (time[first + after] - time[first + after - 1]) - time[first + top]
    )
    return float(half)
