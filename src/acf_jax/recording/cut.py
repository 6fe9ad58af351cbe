"""The traces of contacts, cut from the recording, with their conditions."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acf_jax.dataset.noise import approach_samples
from acf_jax.dataset.phase import find_impact
from acf_jax.dataset.trials import RobotVelocity, Trace
from acf_jax.recording.contacts import Contact
from acf_jax.recording.mapping import Contacts
from acf_jax.recording.onset import LEAST_APPROACH, SURE
from acf_jax.recording.series import Array, Nanoseconds, Series
from acf_jax.recording.velocity import Estimate

LEAST_BEFORE = 40  # samples of the approach in a trace
UNSURE = 0.2  # relative standard deviation of a velocity that nothing can be learnt from
GAP = 3.0  # sampling intervals between two samples: some are missing
_FALLEN = 0.5  # of its rise that is gone after a contact at the latest
_WIDEST = 3.0  # least gaps, from the smallest to the largest value of a condition
_COMMANDED = 5e-4  # relative; no measured repeats agree better
_SMALL = 0.05  # of the largest condition, below which a relative scatter says nothing


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
    zero: float = 0.0  # N, taken off the force: what the unloaded sensor reads
    condition: tuple[float, float] = (0.0, 0.0)  # m/s and N, of the group of trials that it belongs to
    peak: float | None = None  # N, within the impact phase; None: no impact is seen
    remarks: tuple[str, ...] = ()
    motion: RobotVelocity | None = None  # None: not measured, or too seldom to tell how the robot moved

    @property
    def words(self) -> str:
        """What was measured, on one line."""
        v_e, f_p = self.velocity.value, self.pretension.value
        speed = f"{v_e:.4g} m/s" if np.isfinite(v_e) else "no speed"
        return (
            f"{speed}, {f'{f_p:.4g} N' if np.isfinite(f_p) else 'no pretension'}, peak {self.reading:.4g} N"
        )

    @property
    def reading(self) -> float:
        """The peak, or the largest force where no impact is seen, N."""
        return self.contact.peak - self.zero if self.peak is None else self.peak

    @property
    def offset(self) -> float:
        """What the force of the trace reads before contact, N."""
        return self.contact.offset - self.zero

    @property
    def trace(self) -> Trace:
        """Force over seconds from first contact."""
        return Trace(np.asarray(self.time * 1e-9, float), self.force)


def zeros(contacts: Sequence[Contact]) -> list[float]:
    """What the unloaded sensor reads at each contact, N.

    One value for all that agree with the middle one within the noise of a sample, so that readings which are equal stay
    so, as at the end of the sensor's range; else, as of a sensor that drifts, the contact's own.
    """
    middle = float(np.median([contact.offset for contact in contacts])) if contacts else 0.0
    return [middle if abs(c.offset - middle) <= c.noise_std else c.offset for c in contacts]


def cut_trace(
    force: Series, contact: Contact, limit: int, options: Contacts, zero: float
) -> tuple[Nanoseconds, Array]:
    """Times from first contact (ns) and force (N), but for `zero` bit for bit, of a contact and its approach.

    **Arguments:** `limit`: index behind the last sample that may belong to it. `zero`: taken off the force, N.
    """
    before = max(
        contact.first - int(np.searchsorted(force.time, contact.begin - round(1e9 * options.before_s))),
        LEAST_BEFORE,
    )
    first = max(contact.first - before, contact.approach)
    last = min(int(np.searchsorted(force.time, contact.begin + round(1e9 * options.after_s), "right")), limit)
    return force.time[first:last] - contact.begin, force.value[first:last] - zero


def impact_peak(cut: Cut, impact_time: float) -> float | None:
    """The largest sample of the impact phase, N, or None; `impact_time`: how long an impact lasts, roughly, s."""
    phase = find_impact(cut.trace, cut.contact.noise_std, impact_time, cut.offset)
    return phase.peak_force if phase else None


def ends_early(cut: Cut, impact_time: float) -> bool:
    """Whether the trace is shorter than two impacts and at its highest where it ends: it still rises there."""
    time, force = cut.trace.time, cut.force
    last = time > time[-1] - 0.1 * impact_time
    return bool(time[-1] < 2.0 * impact_time and force[last].max() >= force.max())


def remarks(cut: Cut, typical_rise: float, step: float, separation: float) -> list[str]:
    """Why a contact may not be what it seems.

    **Arguments:** `typical_rise`: of the recording's contacts, N. `step`: sampling interval, s. `separation`: least
    time between contacts, s.
    """
    found = []
    steps = np.diff(cut.time)
    if steps.size and steps.max() > GAP * 1e9 * step:
        worst = int(np.argmax(steps))
        found.append(
            f"samples are missing for {1e-6 * steps[worst]:.3g} ms, from {1e-6 * cut.time[worst]:.3g} ms after contact"
        )
    before = approach_samples(cut.trace).time.size
    if before < SURE:
        is_slow = LEAST_APPROACH * step > separation
        remedy = "record the force faster" if is_slow else "pause longer before each"
        found.append(f"only {before} samples before contact: {remedy}")
    if cut.contact.rise < 0.2 * typical_rise:
        found.append(f"rises by {cut.contact.rise:.3g} N only")
    if cut.contact.stays > _FALLEN * cut.contact.rise:
        found.append(f"the force stays {cut.contact.stays:.3g} N higher after it, a step of the sensor")
    if cut.velocity.value <= 0.0:
        found.append("the robot does not approach")
    elif cut.velocity.std > UNSURE * cut.velocity.value:
        found.append(
            f"the velocity of {cut.velocity.value:.3g} m/s is uncertain by {cut.velocity.std:.2g} m/s"
        )
    return found


def group(values: Sequence[Estimate], least: float = 0.02) -> Array:
    """For each value the mean of those that are the same within their scatter, rounded to four digits.

    Sorted values belong together until one is further than three standard deviations of a difference, and `least` of
    the value, from the one before, or `_WIDEST` times that from the first: neighbours that agree do not make a chain.
    A trial's condition has to be that of its repeats: the diagnosis is checked on whole conditions.
    """

    def agree(i: int, j: int, wide: float) -> bool:
        scatter = 3.0 * float(np.hypot(values[i].std, values[j].std))
        return values[i].value - values[j].value <= max(scatter, wide * least * abs(values[i].value))

    groups: list[list[int]] = []
    for i in sorted(range(len(values)), key=lambda i: values[i].value):
        if groups and agree(i, groups[-1][-1], 1.0) and agree(i, groups[-1][0], _WIDEST):
            groups[-1].append(i)
        else:
            groups.append([i])
    means = np.empty(len(values))
    for members in groups:
        means[members] = float(f"{np.mean([values[i].value for i in members]):.4g}") + 0.0
    return means


def spread(values: Sequence[Estimate], groups: Array) -> float | None:
    """Relative standard deviation of what was measured about its groups, three digits; None where it cannot tell.

    How uncertain each value is does not count as scatter. Without repeats nothing can tell, and repeats that are all
    the same were commanded rather than measured.
    """
    large = groups > _SMALL * groups.max()
    mean = np.array([v.value for v in values])[large]
    own = np.array([v.std for v in values])[large]
    middle = groups[large]
    free = middle.size - np.unique(middle).size
    if free < 3:
        return None
    variance = (((mean - middle) / middle) ** 2).sum() / free - ((own / middle) ** 2).mean()
    found = float(np.sqrt(max(variance, 0.0)))
    return float(f"{found:.3g}") if found > _COMMANDED else None
