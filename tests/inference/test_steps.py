"""What the steps of the simulation resolve."""

from dataclasses import replace

import jax
import numpy as np
import pytest

from acf_jax.dataset import Measurement, Prior, RigPrior
from acf_jax.diagnosis.plan import imagine
from acf_jax.inference.fit import fit
from acf_jax.inference.forward import Grid, forward
from acf_jax.inference.interpolation import at_times
from acf_jax.inference.parameters import begin
from acf_jax.model import Impact, Rig, contact_force
from tests.imagined import CONDITIONS, NOISE, RATE, RIG

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
    found = fit(observations, ("sensor_lag",), begin(RIG.values, [1e-4, 0.8]))
    assert 2 * found.objective < 1.1 * observations.n_used
    assert abs(found.theta[4] / TAU - 1) < 0.5


@pytest.mark.parametrize(
    "zeta", [0.0, *(pytest.param(zeta, marks=pytest.mark.long) for zeta in (3.0, 15.0)), 40.0]
)
def test_a_damper_of_any_strength_is_resolved(zeta: float) -> None:
    """From a damping ratio of 14 on the simulation was unstable, and `plan` ended in a traceback."""
    m, k_c = 0.5, 1e5
    rig = RigPrior(Prior(m, 0.01), Prior(2 * zeta * np.sqrt(m * k_c), 1.0), Prior(0.0, 1.0), Prior(k_c, 1e3))
    found = imagine(rig, Measurement(), CONDITIONS[:2], RATE, NOISE)
    exact = jax.vmap(contact_force, (None, None, 0))
    for i, (v_e, f_p) in enumerate(zip(found.v_e, found.f_p, strict=True)):
        used = found.used[i]
        expected = exact(Rig(*rig.values), Impact(v_e, f_p), found.time[i, used])
        assert found.force[i, used] == pytest.approx(np.maximum(expected, 0.0), rel=2e-3)
