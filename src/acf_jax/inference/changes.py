"""How much each law of an explanation changes about the force."""

import numpy as np

from acf_jax.inference.fit import grid_for
from acf_jax.inference.linear import predict
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import RIG, Explanation, classes


def changes(observations: Observations, explanation: Explanation, physical: np.ndarray) -> tuple[float, ...]:
    """What each law changes about the force, RMS over the compared samples, N: with it, against without it.

    **Arguments:** `physical`: (p,) the parameters of rig and laws, SI units. The rig and all other laws stay as they
    are. All is at the commanded conditions, from first contact: a trigger fitted beside a lag is late without it.
    """
    o, grid = observations, grid_for(observations, explanation)
    counts = [len(cls.parameters()) for cls in classes(explanation)]
    quiet = np.zeros((len(o.names), o.n_nuisances))
    nothing = np.zeros(o.n_common + o.n_shared)

    def force(laws: Explanation, parameters: np.ndarray) -> np.ndarray:
        return predict(o, laws, np.concatenate([parameters, nothing]), quiet, grid)[o.used]

    together = force(explanation, physical)
    found, at = [], len(RIG)
    for k, count in enumerate(counts):
        rest = explanation[:k] + explanation[k + 1 :]
        without = force(rest, np.delete(physical, np.s_[at : at + count]))
        found.append(float(np.sqrt(((together - without) ** 2).mean())))
        at += count
    return tuple(found)
