"""Peak contact force of an active contact flange (ACF): model, surrogate and gap diagnosis.

`import acf_jax as acf` is quick, and brings what `acf_jax.api` offers when it is first asked for (docs/python.md).
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from acf_jax.api.contact import check as check
    from acf_jax.api.dataset import read_dataset as read_dataset
    from acf_jax.api.design import design as design
    from acf_jax.api.diagnosis import diagnose as diagnose
    from acf_jax.api.model import load_surrogate as load_surrogate
    from acf_jax.api.model import read_model as read_model
    from acf_jax.api.model import train as train
    from acf_jax.api.recording import read_recording as read_recording
    from acf_jax.api.rig import Impact as Impact
    from acf_jax.api.rig import Prior as Prior
    from acf_jax.api.rig import Rig as Rig
    from acf_jax.api.rig import find_peak as find_peak
    from acf_jax.api.rig import find_peaks as find_peaks
    from acf_jax.api.speed import speed as speed
    from acf_jax.api.training import export_c as export_c

__version__ = "0.2.0"

_MODULES = {
    "Rig": "rig",
    "Impact": "rig",
    "Prior": "rig",
    "find_peak": "rig",
    "find_peaks": "rig",
    "read_recording": "recording",
    "read_dataset": "dataset",
    "diagnose": "diagnosis",
    "read_model": "model",
    "speed": "speed",
    "design": "design",
    "check": "contact",
    "train": "model",
    "load_surrogate": "model",
    "export_c": "training",
}  # of acf_jax.api


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = globals()[name] = getattr(import_module(f"acf_jax.api.{_MODULES[name]}"), name)
    return found


def __dir__() -> list[str]:
    return sorted({*_MODULES, *(name for name in globals() if name.startswith("__"))})
