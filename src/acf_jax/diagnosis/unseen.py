"""What fits predict of conditions that they did not see, and what follows from it."""

from dataclasses import dataclass, field

import numpy as np

from acf_jax.diagnosis.fit import Fit
from acf_jax.diagnosis.observe import Observations
from acf_jax.diagnosis.shrinkage import Shrinkage, force_shrinkage, form_of
from acf_jax.diagnosis.space import Explanation
from acf_jax.diagnosis.validate import HeldOut, hold_out


@dataclass(frozen=True)
class Unseen:
    """Predictions of one condition after the other by fits to the rest, each explanation's computed once."""

    observations: Observations
    measured_peak: np.ndarray  # (trials,) N
    recalibrated: Fit
    scattered: Fit  # says how much velocity, pretension and trigger really vary, see `hold_out`
    seed: int  # of the bootstrap
    known: dict[Explanation, HeldOut] = field(default_factory=dict)

    @property
    def exists(self) -> bool:
        """Whether there is a condition that a fit to the others does not see."""
        return len(np.unique(self.observations.condition)) > 1

    def of(self, fitted: Fit) -> HeldOut:
        """The predictions of a fit; of a single condition by the fit to it."""
        if fitted.explanation not in self.known:
            self.known[fitted.explanation] = hold_out(
                self.observations, fitted, self.measured_peak, self.scattered
            )
        return self.known[fitted.explanation]

    def shrinkage(self, corrected: Fit, probability: float) -> Shrinkage | None:
        """How far the gap of the recalibrated model shrinks with a corrected one, whose cause is as probable."""
        if not self.exists:
            return None
        fits = self.recalibrated, corrected
        held = self.of(self.recalibrated), self.of(corrected)
        return force_shrinkage(self.observations, fits, held, form_of(corrected, probability), self.seed)

    @property
    def is_gap_clear(self) -> bool:
        """Whether the recalibrated model misses by more than what no model could predict."""
        held, used = self.of(self.recalibrated), self.observations.traced
        return bool((held.residual[used] ** 2).mean() > 2 * held.floor[used].mean())
