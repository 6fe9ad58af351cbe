"""Forces between the points of the grid, and their peak."""

import numpy as np
import pytest

from acf_jax.inference.fit import BEYOND
from acf_jax.inference.interpolation import at_times, first_loss, peak_of, taps


def test_interpolation_is_exact_for_cubics() -> None:
    h = 0.1
    grid = h * np.arange(30)
    times = np.array([0.0, 0.033, 0.5, 1.234, 2.7])
    cubic = np.polynomial.Polynomial([1.0, -2.0, 0.5, 0.3])
    held = np.ones(len(grid))
    np.testing.assert_allclose(at_times(cubic(grid), times, h, held), cubic(times), rtol=1e-12)
    found = taps(times, h, held)
    np.testing.assert_allclose(
        (cubic(grid)[found.near] * found.rate_weight(h)).sum(0), cubic.deriv()(times), rtol=1e-10, atol=1e-10
    )


@pytest.mark.parametrize("lost", [0.1, 0.1003, 0.1011, 0.1019])  # s, between points of the grid or on one
def test_interpolation_ends_where_contact_is_lost(lost: float) -> None:
    h = 2e-3
    grid, times = h * np.arange(60), np.linspace(0.08, 0.115, 200)

    def force(t: np.ndarray) -> np.ndarray:
        return np.maximum(100 * np.sin(t * np.pi / lost), 0.0) * (t < lost)

    found = at_times(force(grid), times, h, force(grid))
    np.testing.assert_allclose(found, force(times), atol=1e-3)
    reading = at_times(force(grid) + 5.0, times, h, force(grid))  # of a sensor with an offset
    np.testing.assert_allclose(reading, force(times) + 5.0, atol=1e-3)


@pytest.mark.parametrize("steps", [0.05, 0.5, 1.0, 1.9])  # of the grid, from the last sample to the loss
def test_a_loss_of_contact_right_behind_the_last_sample_is_told(steps: float) -> None:
    h, end = 2e-3, 0.0813
    lost = end + steps * h
    grid, times = h * np.arange(int(np.ceil(end / h)) + BEYOND + 1), np.linspace(0.06, end, 50)

    def force(t: np.ndarray) -> np.ndarray:
        return np.maximum(100 * np.sin(t * np.pi / lost), 0.0) * (t < lost)

    np.testing.assert_allclose(at_times(force(grid), times, h, force(grid)), force(times), atol=1e-3)


def test_the_peak_lies_within_the_impact_phase() -> None:
    time = np.arange(200) * 1e-3
    force = 100 * np.sin(time * np.pi / 0.1)  # contact is lost after 0.1 s
    force[150:] = 500.0
    peak, when = peak_of(force, 1e-3, force)
    assert peak == pytest.approx(100.0, rel=1e-6)
    assert when == pytest.approx(0.05, abs=1e-6)


def test_contact_is_lost_only_after_there_was_some() -> None:
    contact = np.array(
        [[0.0, 0.0, 3.0, 5.0, 0.0, 0.0], [2.0, 3.0, 4.0, 3.0, 2.0, 1.0], [1.0, 0.0, 1.0, 2.0, 1.0, 0.0]]
    )
    np.testing.assert_array_equal(first_loss(contact), [4, 6, 1])
    assert first_loss(np.zeros(6)) == 6
