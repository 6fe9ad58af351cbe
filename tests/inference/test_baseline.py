"""What an effect promises to explain of what a fit leaves."""

import numpy as np
import pytest

from acf_jax.diagnosis.candidates import fit_nominal, fit_single, promised
from acf_jax.inference.baseline import Ground
from tests.imagined import imagined


@pytest.mark.parametrize("mass", [0.1, 0.4])
def test_a_ring_is_begun_at_frequencies_that_were_looked_at_and_found(mass: float) -> None:
    """A mass on the sensor that is scaled would ring at another frequency, where the fit gets stuck."""
    o = imagined("fixture_mass", (mass, 3e7, 1.5e-5))
    ground = Ground.of(o, fit_nominal(o))
    assert all(p.parameters.tolist() == p.start for p in promised(ground, "fixture_mass"))
    found = fit_single(ground, "fixture_mass")
    assert found.physical[4] / found.physical[5] == pytest.approx(mass / 3e7, rel=0.01)


def test_a_strength_is_begun_with_what_explains_most() -> None:
    o = imagined("sensor_scale", (0.08,))
    found = Ground.of(o, fit_nominal(o)).promise("sensor_scale")
    assert found.gain > 0 and not np.allclose(found.parameters, found.start)
