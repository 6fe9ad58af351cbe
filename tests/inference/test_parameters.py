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
        steps = 1e-6 * np.eye(len(u))
        slopes = (space.value(u + steps) - space.value(u - steps)).T / 2e-6
        np.testing.assert_allclose(space.jacobian(u), slopes, rtol=1e-6, atol=1e-9 * np.abs(slopes).max())


def test_a_strength_within_another_is_a_share_of_it() -> None:
    """Its own coordinate has no kink where both are the same, and is told of nothing, too."""
    space = coordinates(RIG, ("end_stop",), (0.1, 1e-4))
    held, opposing = 4, 5
    all_of_it = space.coordinate(begin(RIG.values, [0.3, 0.3]))
    assert all_of_it[opposing] == space.high[opposing]
    half = np.array(all_of_it)
    half[opposing] = space.low[opposing] / 2
    assert space.value(half)[[held, opposing]] == pytest.approx([0.3, 0.15])
    nothing = space.coordinate(begin(RIG.values, [0.0, 0.0]))
    assert space.low[opposing] <= nothing[opposing] <= space.high[opposing]
    assert space.value(nothing)[opposing] == 0


def test_a_strength_that_acts_per_shape_is_known_by_the_quotient() -> None:
    """Along the shape alone nothing changes: of a mass on a sensor the period is told, and no more."""
    space = coordinates(RIG, ("fixture_mass",), (0.1, 1e-4))
    mass, stiffness = 4, 5
    u = space.coordinate(begin(RIG.values, [0.02, 2e7, 1e-5]))
    stiffer = u.copy()
    stiffer[stiffness] += 0.3
    (m, k), (m_stiffer, k_stiffer) = (space.value(x)[[mass, stiffness]] for x in (u, stiffer))
    assert k_stiffer > 1.1 * k and m_stiffer / k_stiffer == pytest.approx(m / k)


def test_some_starts_are_multiples_of_what_is_typical_of_rig_and_trials() -> None:
    usual, larger = starts("unknown_sensor"), starts("unknown_sensor", Measures(force=600.0))
    level = [p.name for p in every_effect()["unknown_sensor"].parameters()].index("level_n")
    assert [start[level] for start in larger] == pytest.approx([3 * start[level] for start in usual])
    assert [start[:level] for start in larger] == [start[:level] for start in usual]
    highest = every_effect()["unknown_sensor"].parameters()[level].high
    assert max(start[level] for start in starts("unknown_sensor", Measures(force=1e9))) == highest
