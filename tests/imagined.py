"""Noise-free trials of one rig with effects, without a data set."""

from dataclasses import replace

import numpy as np

from acf_jax.dataset import Measurement, Prior, RigPrior
from acf_jax.dataset.trials import Trial
from acf_jax.diagnosis.plan import imagine
from acf_jax.inference.forward import Grid, forward
from acf_jax.inference.interpolation import at_times
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import Explanation

RIG = RigPrior(Prior(2.0, 0.04), Prior(60.0, 18.0), Prior(800.0, 500.0), Prior(3.4e5, 4e4))
RATE, NOISE = 1e4, 0.2  # Hz, N
CONDITIONS = tuple(Trial(f"t{v}{f_p}", v, f_p) for v in (0.05, 0.1, 0.2, 0.3) for f_p in (40.0, 80.0, 120.0))
FINE = Grid(2e-5, 1000)


def imagined(effects: str | Explanation, values: tuple[float, ...]) -> Observations:
    """Trials whose forces are those of an effect, or of several, with these parameters."""
    explanation = (effects,) if isinstance(effects, str) else effects
    plain = imagine(RIG, Measurement(), CONDITIONS, RATE, NOISE)
    forces = forward(explanation, np.array([*RIG.values, *values]), plain.v_e, plain.f_p, FINE)
    sensed = [
        at_times(f, t, FINE.h, c) for f, t, c in zip(forces.sensed, plain.time, forces.contact, strict=True)
    ]
    return replace(plain, force=np.array(sensed))
