"""How probable the data are under an explanation, whatever its parameters: the marginal likelihood, by Laplace.

With all parameters in units of their priors, log Z = -J - 1/2 log det H - 1/2 sum log det K_i: J the objective at its
optimum, H its curvature in the parameters, K_i that in the nuisances of trial i (MacKay, 'Information Theory,
Inference, and Learning Algorithms', 2003, ch. 28). A strength has no scale of its own: an effect is as likely to be of
any size, on a logarithmic scale, from what can just be told to the largest. The average over sizes is taken in closed
form.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.special import gammaln, logsumexp

from acf_jax.errors import InputError
from acf_jax.files import read_json_mapping
from acf_jax.inference.fit import Fit
from acf_jax.inference.parameters import RIG, Explanation, every_effect

SIZES = np.geomspace(2.0, 600.0, 200)  # whitened distances that an effect is as likely to have


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
    held, occam = np.zeros(len(fitted.u), bool), 0.0
    at = len(RIG)
    variance = np.linalg.inv(fitted.hessian)
    for name in fitted.explanation:
        effect = every_effect()[name]
        strengths = at + np.flatnonzero([not (p.shape or p.within) for p in effect.parameters()])
        at += len(effect.parameters())
        acting = strengths[~fitted.at_bound[strengths]]
        held[strengths] = fitted.at_bound[strengths]
        occam += _of_size(fitted.u[acting], variance[np.ix_(acting, acting)])
        occam -= np.log(2.0 ** len(strengths) - 1) + np.log(2.0) * effect.acts_either_way()
    free = ~held
    volume = np.linalg.slogdet(fitted.hessian[np.ix_(free, free)])[1] - fitted.log_det_nuisances.sum()
    o = fitted.observations
    # what the noise's volume grows by is about as much in each trial, and the same for all explanations beside a size
    of_trials = 0.5 * (fitted.log_det_nuisances - fitted.chi2) - log_volume / len(o.names)
    _, condition = np.unique(o.condition, return_inverse=True)
    return Marginal(
        fitted.explanation,
        discrepancy,
        fitted.objective,
        float(occam - 0.5 * volume - log_volume),
        of_conditions=tuple(np.bincount(condition, of_trials).tolist()),
    )


def _of_size(u: np.ndarray, variance: np.ndarray) -> float:
    """What the prior of acting strengths u (k,) is worth in place of a standard normal one, in log.

    Their sum r is log-uniform, their shares of it are uniform. `variance`: (k, k) of the strengths.
    """
    k, total = len(u), float(np.abs(u).sum())
    if not k:
        return float(logsumexp(-0.5 * SIZES**2) - np.log(len(SIZES)))  # it is not there
    sign = np.where(u < 0, -1.0, 1.0)
    std = max(float(np.sqrt(sign @ variance @ sign)), total / SIZES[-1])
    size = logsumexp(-0.5 * (total / std - SIZES) ** 2 - (k - 1) * np.log(SIZES)) - np.log(len(SIZES))
    shares = (k - 1) * 0.5 * np.log(2 * np.pi) + gammaln(k)
    return float(size + shares - k * np.log(std) + 0.5 * (u**2).sum())
