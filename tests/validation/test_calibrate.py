"""Learning the numbers of the posterior from scored data sets."""

import numpy as np
import pytest

from acf_jax.errors import InputError
from acf_jax.evidence.learnt import ELSEWHERE
from acf_jax.evidence.marginal import Marginal
from validation.calibrate import DEGREES, LEAST, Case, _tails, freedom_elsewhere, report

FRICTION, GRAVITY = ("coulomb_friction",), ("gravity",)


def case(left: float, stated: tuple[float, float, float]) -> Case:
    """A set whose corrected model leaves `left`, as logarithms; `stated`: middle, most and least left."""
    return Case("set", "single", [], frozenset({FRICTION}), stated, left)


@pytest.mark.parametrize("side", [0, 1])
def test_an_interval_reaches_the_truth_on_its_own_side(side: int) -> None:
    """What is stated has the tail of `ELSEWHERE` alone on the side of the truth, the truth that of three."""
    tail, wanted = _tails(ELSEWHERE)[side], _tails(3.0)[side]
    stated = (-1.0, -1.0, -1.0 + tail) if side == 0 else (-1.0, -1.0 + tail, -1.0)
    assert freedom_elsewhere([case(-1.0 + wanted, stated)]) == pytest.approx(3.0, rel=0.06)


def test_nothing_is_added_where_every_truth_is_in_the_middle() -> None:
    low, high = _tails(ELSEWHERE)
    assert freedom_elsewhere([case(-1.0, (-1.0, -0.9 + high, -1.1 + low))] * 5) == DEGREES[0]


def test_a_run_is_told_by_how_probable_the_truth_was() -> None:
    """One set of two is answered wrongly, for certain."""

    def of(behind: float) -> Case:
        evidence = [
            Marginal(FRICTION, 0.0, max(behind, 0.0), 0.0),
            Marginal(GRAVITY, 0.0, max(-behind, 0.0), 0.0),
        ]
        return Case("set", "single", evidence, frozenset({FRICTION}), None, 0.0)

    kind, by_temperature = report([of(-20.0), of(20.0)]).splitlines()
    assert kind == f"single    right 1 of 2, wrong above 90 %: 1, log loss {-np.log(LEAST) / 2:.3f}"
    # both sets are told by as much: the less that counts, the less is lost by the wrong one
    losses = [float(part.split(":")[1]) for part in by_temperature.removeprefix("log loss").split(",")]
    assert losses == sorted(losses, reverse=True) and losses[0] > losses[-1]


def test_nothing_is_learnt_where_nothing_is_stated() -> None:
    with pytest.raises(InputError, match="name more runs"):
        freedom_elsewhere([Case("set", "single", [], frozenset(), None, 0.0)])
