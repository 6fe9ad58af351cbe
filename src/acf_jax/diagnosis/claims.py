"""What may be claimed of the corrected model: no more than what it does on conditions that the fit did not see.

One rule for report, terminal, diagnosis.json and every command that uses the model: it is better than the
recalibrated one where the figures that are printed of held-out conditions say so.
"""

from typing import NamedTuple

from acf_jax.diagnosis.damage import EVEN
from acf_jax.diagnosis.heldout import GapFigures
from acf_jax.diagnosis.shrinkage import Shrinkage

FORCE_DIGITS, PEAK_DIGITS = 3, 2  # significant figures that are printed


class Change(NamedTuple):
    """A figure of the recalibrated and of the corrected model, as it is printed."""

    before: float
    after: float


class Comparison(NamedTuple):
    """Corrected against recalibrated model on held-out conditions; None where a figure does not exist."""

    force: Change | None  # N RMS
    peak: Change | None  # % RMS
    misses: bool = (
        False  # whether it misses the peaks of its own trials by more than the other one held-out ones
    )

    @property
    def is_better(self) -> bool:
        """Whether the force error is less and the peak error not more; of peaks alone, whether that is less."""
        if self.misses or (self.peak and self.peak.after > self.peak.before):
            return False
        return (self.force or self.peak) is not None and not self.is_denied

    @property
    def is_denied(self) -> bool:
        """Whether held-out conditions speak against it: the force error is not less; of peaks alone, the peak error."""
        decides = self.force or self.peak
        return decides is not None and decides.after >= decides.before

    @property
    def tells_peak(self) -> bool:
        """Whether a corrected peak may be stated: it is better, and there are peaks that say so."""
        return self.is_better and self.peak is not None

    @property
    def figures(self) -> str:
        """The figures in words."""
        shown = [
            f"{what} error {change.before:.{digits}g} → {change.after:.{digits}g} {unit}"
            for what, change, digits, unit in (
                ("force", self.force, FORCE_DIGITS, "N"),
                ("peak", self.peak, PEAK_DIGITS, "%"),
            )
            if change
        ]
        return ", ".join(shown)

    @property
    def statement(self) -> str:
        """What is said of a corrected model that is not better."""
        if not self.force and not self.peak:
            return "whether the corrected model is better than the recalibrated one on other conditions is not known"
        own = "; it misses the peaks of the trials it was fitted to" if self.misses else ""
        return (
            "on conditions that the fit did not see the corrected model is not better than the recalibrated one"
            f" ({self.figures}{own}): no share removed, no corrected peak and no speed is stated"
        )


def compare(recalibrated: GapFigures, corrected: GapFigures, of_trials: GapFigures) -> Comparison:
    """The two models by their figures on held-out conditions; `of_trials`: the corrected one's on its own trials."""
    force = _change(recalibrated.force_rms_n, corrected.force_rms_n, FORCE_DIGITS)
    peak = _change(recalibrated.peak_rms_percent, corrected.peak_rms_percent, PEAK_DIGITS)
    own = _change(recalibrated.peak_rms_percent, of_trials.peak_rms_percent, PEAK_DIGITS)
    return Comparison(force, peak, own is not None and own.after > own.before)


def highest_probability(comparison: Comparison, floor: float | None, is_missing: bool) -> float:
    """How probable laws may be called at most, by what held-out conditions say of them.

    Where a cause `is_missing` beside them, they are at most as probable as the share is that they explain of the gap's
    mean square there. Even odds where that is not known, or where their force error is not less. `floor`: N RMS.
    """
    if is_missing and comparison.force and floor is not None and comparison.force.before > floor:
        return max(1 - _left(*comparison.force, floor), 0.0)
    return EVEN if is_missing or comparison.is_denied else 1.0


def agreeing(
    shrinkage: Shrinkage | None, recalibrated: GapFigures, corrected: GapFigures, floor: float | None
) -> Shrinkage | None:
    """The shrinkage of the force so that it agrees with the figures beside it.

    Its interval holds the share that these give, noise removed in quadrature. Where it reaches to zero, all else that
    is known says too little, and that share is stated.
    """
    before, after = recalibrated.force_rms_n, corrected.force_rms_n
    if shrinkage is None or before is None or after is None or floor is None or before <= floor:
        return shrinkage
    share = 1 - _left(before, after, floor) ** 0.5
    low, high = shrinkage.ci95
    low = min(low, share)
    value = shrinkage.value if low > 0 else share
    return Shrinkage(value, (low, max(high, value)))


def _left(before: float, after: float, floor: float) -> float:
    """What is left of a gap's mean square that is above the scatter, which is taken off."""
    return max(after**2 - floor**2, 0.0) / (before**2 - floor**2)


def _change(before: float | None, after: float | None, digits: int) -> Change | None:
    if before is None or after is None:
        return None
    return Change(float(f"{before:.{digits}g}"), float(f"{after:.{digits}g}"))
