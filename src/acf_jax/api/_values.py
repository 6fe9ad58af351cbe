"""Where a user's numbers enter: JAX is in float64 from here on, and each number is looked at once, for its unit too."""

import warnings
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from acf_jax.dataset.units import value_fault
from acf_jax.documents import is_number
from acf_jax.errors import InputError, shown
from acf_jax.start import start_jax

CALLER = 3  # frames up from a warning: the user's line, where the function that warns is the user's call


def begin() -> None:
    """Switch JAX to float64 unless it is; every function of the API that computes begins with this."""
    _start()
    if not jax.config.jax_enable_x64:  # type: ignore[attr-defined]
        jax.config.update("jax_enable_x64", True)


@cache
def _start() -> None:
    start_jax()


def check(owner: str, **values: Any) -> None:
    """Look at each number, or at the numbers of each array, of a quantity of `acf_jax.dataset.units.QUANTITIES`.

    Traced values have no number to look at, and pass.

    **Raises:** `InputError` that lists every fault as `owner.name must ...; remedy`.
    """
    faults = [
        fault
        for name, value in values.items()
        if not isinstance(value, jax.core.Tracer) and (fault := _fault(name, value, f"{owner}.{name}"))
    ]
    if faults:
        raise InputError(faults)


def not_numbers(needed: Mapping[str, Any], optional: Mapping[str, Any]) -> list[str]:
    """Arguments that are no finite numbers; one that is `optional` may be None."""
    return [
        f"{name} must be a finite number, but is {shown(value)}; correct it"
        for name, value in {**needed, **{n: v for n, v in optional.items() if v is not None}}.items()
        if not is_number(value)
    ]


def plain(value: Any) -> Any:
    """A number of NumPy or JAX as Python's; anything else as it is."""
    return value.item() if getattr(value, "shape", None) == () else value


def for_form(value: Any) -> Any:
    """The value as JSON knows it, for a form that says what is wrong with it; text in place of what JSON lacks."""
    if isinstance(value, Mapping):
        return {str(key): for_form(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [for_form(item) for item in value]
    value = plain(value)
    return value if value is None or isinstance(value, bool | int | float | str) else shown(value)


def folder_of(value: str | Path) -> Path:
    """The path of a folder that is there or can be made; `InputError` for a file."""
    path = path_of(value)
    if path.exists() and not path.is_dir():
        raise InputError(f"{path}: is a file; name a folder")
    return path


def path_of(value: str | Path) -> Path:
    """A path in either form; `InputError` for what is none."""
    if not isinstance(value, str | Path):
        raise InputError(f"{value!r} is no path; give a text or a pathlib.Path")
    return Path(value)


def warn(notes: Iterable[str], frames: int = CALLER) -> None:
    """What a command would print as a note; `frames`: from here up to the line that the warning names."""
    for note in notes:
        warnings.warn(note, stacklevel=frames)


def _fault(name: str, value: Any, where: str) -> str | None:
    value = plain(value)
    if not isinstance(value, list | tuple) and not hasattr(value, "shape"):
        return value_fault(name, value, where)
    values = np.asarray(value)
    if not jnp.issubdtype(values.dtype, jnp.integer) and not jnp.issubdtype(values.dtype, jnp.floating):
        return value_fault(name, value, where)
    values = values.astype(float).ravel()
    odd = values[~np.isfinite(values)][:1]
    ends = odd if odd.size or not values.size else np.array([values.min(), values.max()])
    return next((fault for x in ends.tolist() if (fault := value_fault(name, x, where))), None)
