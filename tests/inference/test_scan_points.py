"""Small oscillations are found wherever their frequency lies."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.diagnosis.candidates import fit_nominal, fit_single
from acf_jax.inference.baseline import Ground
from tests.imagined import NOISE, imagined


@pytest.mark.parametrize(
    ("effect", "parameters"),
    [
        ("sensor_resonance", (0.01, 2200.0, 0.01)),
        pytest.param("pad_mass", (0.06, 2000.0, 0.02), marks=pytest.mark.long),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_small_oscillation_between_the_starts_is_found(effect: str, parameters: tuple[float, ...]) -> None:
    quiet = imagined(effect, parameters)
    noise = NOISE * np.random.default_rng(1).standard_normal(quiet.force.shape)
    observations = replace(quiet, force=quiet.force + noise)
    ground = Ground.of(observations, fit_nominal(observations))
    found = fit_single(ground, effect)
    assert 2 * (ground.fitted.objective - found.objective) > 20.0
    assert found.theta[5] == pytest.approx(parameters[1], rel=0.1)  # its frequency
