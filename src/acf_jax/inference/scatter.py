"""What repeats say of all that differs from trial to trial: rings, and triggers."""

from dataclasses import replace

from acf_jax.inference.observations import TRIGGER, Observations
from acf_jax.inference.rings import find_rings
from acf_jax.inference.trigger import trigger_scatter


def with_scatter(observations: Observations) -> Observations:
    """The same observations, with the rings and the scatter of the triggers that their own repeats show."""
    loose = replace(observations, trigger_std=TRIGGER, rings=())
    ringing = replace(loose, rings=find_rings(loose))
    return replace(ringing, trigger_std=trigger_scatter(ringing))
