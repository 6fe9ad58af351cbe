"""What a fit owes to having seen what it is judged by: each condition predicted from the others, to first order.

A free curve follows the noise of the trials that it is fitted to, and leaves less of them than of others;
an effect with its few parameters hardly does. The chi-square that a condition leaves when the other ones alone are
fitted shows the difference (Stone, 'Cross-validatory choice', J. R. Stat. Soc. B 36, 1974); `optimism` is what it
exceeds the fit's own by (Efron, 'How biased is the apparent error rate', J. Am. Stat. Assoc. 81, 1986).
"""

from dataclasses import replace

import numpy as np

from acf_jax.inference.fit import Fit
from acf_jax.inference.linear import half_chi_square, normal_equations

MOST = 50.0  # chi-square; a larger one comes from a step on which first order no longer holds


def optimism(fitted: Fit, condition: np.ndarray) -> float:
    """Chi-square that the trials leave more where each condition is predicted by a fit of the others.

    One Gauss-Newton step leads to that fit; parameters at a bound stay there. The nuisances of the trials left out are
    fitted to them as ever.

    **Arguments:** `condition`: (trials,) to which condition each trial belongs.

    **Returns:** between 0 and `MOST`; 0 where there is one condition only, or the fit broke down.
    """
    conditions = np.unique(condition)
    if len(conditions) < 2 or not np.isfinite(fitted.objective):
        return 0.0
    unseen = sum(_left_unseen(fitted, condition == one) for one in conditions)
    return float(np.clip(unseen - fitted.chi2.sum(), 0.0, MOST))


def _left_unseen(fitted: Fit, out: np.ndarray) -> float:
    """Chi-square of the trials `out` after one step to the fit of the others, their nuisances fitted anew."""
    rest, left, free = np.flatnonzero(~out), np.flatnonzero(out), ~fitted.at_bound
    normal = normal_equations(fitted.linear.of(rest), fitted.u, fitted.nuisance[rest], fitted.misfit)
    step = np.zeros_like(fitted.u)
    step[free] = -np.linalg.solve(normal.hessian[np.ix_(free, free)], normal.gradient[free])
    linear, nuisance, none = fitted.linear.of(left), fitted.nuisance[left], np.zeros_like(step)
    there = replace(linear, residual=linear.residual - np.einsum("p,ipn->in", step, linear.by_parameter))
    return 2 * half_chi_square(there, none, nuisance) - normal_equations(there, none, nuisance).nuisance_gain
