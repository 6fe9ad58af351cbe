"""What is known of the rig beforehand: `rig` and `measurement` of a dataset.yaml, from a file of their own."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from acf_jax.dataset.description import check_rig
from acf_jax.dataset.rig_file import KEYS, REMEDY, as_prior
from acf_jax.dataset.trials import RigPrior
from acf_jax.errors import InputError
from acf_jax.files import read_yaml_mapping

MEASURED = ("contact_velocity_rel_std", "pretension_rel_std")  # of `measurement`, by an import
BY_IMPORT = "impacts cut from "  # begins a description that an import wrote
TEMPLATE = """\
rig:  # fill in: what is known of the rig, each value with its standard deviation
  moving_mass_kg:             {value: , std: }
  damping_n_s_per_m:          {value: , std: }
  actuator_stiffness_n_per_m: {value: , std: }
  contact_stiffness_n_per_m:  {value: , std: }
"""


@dataclass(frozen=True)
class RigFile:
    """A rig's description: its parts as written, and the prior that they state."""

    prior: RigPrior
    rig: dict[str, Any]
    measurement: dict[str, Any]
    description: str = ""


def stated(prior: RigPrior) -> RigFile:
    """The description of a rig of which a program knows the prior."""
    known = (prior.m, prior.d, prior.k_f, prior.k_c)
    rig = {key: {"value": p.value, "std": p.std} for key, p in zip(KEYS.values(), known, strict=True)}
    return RigFile(prior, rig, {})


def read_rig_file(path: Path) -> RigFile:
    """The rig in a file with the keys `rig` and, if wanted, `measurement`; a whole dataset.yaml will do.

    **Raises:** `InputError` that lists every fault.
    """
    return _checked(path, read_yaml_mapping(path))


def earlier_rig(path: Path) -> RigFile | None:
    """The rig in the dataset.yaml of an earlier import; None where nothing of its template is filled in.

    Scatter that it states was measured then, and is measured anew; a description that an import wrote is renewed.
    """
    document = read_yaml_mapping(path)
    rig = document.get("rig")
    parts = rig.values() if isinstance(rig, dict) else ()
    if parts and all(
        isinstance(part, dict) and not any(v is not None for v in part.values()) for part in parts
    ):
        return None
    found = _checked(path, document)
    stated = {key: value for key, value in found.measurement.items() if key not in MEASURED}
    description = str(document.get("description") or "")
    if description.startswith(BY_IMPORT):
        description = ""  # is of the recording that was cut then
    return replace(found, measurement=stated, description=description)


def _checked(path: Path, document: dict[str, Any]) -> RigFile:
    if "rig" not in document:
        raise InputError(f"{path}: rig: is missing; {REMEDY}")
    _, prior, _ = check_rig(path, document)
    whole, _, _ = as_prior(document, str(path))  # as a data set has it, whatever the file's form
    return RigFile(prior, whole["rig"], dict(whole.get("measurement") or {}))
