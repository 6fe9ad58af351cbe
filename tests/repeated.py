"""Repeats whose scatter is known."""

import numpy as np

from acf_jax.dataset import Noise, Prior, RigPrior
from acf_jax.inference.observations import Observations

RIG = RigPrior(Prior(2.0, 0.04), Prior(60.0, 18.0), Prior(800.0, 500.0), Prior(3.4e5, 4e4))
INTERVAL, SPREAD, NOISE = 2e-4, 0.005, 1.0  # s, relative, N


def repeated(scatter: float, conditions: int = 8, repeats: int = 3) -> Observations:
    """Half sines on a pretension, as no model has them; triggers scatter by `scatter` sampling intervals."""
    random = np.random.default_rng(5)
    trials = conditions * repeats
    condition = np.repeat(np.arange(conditions), repeats)
    v_e, f_p = 0.05 + 0.04 * condition, np.full(trials, 80.0)
    time = INTERVAL * np.arange(1, 40)
    at = time + INTERVAL * scatter * random.standard_normal((trials, 1))
    v, f = ((1 + SPREAD * random.standard_normal(trials)) * a for a in (v_e, f_p))
    force = f[:, None] + 800 * v[:, None] * np.sin(at * np.pi / 8e-3)
    return Observations(
        names=tuple(f"t{i}" for i in range(trials)),
        v_e=v_e,
        f_p=f_p,
        condition=condition,
        time=np.tile(time, (trials, 1)),
        force=force + NOISE * random.standard_normal(force.shape),
        used=np.ones(force.shape, bool),
        peak_only=np.zeros(trials, bool),
        interval=np.full(trials, INTERVAL),
        rel_std=(SPREAD, SPREAD),
        noise=Noise(NOISE),
        prior=RIG,
    )
