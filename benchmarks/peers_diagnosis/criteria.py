"""Model selection by AICc and BIC over the fits of our diagnosis, as PEtab Select does it.

PEtab Select's formulas, with 2 nllh = twice the objective of the fit, priors included: AICc = 2 k + 2 nllh +
2 k (k + 1)/(n - k - 1), BIC = k ln n + 2 nllh, where n counts samples and priors, and Akaike weights exp(-D/2) for
probabilities (Pathirana et al., 'PEtab Select', PLoS Comput. Biol., 2025; Burnham and Anderson, 2002). A free curve
counts as 'unknown'; what our evidence adds, a discrepancy of the forms and causes that hide in the rig, is left out.
"""

import time
from collections.abc import Callable, Sequence

import numpy as np
from petab_select.criteria import calculate_aicc, calculate_bic

from acf_jax.errors import InputError
from acf_jax.evidence.marginal import Marginal
from acf_jax.evidence.posterior import stated
from acf_jax.inference.parameters import COMMON, Explanation, parameters
from benchmarks.peers_diagnosis.cases import Case, Named

Criterion = Callable[[float, int, int, int], float]  # of nllh, k, samples, priors
CRITERIA: dict[str, Criterion] = {"AICc": calculate_aicc, "BIC": calculate_bic}


def size(explanation: Explanation) -> int:
    """Number of fitted parameters: the rig's, the explanation's, and what all trials share.

    What each trial has of its own is the same in every fit, and held by priors of known width.
    """
    return len(parameters(explanation)) + COMMON


def weigh(evidence: Sequence[Marginal], samples: int, criterion: Criterion) -> list[tuple[Explanation, float]]:
    """Explanations with their Akaike weights, the largest first; those of free curves are summed up."""
    fits = [m for m in evidence if m.discrepancy == 0.0 and np.isfinite(m.objective)]
    sizes = [size(m.explanation) for m in fits]
    values = np.array(
        [criterion(m.objective, k, samples, k) for m, k in zip(fits, sizes, strict=True)]
    )
    weights = np.exp(-0.5 * (values - values.min()))
    total: dict[Explanation, float] = {}
    for m, weight in zip(fits, (weights / weights.sum()).tolist(), strict=True):
        total[stated(m.explanation)] = total.get(stated(m.explanation), 0.0) + weight
    return sorted(total.items(), key=lambda item: -item[1])


def select(case: Case, samples: int, name: str) -> Named:
    """What a criterion says of a case; its time is that of our diagnosis, which made the fits."""
    if not case.evidence:
        raise InputError(f"{case.data}: its diagnosis holds no evidence; diagnose it with this version")
    begin = time.perf_counter()
    scored = weigh(case.evidence, samples, CRITERIA[name])
    return Named(tuple(scored), case.ours.seconds + time.perf_counter() - begin)
