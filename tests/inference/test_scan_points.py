"""Small oscillations are found wherever their frequency lies."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.diagnosis.candidates import fit_nominal, fit_single
from acf_jax.inference.baseline import Ground
from acf_jax.inference.parameters import RIG, parameters
from tests.imagined import NOISE, imagined


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("sensor_resonance", (0.01, 0.0, 2200.0, 2.0, 0.01, 0.02)),
        pytest.param("pad_mass", (0.06, 2000.0, 0.02), marks=pytest.mark.long),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_small_oscillation_between_the_starts_is_found(effect: str, values: tuple[float, ...]) -> None:
    quiet = imagined(effect, values)
    noise = NOISE * np.random.default_rng(1).standard_normal(quiet.force.shape)
    observations = replace(quiet, force=quiet.force + noise)
    ground = Ground.of(observations, fit_nominal(observations))
    found = fit_single(ground, effect)
    assert 2 * (ground.fitted.objective - found.objective) > 20.0
    place = [name for name, _ in parameters((effect,))].index(f"{effect}.frequency_hz")
    assert found.theta[place] == pytest.approx(values[place - len(RIG)], rel=0.1)


@pytest.mark.parametrize("ratio", [1.45, 2.7])
def test_a_second_mode_of_the_mounting_is_found_wherever_it_lies(ratio: float) -> None:
    values = (0.7, 0.15, 500.0, ratio, 0.03, 0.02)
    quiet = imagined("sensor_resonance", values)
    noise = NOISE * np.random.default_rng(1).standard_normal(quiet.force.shape)
    observations = replace(quiet, force=quiet.force + noise)
    found = fit_single(Ground.of(observations, fit_nominal(observations)), "sensor_resonance")
    assert found.physical[len(RIG) :] == pytest.approx(values, rel=0.03)
    assert 2 * found.objective < 1.2 * observations.n_used
