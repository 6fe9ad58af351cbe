"""How probable the data are under an explanation, whatever its parameters: the marginal likelihood, by Laplace.

With all parameters in units of their priors, log Z = -J - 1/2 log det H - 1/2 sum log det K_i: J the objective at its
optimum, H its curvature in the parameters, K_i that in the nuisances of trial i (MacKay, 'Information Theory,
Inference, and Learning Algorithms', 2003, ch. 28). Strengths have a prior of their own: see `strengths`.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from acf_jax.errors import InputError
from acf_jax.evidence.strengths import log_mean, weigh
from acf_jax.files import read_json_mapping
from acf_jax.inference.fit import Fit
from acf_jax.inference.parameters import Explanation


class Marginal(NamedTuple):
    """The evidence of one explanation beside one size of the discrepancy."""

    explanation: Explanation
    discrepancy: float  # size, of the force
    objective: float
    log_occam: float  # log Z + objective
    changes: tuple[float, ...] = ()  # N RMS, how large each of several laws is
    of_conditions: tuple[
        float, ...
    ] = ()  # log likelihood of each condition's trials, nuisances integrated out

    @property
    def log_z(self) -> float:
        """Log marginal likelihood, up to a constant that all explanations share."""
        return self.log_occam - self.objective


def read_evidence(path: Path) -> tuple[Marginal, ...]:
    """What a diagnosis.json holds under `evidence`; nothing where it has none.

    **Raises:** `InputError` where it cannot be read, or another version wrote it.
    """
    content = read_json_mapping(path, "diagnose again")
    try:
        return tuple(
            Marginal(
                tuple(entry["effects"]),
                entry["discrepancy"],
                entry["objective"],
                entry["log_occam"],
                tuple(entry["force_changes_n"]),
                tuple(entry["log_likelihood_of_conditions"]),
            )
            for entry in content.get("evidence") or ()
        )
    except (KeyError, TypeError):
        raise InputError(f"{path}: evidence: is not as this version writes it; diagnose again") from None


def marginal(fitted: Fit, discrepancy: float = 0.0, log_volume: float = 0.0) -> Marginal:
    """The evidence of a fit; `log_volume`: by how much that of the noise is larger than without the discrepancy."""
    weighed = weigh(fitted)
    volume = fitted.log_det_nuisances.sum() - np.linalg.slogdet(weighed.others)[1]
    o = fitted.observations
    # what the noise's volume grows by is about as much in each trial, and the same for all explanations beside a size
    of_trials = 0.5 * (fitted.log_det_nuisances - fitted.chi2) - log_volume / len(o.names)
    _, condition = np.unique(o.condition, return_inverse=True)
    return Marginal(
        fitted.explanation,
        discrepancy,
        fitted.objective,
        float(log_mean(weighed, fitted.explanation) + 0.5 * volume - log_volume),
        of_conditions=tuple(np.bincount(condition, of_trials).tolist()),
    )
