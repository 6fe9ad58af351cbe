"""Gap data sets: reading them, and judging their quality before anything is fitted.

What the package offers is imported when it is first asked for: `acf_jax peak` needs its units alone.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from acf_jax.dataset.look import TrialQuality as TrialQuality
    from acf_jax.dataset.look import assess as assess
    from acf_jax.dataset.noise import Approach as Approach
    from acf_jax.dataset.noise import Noise as Noise
    from acf_jax.dataset.phase import ImpactPhase as ImpactPhase
    from acf_jax.dataset.quality import Quality as Quality
    from acf_jax.dataset.quality import assess_dataset as assess_dataset
    from acf_jax.dataset.read import data_sets as data_sets
    from acf_jax.dataset.read import read_conditions as read_conditions
    from acf_jax.dataset.read import read_dataset as read_dataset
    from acf_jax.dataset.trials import GapDataset as GapDataset
    from acf_jax.dataset.trials import LowPass as LowPass
    from acf_jax.dataset.trials import Measurement as Measurement
    from acf_jax.dataset.trials import Prior as Prior
    from acf_jax.dataset.trials import RigPrior as RigPrior
    from acf_jax.dataset.trials import RobotVelocity as RobotVelocity
    from acf_jax.dataset.trials import Trace as Trace
    from acf_jax.dataset.trials import Trial as Trial

_MODULES = {
    "TrialQuality": "look",
    "assess": "look",
    "Approach": "noise",
    "Noise": "noise",
    "ImpactPhase": "phase",
    "Quality": "quality",
    "assess_dataset": "quality",
    "data_sets": "read",
    "read_conditions": "read",
    "read_dataset": "read",
    "GapDataset": "trials",
    "LowPass": "trials",
    "Measurement": "trials",
    "Prior": "trials",
    "RigPrior": "trials",
    "RobotVelocity": "trials",
    "Trace": "trials",
    "Trial": "trials",
}


def __getattr__(name: str) -> Any:
    """What is offered, from its module."""
    if name not in _MODULES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    value = getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    globals()[name] = value
    return value
