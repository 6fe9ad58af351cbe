"""Coordinates and starts of the parameters."""

import numpy as np
import pytest

from acf_jax.inference.parameters import Measures, begin, coordinates, every_effect, starts
from tests.imagined import RIG


@pytest.mark.parametrize("name", sorted(every_effect()))
def test_coordinates_invert_and_starts_lie_within_the_bounds(name: str) -> None:
    space = coordinates(RIG, (name,), (0.1, 1e-4))
    for start in starts(name):
        theta = begin(RIG.values, start)
        u = space.coordinate(theta)
        np.testing.assert_allclose(space.value(u), theta, rtol=1e-12, atol=1e-15)
        assert (u >= space.low).all() and (u <= space.high).all()
        step = 1e-6
        slope = (space.value(u + step) - space.value(u - step)) / (2 * step)
        np.testing.assert_allclose(space.slope(u), slope, rtol=1e-6)


def test_some_starts_are_multiples_of_what_is_typical_of_rig_and_trials() -> None:
    usual, larger = starts("unknown_sensor"), starts("unknown_sensor", Measures(force=600.0))
    level = [p.name for p in every_effect()["unknown_sensor"].parameters()].index("level_n")
    assert [start[level] for start in larger] == pytest.approx([3 * start[level] for start in usual])
    assert [start[:level] for start in larger] == [start[:level] for start in usual]
    highest = every_effect()["unknown_sensor"].parameters()[level].high
    assert max(start[level] for start in starts("unknown_sensor", Measures(force=1e9))) == highest
