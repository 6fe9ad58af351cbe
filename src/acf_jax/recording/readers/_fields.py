"""A value within a message by its path: `wrench.force.z`, `velocity[2]`, `velocity[lift_joint]`."""

import re
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from acf_jax.errors import InputError, suggestion
from acf_jax.recording.readers._guard import some

_STEP = re.compile(r"(\w+)(?:\[([^\[\]]+)\])?")


def getter(path: str, where: str) -> Callable[[Any], float]:
    """The function that takes the number at `path` out of a message; it raises `InputError` where there is none."""
    steps: list[tuple[str, str | None]] = []
    for part in path.split("."):
        found = _STEP.fullmatch(part)
        if found is None or part.startswith("_"):
            raise InputError(
                f"{where}: '{path}' is not the path of a field; write one such as wrench.force.z"
            )
        steps.append((found[1], found[2]))

    def get(message: Any) -> float:
        value = message
        try:
            for name, index in steps:
                owner, value = value, getattr(value, name)
                if index is not None:
                    value = value[int(index) if index.isdecimal() else list(owner.name).index(index)]
            return float(value.item() if isinstance(value, np.ndarray) else value)
        except AttributeError:
            raise InputError(f"{where}: has no field '{path}'{_hint(owner, name)}") from None
        except (IndexError, ValueError, TypeError):
            raise InputError(f"{where}: field '{path}' is not a number; {_remedy(owner)}") from None

    return get


def _hint(owner: Any, name: str) -> str:
    known = [f.name for f in fields(owner) if not f.name.startswith("_")] if is_dataclass(owner) else []
    return suggestion(name, known) or f"; there are {some(known)}"


def _remedy(owner: Any) -> str:
    names = getattr(owner, "name", None)
    if isinstance(names, list):
        return f"name a joint that moves along the contact as velocity[NAME]: {some(names)}; or take another topic"
    return "name one such as wrench.force.z"
