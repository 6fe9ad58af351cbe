"""The library of effects that the paper's model leaves out: each file of this folder is one, found by itself."""

import functools
import importlib
import inspect
import pkgutil

from acf_jax.effects._interface import AbstractEffect as AbstractEffect
from acf_jax.effects._interface import Component as Component
from acf_jax.effects._interface import Motion as Motion
from acf_jax.effects._interface import Parameter as Parameter
from acf_jax.effects._interface import shape as shape
from acf_jax.effects._interface import strength as strength


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
