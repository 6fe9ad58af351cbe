"""What the steps of the simulation resolve."""

from dataclasses import replace

import numpy as np

from acf_jax.dataset import Measurement
from acf_jax.diagnosis.fit import fit
from acf_jax.diagnosis.forward import Grid, forward
from acf_jax.diagnosis.plan import imagine
from acf_jax.diagnosis.sample import at_times
from tests.diagnosis.imagined import CONDITIONS, NOISE, RATE, RIG

TAU, ZETA = 3e-5, 0.8  # s, a third of a sampling interval
FINE = Grid(1e-5, 1000)


def test_a_short_lag_is_fitted_where_contact_begins_between_samples() -> None:
    """With a step of one sampling interval such trials left 13 of chi-square a sample."""
    plain = imagine(RIG, Measurement(), CONDITIONS, RATE, NOISE)
    rig = np.array([*RIG.values, TAU, ZETA])
    forces = forward(("sensor_lag",), rig, plain.v_e, plain.f_p, FINE)
    late = np.linspace(-0.5, 0.9, len(plain.names)) / RATE
    random = np.random.default_rng(0)
    readings = [
        at_times(f, t - delay, FINE.h, c) + NOISE * random.standard_normal(len(t))
        for f, t, c, delay in zip(forces.sensed, plain.time, forces.contact, late, strict=True)
    ]
    observations = replace(plain, force=np.array(readings))
    found = fit(observations, ("sensor_lag",), np.array([*RIG.values, 1e-4, 0.8, 0.0]))
    assert 2 * found.objective < 1.1 * observations.n_used
    assert abs(found.theta[4] / TAU - 1) < 0.5
