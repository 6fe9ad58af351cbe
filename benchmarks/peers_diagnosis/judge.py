"""One rule for every method: the one by which `validation.blind` scores our diagnosis."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.measured.answers import is_right
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
    """Score an answer. Explanations that our diagnosis computed to be one class count as one for every method.

    Of a measured set right is what holds the known cause, and nothing of a component that the rig does not have.
    """
    first, probability = named.scored[0]
    if case.known:
        right = is_right(case.known, first)
        of_truth = sum(p for e, p in named.scored if is_right(case.known, e))
        return _outcome(first, probability, right, of_truth, named)
    said = Said.model_construct(
        explanations=tuple(Explanation(effects=e, probability=min(p, 1.0)) for e, p in named.scored),
        credible_set=(),
        indistinguishable=case.classes,
        verdict="",
    )
    found = explained(said, list(case.truth), case.neighbours, case.background)
    return _outcome(
        found["first"], found["probability_first"], found["first_in_class"], found["probability_truth"], named
    )


def _outcome(first: Sequence[str], probability: float, right: bool, of_truth: float, named: Named) -> Outcome:
    names_a_law = bool(first) and list(first) != UNKNOWN
    is_sure = named.is_sure or probability >= SURE
    return Outcome(
        right,
        names_a_law and is_sure and not right,
        np.nan if named.is_sure else float(-np.log(max(of_truth, LEAST))),
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
