"""How large each law of an explanation is, by what it changes about the force."""

from collections.abc import Sequence

import numpy as np

from acf_jax.inference.fit import Fit
from acf_jax.inference.linear import predict_as_commanded
from acf_jax.inference.parameters import switched_off


def changes(fitted: Fit, rests: Sequence[Fit]) -> tuple[float, ...]:
    """What each law changes about the force, RMS over the compared samples, N.

    With it, against without it: all else as it is, or all else fitted again, whichever changes more. The rig makes up
    for a slow law that is large, and hardly for a fast one that is small: neither is background.

    **Arguments:** `rests`: the fits without each law. The force as it is counts from first contact: a trigger fitted
    beside a lag is late without it.
    """
    o, explanation, grid = fitted.observations, fitted.explanation, fitted.grid
    bare = predict_as_commanded(o, explanation, fitted.physical, grid)
    refitted = fitted.as_commanded()

    def change(name: str, rest: Fit) -> float:
        off = switched_off(explanation, fitted.physical, [name])
        each = bare - predict_as_commanded(o, explanation, off, grid), refitted - rest.as_commanded()
        return max(float(np.sqrt((values[o.used] ** 2).mean())) for values in each)

    return tuple(map(change, explanation, rests))
