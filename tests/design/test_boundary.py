"""The last allowed point of a line."""

import numpy as np
import pytest

from acf_jax.designs.boundary import first_failure


@pytest.mark.parametrize("edge", [1e-12, 0.1, np.pi / 7, 1 - 1e-12])
def test_crossing_is_found_to_the_last_digit(edge: float) -> None:
    found = first_failure(lambda x: x <= edge)
    assert found is not None
    assert found.last_held <= edge < found.first_failed
    assert found.first_failed - found.last_held <= 4 * np.spacing(edge)


def test_ends() -> None:
    assert first_failure(lambda x: x < 0) is None
    found = first_failure(lambda x: x <= 1)
    assert found is not None and found.last_held == 1 and found.first_failed == np.inf


def test_first_of_several_crossings() -> None:
    found = first_failure(lambda x: (x < 0.3) | (x > 0.6))
    assert found is not None and found.last_held == pytest.approx(0.3)
