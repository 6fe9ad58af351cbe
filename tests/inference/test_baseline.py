"""What an effect promises to explain of what a fit leaves."""

import numpy as np
import pytest

from acf_jax.diagnosis.candidates import fit_nominal
from acf_jax.inference.baseline import Ground
from tests.imagined import imagined

STIFFNESS = 3e7  # N/m, of the sensor
NEAR = 1.35**2  # in mass: two of those that are looked at, 16 % of the frequency apart


@pytest.mark.parametrize("mass", [0.1, 0.4])
def test_a_ring_is_looked_for_at_its_frequency_and_begun_there(mass: float) -> None:
    """A mass on the sensor that is scaled would ring at another frequency, where the fit gets stuck."""
    o = imagined("fixture_mass", (mass, STIFFNESS, 1.5e-5))
    found = Ground.of(o, fit_nominal(o)).promise("fixture_mass")
    looked, stiffness, _ = found.parameters
    assert found.parameters.tolist() == found.start
    assert mass / NEAR < looked * STIFFNESS / stiffness < mass * NEAR


def test_a_strength_is_begun_with_what_explains_most() -> None:
    o = imagined("sensor_scale", (0.08,))
    found = Ground.of(o, fit_nominal(o)).promise("sensor_scale")
    assert found.gain > 0 and not np.allclose(found.parameters, found.start)
