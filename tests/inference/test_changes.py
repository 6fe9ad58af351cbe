"""What each law changes about the force."""

import numpy as np
import pytest

from acf_jax.inference.changes import changes
from tests.imagined import RIG, imagined


def test_a_gain_error_changes_its_share_of_the_force() -> None:
    o = imagined(("gravity", "sensor_scale"), (12.0, 0.04))
    gravity, gain = changes(o, ("gravity", "sensor_scale"), np.array([*RIG.values, 12.0, 0.04]))
    rms = float(np.sqrt((o.force[o.used] ** 2).mean()))
    assert gain == pytest.approx(0.04 / 1.04 * rms, rel=1e-3)
    assert 1.0 < gravity < 12.0


def test_a_lag_changes_what_it_does_from_first_contact_on() -> None:
    """Not what its triggers, fitted late, would make of the step of the force without it."""
    o = imagined(("sensor_lag",), (2e-5, 0.8))
    (lag,) = changes(o, ("sensor_lag",), np.array([*RIG.values, 2e-5, 0.8]))
    slope = float(np.abs(np.gradient(o.force, axis=1)[o.used]).max() / o.interval[0])
    assert 0 < lag < 2 * 0.8 * 2e-5 * slope
