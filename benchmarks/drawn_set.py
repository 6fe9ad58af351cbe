"""Gap data sets of any size, drawn and held in memory: one rig, the same conditions, more repeats."""

from pathlib import Path

import numpy as np

from acf_jax.dataset import GapDataset, Measurement, Prior, RigPrior, Trace, Trial
from validation.worlds import Impact, find_world, make_case

SEED = 13  # draws ten conditions, so that 20 trials are two of each
DISTANCE = 40.0  # whitened distance of the hidden cause: clear, as in docs/blind.md


def draw_set(trials: int, cause: str = "coulomb_friction", seed: int = SEED) -> GapDataset:
    """Impacts of a rig with one hidden cause, from the world that SciPy integrates; equal arguments, equal sets.

    **Arguments:** `trials`: how many, shared evenly by the conditions of the drawn campaign. `cause`: what the paper's
    model leaves out. `seed`: of the rig, the campaign and everything random.

    **Returns:** the data set as a user's would be, without faulty trials.
    """
    case = make_case(seed, [cause], target=DISTANCE, coloured=False)
    setup, world, causes = case.setup, find_world(case.world), list(case.causes.values())
    rng = np.random.default_rng(seed)
    recorded = []
    for i in range(trials):
        label = setup.conditions[i % len(setup.conditions)]
        scatter = 1.0 + setup.spread * rng.standard_normal(2)
        late = setup.late(rng)
        impact = Impact(label.v_e * scatter[0], label.f_p * scatter[1])
        sensed = world.respond(setup.rig, causes, impact, setup.time + late, setup.after_loss).sensed
        force = np.asarray(sensed + setup.noise.draw(rng, sensed.size), np.float64)
        time = np.asarray(setup.time[: force.size], np.float64)
        trace = Trace(time, np.round(force / setup.quantum) * setup.quantum)
        recorded.append(Trial(f"t{i:04d}", label.v_e, label.f_p, trace=trace))
    return GapDataset(
        folder=Path(f"drawn set of {trials} trials"),
        description=f"{trials} drawn impacts of one rig",
        rig=RigPrior(*(Prior(value, std) for value, std in setup.prior)),
        measurement=Measurement(setup.noise.std, setup.spread, setup.spread),
        trials=tuple(recorded),
    )
