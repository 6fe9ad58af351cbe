"""One rule for every method: the one by which `validation.blind` scores our diagnosis."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.peers_diagnosis.cases import Case, Named
from validation.blind.answer import Explanation, Said
from validation.blind.score import UNKNOWN, explained
from validation.blind.summary import counted

SURE = 0.95
LEAST = 1e-3  # probability below which a truth counts no less, as in `validation.calibrate`
DRAWS = 4000


class Outcome(NamedTuple):
    """What one answer is worth."""

    right: bool
    wrong_when_sure: bool  # it names laws of which one is wrong or missing, and leaves no doubt
    log_loss: float  # of the truth; not a number where no probability is given
    seconds: float


def judge(case: Case, named: Named) -> Outcome:
    """Score an answer. Explanations that our diagnosis computed to be one class count as one for every method."""
    said = Said.model_construct(
        explanations=tuple(Explanation(effects=e, probability=min(p, 1.0)) for e, p in named.scored),
        credible_set=(),
        indistinguishable=case.classes,
        verdict="",
    )
    found = explained(said, list(case.truth), case.neighbours, case.background)
    names_a_law = bool(found["first"]) and found["first"] != UNKNOWN
    is_sure = named.is_sure or found["probability_first"] >= SURE
    return Outcome(
        found["first_in_class"],
        names_a_law and is_sure and not found["first_in_class"],
        np.nan if named.is_sure else float(-np.log(max(found["probability_truth"], LEAST))),
        named.seconds,
    )


class Figure(NamedTuple):
    """A mean over cases with its 95 % interval."""

    value: float
    low: float
    high: float


def share(hits: Sequence[bool]) -> Figure:
    """Share of hits, by Clopper and Pearson."""
    found = counted(int(sum(hits)), len(hits))
    return Figure(found["share"], *found["ci95"])


def paired(a: Sequence[float], b: Sequence[float], seed: int = 0) -> Figure:
    """Mean of a - b over the same cases, with the percentile interval of the bootstrap over cases."""
    difference = np.asarray(a, float) - np.asarray(b, float)
    rng = np.random.default_rng(seed)
    drawn = rng.choice(difference, (DRAWS, difference.size)).mean(1)
    return Figure(float(difference.mean()), *(float(q) for q in np.quantile(drawn, [0.025, 0.975])))
