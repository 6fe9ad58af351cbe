"""How much each law of an explanation changes about the force."""

import numpy as np

from acf_jax.inference.fit import grid_for
from acf_jax.inference.linear import predict_as_commanded
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import Explanation, switched_off


def changes(
    observations: Observations,
    explanation: Explanation,
    physical: np.ndarray,
    program: Explanation | None = None,
) -> tuple[float, ...]:
    """What each law changes about the force, RMS over the compared samples, N: with it, against without it.

    **Arguments:** `physical`: (p,) the parameters of rig and laws, SI units. The rig and all other laws stay as they
    are. All is at the commanded conditions, from first contact: a trigger fitted beside a lag is late without it.
    `program`: of `Grid`.
    """
    o, grid = observations, grid_for(observations, explanation, program)

    def force(parameters: np.ndarray) -> np.ndarray:
        return predict_as_commanded(o, explanation, parameters, grid)[o.used]

    together = force(physical)
    alone = (together - force(switched_off(explanation, physical, [name])) for name in explanation)
    return tuple(float(np.sqrt((change**2).mean())) for change in alone)
