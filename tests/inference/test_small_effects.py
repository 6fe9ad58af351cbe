"""What small effects add up to."""

import numpy as np
import pytest

from acf_jax.inference.discrepancy import FORMS, discrepancy
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import begin
from acf_jax.inference.small_effects import small_effects
from tests.imagined import RIG, imagined

LAWS = ["gravity", "sensor_lag", "sensor_scale"]


@pytest.fixture(scope="module")
def plain() -> Observations:
    return imagined((), ())


@pytest.fixture(scope="module")
def rig(plain: Observations) -> Fit:
    return fit(plain, (), begin(RIG.values), warm=True, iterations=0)


@pytest.fixture(scope="module")
def small(plain: Observations, rig: Fit) -> np.ndarray:
    return small_effects(plain, rig, LAWS)


def test_they_are_together_as_large_as_the_force_and_orthogonal(
    plain: Observations, small: np.ndarray
) -> None:
    rows = small.swapaxes(0, 1).reshape(small.shape[1], -1)
    assert (rows**2).sum() == pytest.approx((plain.force[plain.used] ** 2).sum(), rel=2e-3)
    inner = rows @ rows.T
    np.testing.assert_allclose(inner, np.diag(np.diag(inner)), atol=1e-9 * inner.max())
    assert (np.diff(np.diag(inner)) <= 0).all() and not (small * ~plain.used[:, None]).any()


@pytest.mark.parametrize(
    "effects, values, share", [("gravity", (0.3,), 0.2), ("sensor_scale", (0.01,), 1e-2)]
)
def test_what_a_weak_law_changes_is_a_sum_of_their_shapes(
    plain: Observations, small: np.ndarray, effects: str, values: tuple[float, ...], share: float
) -> None:
    """That of a strong one ends at another time, with the contact."""
    change = ((imagined(effects, values).force - plain.force) * plain.used).ravel()
    rows = small.swapaxes(0, 1).reshape(small.shape[1], -1)
    left = change - rows.T @ np.linalg.lstsq(rows.T, change)[0]
    assert np.sqrt((left**2).sum()) < share * np.sqrt((change**2).sum())


def test_an_effect_without_influence_has_no_shape(plain: Observations, rig: Fit) -> None:
    assert small_effects(plain, rig, []).shape == (len(plain.names), 0, plain.time.shape[1])


def test_small_effects_stay_small_where_a_cause_is_missing(plain: Observations, small: np.ndarray) -> None:
    """They are shared by all trials, behind the waves."""
    forms, wide = (discrepancy(plain, size, small) for size in (FORMS, 0.3))
    count = discrepancy(plain, FORMS).shared.shape[1]
    np.testing.assert_allclose(forms.shared[:, count:], FORMS * small)
    np.testing.assert_allclose(wide.shared[:, count:], FORMS * small)
