import numpy as np
import pytest

from validation.blind.ceiling import decide, weigh


@pytest.mark.parametrize(("size", "low", "high"), [(0.1, 0.0, 0.05), (12.0, 0.97, 1.0)])
def test_a_signal_of_its_own_is_named_as_far_as_it_can_be_seen(size, low, high):
    gram = np.eye(4)
    assert low <= decide(gram, ["a", "b", "c", "d"], size, np.random.default_rng(0)) <= high


def test_an_effect_of_the_same_signal_counts_as_found():
    same = np.array([[1.0, 1.0], [1.0, 1.0]])
    apart = np.eye(2)
    rng = np.random.default_rng(0)
    assert decide(same, ["a", "b"], 6.0, rng) == pytest.approx(decide(apart, ["a", "b"], 6.0, rng), abs=0.05)


def test_caution_raises_fewer_false_alarms_and_names_less():
    gram, labels = np.eye(4), ["a", "b", "c", "d"]
    odds_of_none, _ = weigh(gram, labels, 0.0, np.random.default_rng(0))
    odds, right = weigh(gram, labels, 3.0, np.random.default_rng(0))
    raised = [(odds_of_none > price).mean() for price in (1.0, 20.0)]
    named = [(right & (odds > price)).mean() for price in (1.0, 20.0)]
    assert raised[1] < 0.3 * raised[0] < 0.1
    assert named[1] < named[0]
