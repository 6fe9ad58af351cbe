"""What of a diagnosis is written."""

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from acf_jax.diagnosis.document import _explanations
from acf_jax.diagnosis.results import variant
from acf_jax.evidence.posterior import UNKNOWN, Scored
from acf_jax.inference.fit import Fit
from acf_jax.inference.parameters import every_effect


@pytest.mark.parametrize(("effect", "delay"), [("sensor_lag", 2e-5), ("sensor_scale", 0.0), ("gravity", 0.0)])
def test_a_delay_of_all_triggers_belongs_to_a_lagging_sensor_alone(effect: str, delay: float) -> None:
    theta = np.array([2.0, 60.0, 800.0, 3e5, *(p.scale for p in every_effect()[effect].parameters())])
    common = np.array([0.1, 2e-5])
    fitted = SimpleNamespace(
        explanation=(effect,), physical=theta, common=common, covariance=np.eye(len(theta) + len(common))
    )
    written = variant(cast(Fit, fitted), 0.5)
    assert written.delay_s == delay
    assert written.theta == tuple(theta)


def test_the_listed_probabilities_add_up_once_the_small_ones_are_left_out() -> None:
    small = [Scored((name,), 8e-5) for name in list(every_effect())[1:13]]
    scored = [Scored((next(iter(every_effect())),), 0.99), Scored((), 0.0), Scored(UNKNOWN, 0.0), *small]
    listed = _explanations(SimpleNamespace(scored=scored))  # type: ignore[arg-type]
    p = [row["probability"] for row in listed]
    assert len(p) == 3 and sum(p) == pytest.approx(1.0)
    assert max(p) == pytest.approx(1.0) and p[1:] == [0.0, 0.0]
