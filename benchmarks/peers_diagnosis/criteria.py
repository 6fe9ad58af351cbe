"""Model selection by AICc and BIC over the fits of our diagnosis, in the manner of PEtab Select.

Its formulas (petab_select/criteria.py, version 0.4), of k parameters, n samples and priors, and the objective J of a
fit, priors included: AICc = 2 k + 2 J + 2 k (k + 1)/(n - k - 1), BIC = k ln n + 2 J; probabilities are Akaike weights
exp(-D/2) (Burnham and Anderson, 'Model selection and multimodel inference', 2002). A free curve counts as 'unknown'.
What our evidence adds, a discrepancy of the forms and causes that hide in the rig, is left out.
"""

import functools
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from acf_jax.dataset import assess_dataset, read_dataset
from acf_jax.errors import InputError
from acf_jax.evidence.marginal import Marginal
from acf_jax.evidence.posterior import UNKNOWN
from acf_jax.inference.observations import observe
from acf_jax.inference.parameters import COMMON, Explanation, is_free_curve, parameters
from benchmarks.peers_diagnosis.cases import Case, Named

Criterion = Callable[[float, int, int], float]  # of objective, parameters, and samples with priors


def aicc(objective: float, k: int, n: int) -> float:
    """Akaike's information criterion, corrected for few samples."""
    return 2 * (k + objective) + 2 * k * (k + 1) / (n - k - 1)


def bic(objective: float, k: int, n: int) -> float:
    """The Bayesian information criterion."""
    return float(k * np.log(n) + 2 * objective)


CRITERIA: dict[str, Criterion] = {"AICc": aicc, "BIC": bic}


def size(explanation: Explanation) -> int:
    """Number of fitted parameters: the rig's, the explanation's, and what all trials share.

    What each trial has of its own is the same in every fit, and held by priors of known width.
    """
    return len(parameters(explanation)) + COMMON


def weigh(
    evidence: Sequence[Marginal], samples: int, criterion: Criterion
) -> list[tuple[Explanation, float]]:
    """Explanations with their Akaike weights, the largest first; those of free curves are summed up."""
    fits = [m for m in evidence if m.discrepancy == 0.0 and np.isfinite(m.objective)]
    sizes = [size(m.explanation) for m in fits]
    values = np.array(
        [criterion(m.objective, k, samples + k) for m, k in zip(fits, sizes, strict=True)]  # a prior each
    )
    weights = np.exp(-0.5 * (values - values.min()))
    total: dict[Explanation, float] = {}
    for m, weight in zip(fits, (weights / weights.sum()).tolist(), strict=True):
        named = UNKNOWN if is_free_curve(m.explanation) else m.explanation
        total[named] = total.get(named, 0.0) + weight
    return sorted(total.items(), key=lambda item: -item[1])


def select(case: Case, name: str) -> Named:
    """What a criterion says of a case; its time is that of our diagnosis, which made the fits."""
    if not case.evidence:
        raise InputError(f"{case.data}: its diagnosis holds no evidence; diagnose it with this version")
    begin = time.perf_counter()
    scored = weigh(case.evidence, count_samples(case.data), CRITERIA[name])
    return Named(tuple(scored), case.ours.seconds + time.perf_counter() - begin)


@functools.cache
def count_samples(data: Path) -> int:
    """How many samples of a data set the fits compare."""
    return observe(assess_dataset(read_dataset(data))).n_used
