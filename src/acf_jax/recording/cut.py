"""The traces of contacts, cut from the recording, with their conditions."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acf_jax.dataset.noise import approach_samples
from acf_jax.dataset.phase import find_impact
from acf_jax.dataset.trials import Trace
from acf_jax.recording.contacts import LEAST_APPROACH, Contact
from acf_jax.recording.mapping import Contacts
from acf_jax.recording.series import Array, Nanoseconds, Series
from acf_jax.recording.velocity import Estimate

LEAST_BEFORE = 40  # samples of the approach in a trace
UNSURE = 0.2  # relative standard deviation of a velocity that nothing can be learnt from
_COMMANDED = 5e-4  # relative; no measured repeats agree better


@dataclass(frozen=True)
class Cut:
    """One contact as it goes into the data set, or not."""

    trial: str
    keep: bool
    contact: Contact
    time: Nanoseconds  # ns from first contact, shape (N,)
    force: Array  # N, shape (N,)
    velocity: Estimate  # m/s, measured
    pretension: Estimate  # N, measured
    condition: tuple[float, float] = (0.0, 0.0)  # m/s and N, of the group of trials that it belongs to
    peak: float | None = None  # N, within the impact phase; None: no impact is seen
    remarks: tuple[str, ...] = ()

    @property
    def trace(self) -> Trace:
        """Force over seconds from first contact."""
        return Trace(np.asarray(self.time * 1e-9, float), self.force)


def cut_trace(force: Series, contact: Contact, limit: int, options: Contacts) -> tuple[Nanoseconds, Array]:
    """Times from first contact (ns) and force (N), bit for bit, of a contact and its approach.

    **Arguments:** `limit`: index behind the last sample that may belong to it.
    """
    before = max(
        contact.first - int(np.searchsorted(force.time, contact.begin - round(1e9 * options.before_s))),
        LEAST_BEFORE,
    )
    first = max(contact.first - before, contact.approach)
    last = min(int(np.searchsorted(force.time, contact.begin + round(1e9 * options.after_s), "right")), limit)
    value = force.value[first:last]
    return force.time[first:last] - contact.begin, value - contact.offset if options.tare else value.copy()


def impact_peak(cut: Cut, impact_time: float, tared: bool) -> float | None:
    """The largest sample of the impact phase, N, or None; `impact_time`: how long an impact lasts, roughly, s."""
    offset = 0.0 if tared else cut.contact.offset
    phase = find_impact(cut.trace, cut.contact.noise_std, impact_time, offset)
    return phase.peak_force if phase else None


def remarks(cut: Cut, typical_rise: float) -> list[str]:
    """Why a contact may not be what it seems. `typical_rise`: of the recording's contacts, N."""
    found = []
    before = approach_samples(cut.trace).time.size
    if before < LEAST_APPROACH - 4:
        found.append(f"only {before} samples before contact")
    if cut.contact.rise < 0.2 * typical_rise:
        found.append(f"rises by {cut.contact.rise:.3g} N only")
    if cut.velocity.value <= 0.0:
        found.append("the robot does not approach")
    elif cut.velocity.std > UNSURE * cut.velocity.value:
        found.append(
            f"the velocity of {cut.velocity.value:.3g} m/s is uncertain by {cut.velocity.std:.2g} m/s"
        )
    return found


def group(values: Sequence[Estimate], least: float = 0.02) -> Array:
    """For each value the mean of those that are the same within their scatter, rounded to four digits.

    Sorted values belong together until a gap exceeds three standard deviations of a difference, and `least` of
    the value. A trial's condition has to be that of its repeats: the diagnosis is checked on whole conditions.
    """
    mean = np.array([v.value for v in values])
    std = np.array([v.std for v in values])
    order = np.argsort(mean, kind="stable")
    gap = np.diff(mean[order])
    apart = gap > np.maximum(3.0 * np.hypot(std[order][1:], std[order][:-1]), least * np.abs(mean[order][1:]))
    member = np.empty(mean.size, np.intp)
    member[order] = np.r_[0, np.cumsum(apart)] if mean.size else order
    return np.array([float(f"{mean[member == m].mean():.4g}") + 0.0 for m in member])


def spread(values: Sequence[Estimate], groups: Array) -> float | None:
    """Relative standard deviation of values about their groups, three digits; None where they cannot tell.

    Without repeats nothing does, and repeats that are all the same were commanded rather than measured.
    """
    mean = np.array([v.value for v in values])
    free = mean.size - np.unique(groups).size
    if free < 3 or not np.all(groups > 0.0):
        return None
    found = float(np.sqrt((((mean - groups) / groups) ** 2).sum() / free))
    return float(f"{found:.3g}") if found > _COMMANDED else None
