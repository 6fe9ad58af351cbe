"""Small oscillations are found wherever their frequency lies."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.dataset import Measurement, Prior, RigPrior
from acf_jax.dataset.trials import Trial
from acf_jax.diagnosis.candidates import fit_nominal, fit_single
from acf_jax.diagnosis.forward import Grid, forward
from acf_jax.diagnosis.plan import imagine
from acf_jax.diagnosis.sample import at_times
from acf_jax.diagnosis.signature import Ground

RIG = RigPrior(Prior(2.0, 0.04), Prior(60.0, 18.0), Prior(800.0, 500.0), Prior(3.4e5, 4e4))
NOISE = 0.2  # N
FINE = Grid(2e-5, 1000)


@pytest.mark.parametrize(
    ("effect", "own", "least"),  # and by how much chi-square falls at least
    [("sensor_resonance", (0.01, 2200.0, 0.01), 20.0), ("pad_mass", (0.06, 2000.0, 0.02), 20.0)],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_small_oscillation_between_the_starts_is_found(
    effect: str, own: tuple[float, ...], least: float
) -> None:
    conditions = tuple(
        Trial(f"t{v}{f_p}", v, f_p) for v in (0.05, 0.1, 0.2, 0.3) for f_p in (40.0, 80.0, 120.0)
    )
    plain = imagine(RIG, Measurement(), conditions, 1e4, NOISE)
    forces = forward((effect,), np.array([*RIG.values, *own]), plain.v_e, plain.f_p, FINE)
    sensed = [
        at_times(f, t, FINE.h, c) for f, t, c in zip(forces.sensed, plain.time, forces.contact, strict=True)
    ]
    noise = NOISE * np.random.default_rng(1).standard_normal(plain.force.shape)
    observations = replace(plain, force=np.array(sensed) + noise)
    ground = Ground.of(observations, fit_nominal(observations))
    found = fit_single(ground, effect)
    assert 2 * (ground.fitted.objective - found.objective) > least
    frequency = found.theta[5]
    assert frequency == pytest.approx(own[1], rel=0.1)
