"""A rig from a YAML file or from options, checked, with all faults at once."""

from collections.abc import Mapping
from pathlib import Path


def collect_rig(path: Path | None, options: Mapping[str, float | None]) -> tuple[dict[str, float], list[str]]:
    """The rig of the file, with the options given beside it in place of the file's values."""
    from acf_jax.dataset.rig_file import RIG, read_rig
    from acf_jax.dataset.units import value_fault

    rig, faults = read_rig(path) if path else ({}, [])
    given = {name: value for name, value in options.items() if value is not None}
    faults += filter(None, (value_fault(name, value, option(name)) for name, value in given.items()))
    rig |= given
    if path is None:
        missing = [option(name) for name in RIG if name not in rig]
        faults += [f"{name} is missing; give it, or all four by --rig FILE" for name in missing]
    return rig, faults


def option(name: str) -> str:
    """The command line's option of a parameter."""
    return "--" + name.replace("_", "-")
