"""By when the robot has to stop, so that a design's force holds its limit."""

from types import SimpleNamespace

import numpy as np
import pytest

from acf_jax.designs import stop

LIMIT, FACTOR, LATE = 140.0, 1.5, 0.05


@pytest.mark.parametrize(("beyond", "latest"), [(0.1, LATE), (0.5, None)])
def test_what_two_simulations_differ_by_does_not_stop_the_robot(monkeypatch, beyond, latest):
    """A design touches its limit; the simulation until a stop has another spread, and a higher force from 50 ms on."""
    std = 0.4
    task = SimpleNamespace(model=SimpleNamespace(main=SimpleNamespace(peak=None)), limit=LIMIT)

    def upper_until(model, z, ending, factor):
        return LIMIT + factor * std * beyond + (10.0 if ending.stop_after > LATE else 0.0), True

    monkeypatch.setattr(stop, "_upper_until", upper_until)
    found = stop.needed_stop(task, np.array([1.0, 0.2, 60.0]), FACTOR)
    assert (found and found.time) == (latest and pytest.approx(latest, rel=1e-3))
