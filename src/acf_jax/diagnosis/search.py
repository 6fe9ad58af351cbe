"""Which explanations are fitted: every single effect and port, then pairs by forward search."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from acf_jax.diagnosis import candidates
from acf_jax.diagnosis.fit import Fit
from acf_jax.diagnosis.observe import Observations
from acf_jax.diagnosis.score import is_port
from acf_jax.diagnosis.space import Explanation

LEADERS = 3  # single effects from which the forward search goes on
UNEXPLAINED = 1.5  # chi-square of a sample above which twice as many effects lead
PARTNERS = 3  # effects that are tried beside each of them
WORTH_A_SECOND = 9.0  # chi-square that a partner has to promise before the pair is fitted
OUTLIER = 5.0  # a trial is left out where its misfit is this many times that of the others, and beyond chance

Progress = Callable[[str], None]


def fit_all(observations: Observations, effects: Sequence[str], progress: Progress) -> tuple[Fit, list[Fit]]:
    """The recalibrated model, every single effect and port, and the pairs that forward search finds."""
    progress("recalibrating the paper's model")
    recalibrated = candidates.fit_nominal(observations)
    progress("fitting every effect")
    tasks = [
        partial(candidates.fit_single, observations, recalibrated, name)
        for (name,) in candidates.singles(effects)
    ]
    fits = candidates.in_parallel(tasks)
    progress("searching for pairs")
    alone = [f for f in fits if not is_port(f.explanation) and np.isfinite(f.objective)]
    alone.sort(key=lambda f: f.objective)
    explained = 2 * alone[0].objective < UNEXPLAINED * observations.n_used
    wanted: dict[Explanation, tuple[Fit, str]] = {}
    for leader in alone[: LEADERS if explained else 2 * LEADERS]:
        for name, gain in candidates.partners(observations, leader, effects)[:PARTNERS]:
            if gain > WORTH_A_SECOND:
                wanted.setdefault(tuple(sorted((*leader.explanation, name))), (leader, name))
    fits += candidates.in_parallel(
        [partial(candidates.fit_more, observations, f, name) for f, name in wanted.values()]
    )
    # a simulation that broke down at every start explains nothing
    return recalibrated, [f for f in fits if np.isfinite(f.objective)]


def outliers(observations: Observations, fitted: Fit) -> dict[str, str]:
    """Trials that even the best explanation does not fit while it fits the others."""
    samples = np.maximum(observations.used.sum(1), 1)
    ratio = fitted.chi2 / samples
    if len(ratio) < 5:
        return {}
    usual = float(np.median(ratio))
    beyond = fitted.chi2 - usual * samples > 40 + 8 * usual * np.sqrt(2 * samples)
    chosen = np.flatnonzero(beyond & (ratio > OUTLIER * usual))
    if len(chosen) > max(1, len(ratio) // 10):
        return {}
    # what every trial of a condition shows is physics, not a fault; a single one is given no such benefit
    condition = observations.condition
    groups = [np.flatnonzero(condition == condition[i]) for i in chosen]
    chosen = np.array(
        [i for i, g in zip(chosen, groups, strict=True) if len(g) == 1 or not np.isin(g, chosen).all()], int
    )
    return {
        observations.names[
            i
        ]: f"its misfit to the best explanation is {ratio[i] / usual:.0f} times that of the others"
        for i in chosen
    }
