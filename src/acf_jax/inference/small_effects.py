"""What small effects change about the force: every rig has some, of any law of the library, too small to be told.

How large each is, is not known, but what it looks like: what the law changes about the force of the rig where it is
weak. Together they are a Gaussian process of known shapes (basis functions of a linear model; Rasmussen and Williams,
'Gaussian Processes for Machine Learning', MIT Press 2006, ch. 2.7).
"""

from collections.abc import Sequence

import numpy as np

from acf_jax.inference.fit import Fit, grid_for
from acf_jax.inference.linear import is_bounded, predict_as_commanded
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import RIG, looks, starts

KEPT = 0.999  # of their variance, by principal components: many laws change the force much alike


def small_effects(observations: Observations, rig: Fit, effects: Sequence[str]) -> np.ndarray:
    """One standard deviation of each of the shapes that small effects add up to: as large as the force in all.

    **Arguments:** `rig`: a fit, about whose rig each law is taken alone. `effects`: the laws, all equally large,
    with equal parts of where their fits begin and look.

    **Returns:** (trials, k, n) N, orthogonal to one another, the largest first.
    """
    o = observations
    bare = rig.theta[: len(RIG)]

    def shapes(name: str) -> list[np.ndarray]:
        grid = grid_for(o, (name,))
        without = predict_as_commanded(o, (), bare, grid)
        begins = [
            np.array([*bare, *start]) for start in (*starts(name, o.measures), *looks(name, o.measures))
        ]
        changes = [(predict_as_commanded(o, (name,), x, grid) - without) * o.weighed for x in begins]
        sound = [c / np.sqrt((c**2).sum()) for c in changes if is_bounded(c / o.noise.std) and c.any()]
        return [c / np.sqrt(len(sound)) for c in sound]

    found = [shape for name in effects for shape in shapes(name)]
    if not found:
        return np.zeros((len(o.names), 0, o.time.shape[1]))
    rows = np.array(found).reshape(len(found), -1)
    variance, turn = np.linalg.eigh(rows @ rows.T)
    kept = 1 + int(np.searchsorted(np.cumsum(variance[::-1]), KEPT * variance.sum()))
    columns = turn[:, ::-1][:, :kept].T @ rows * np.sqrt(((o.force * o.used) ** 2).sum() / variance.sum())
    return columns.reshape(kept, *o.force.shape).swapaxes(0, 1)
