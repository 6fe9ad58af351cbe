"""Learning the numbers of the posterior from scored data sets."""

import numpy as np
import pytest

from acf_jax.evidence.learnt import LEARNT
from acf_jax.evidence.marginal import Marginal
from validation.calibrate import DEGREES, HOLD, Case, _tails, freedom_elsewhere, learn

FRICTION, GRAVITY = ("coulomb_friction",), ("gravity",)


def case(left: float, stated: tuple[float, float, float]) -> Case:
    """A set whose corrected model leaves `left`, as logarithms; `stated`: middle, most and least left."""
    return Case("set", "single", [], frozenset({FRICTION}), stated, left)


@pytest.mark.parametrize("side", [0, 1])
def test_an_interval_reaches_the_truth_on_its_own_side(side: int) -> None:
    """What is stated has the tail of `LEARNT.elsewhere` alone on the side of the truth, the truth that of three."""
    tail, wanted = _tails(LEARNT.elsewhere)[side], _tails(3.0)[side]
    stated = (-1.0, -1.0, -1.0 + tail) if side == 0 else (-1.0, -1.0 + tail, -1.0)
    assert freedom_elsewhere([case(-1.0 + wanted, stated)]) == pytest.approx(3.0, rel=0.06)


def test_nothing_is_added_where_every_truth_is_in_the_middle() -> None:
    low, high = _tails(LEARNT.elsewhere)
    assert freedom_elsewhere([case(-1.0, (-1.0, -0.9 + high, -1.1 + low))] * 5) == DEGREES[0]


def test_evidence_that_is_surer_than_right_is_divided_by_more() -> None:
    """Five of six sets point to friction by 12, one as much to gravity, of which friction is the truth as well."""

    def of(behind: float) -> Case:
        evidence = [
            Marginal(FRICTION, 0.0, max(behind, 0.0), 0.0),
            Marginal(GRAVITY, 0.0, max(-behind, 0.0), 0.0),
        ]
        return Case("set", "single", evidence, frozenset({FRICTION}), None, 0.0)

    right, fallible = learn([of(-12.0)] * 6), learn([of(-12.0)] * 5 + [of(12.0)])
    assert fallible.temperature > 1.5 * right.temperature
    assert 0 < HOLD < 1 and np.all(np.array(fallible) > 0)
