import numpy as np
import pytest

from validation.blind.calibration import calibrate


def test_calibrated_probabilities_stay_within_chance():
    rng = np.random.default_rng(3)
    stated = rng.uniform(0.2, 1.0, 600)
    c = calibrate(stated, rng.random(600) < stated)
    assert c.error < c.by_chance
    assert c.expected_by_chance < c.by_chance
    assert c.cases.sum() == 600


def test_overconfidence_shows_by_its_size():
    rng = np.random.default_rng(4)
    stated = np.full(2000, 0.9)
    c = calibrate(stated, rng.random(2000) < 0.7)
    assert c.error == pytest.approx(0.2, abs=0.03)
    assert c.by_chance < 0.03
