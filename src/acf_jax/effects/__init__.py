"""The library of effects that the paper's model leaves out: each file of this folder is one, found by itself."""

import functools
import importlib
import inspect
import pkgutil
from collections.abc import Collection

from acf_jax.effects._interface import COMPONENTS as COMPONENTS
from acf_jax.effects._interface import AbstractEffect as AbstractEffect
from acf_jax.effects._interface import Component as Component
from acf_jax.effects._interface import Motion as Motion
from acf_jax.effects._interface import Parameter as Parameter
from acf_jax.effects._interface import shape as shape
from acf_jax.effects._interface import strength as strength
from acf_jax.effects._oscillator import AbstractOscillator as AbstractOscillator
from acf_jax.errors import suggestion


@functools.cache
def library() -> dict[str, type[AbstractEffect]]:
    """Every effect of this folder by its id, in alphabetical order."""
    found = {}
    for name in sorted(info.name for info in pkgutil.iter_modules(__path__)):
        if name.startswith("_"):
            continue
        module = importlib.import_module(f"{__name__}.{name}")
        for _, cls in inspect.getmembers(module, inspect.isclass):
            if cls.__module__ == module.__name__ and issubclass(cls, AbstractEffect):
                found[cls.id()] = cls
    return found


def remaining(without: Collection[str]) -> list[str]:
    """The effects that may act where some are left out, by their own name or by that of their component.

    **Raises:** `ValueError` for what is neither, and where none may act.
    """
    known = [*library(), *COMPONENTS]
    for name in without:
        if name not in known:
            hint = suggestion(name, known) or f"; take of {known}"
            raise ValueError(f"no effect is called {name!r}{hint}")
    left = [name for name, cls in library().items() if name not in without and cls.component not in without]
    if not left:
        raise ValueError("every effect is left out; leave at least one")
    return left
