"""A value within a message by its path: `wrench.force.z`, `velocity[2]`, `velocity[lift_joint]`."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from acf_jax.errors import InputError, shown, suggestion
from acf_jax.recording.readers._guard import some

_STEP = re.compile(r"(\w+)(?:\[([^\[\]]+)\])?")

Steps = Sequence[tuple[str, str | None]]  # name of a field, and which element of it


def getter(path: str, where: str) -> Callable[[Any], float]:
    """The function that takes the number at `path` out of a message.

    **Raises:** `InputError` when `path` is none; the function raises it for a message without a number there, and lists
    what there is.
    """
    steps: list[tuple[str, str | None]] = []
    for part in path.split("."):
        found = _STEP.fullmatch(part)
        if found is None or part.startswith("_"):
            raise InputError(
                f"{where}: '{path}' is not the path of a field; write one such as wrench.force.z"
            )
        steps.append((found[1], found[2]))

    def get(message: Any) -> float:
        try:
            value = message
            for name, index in steps:
                owner, value = value, _field(value, name)
                if index is not None:
                    value = _element(owner, value, index)
            if isinstance(value, str):
                raise TypeError("text")
            return float(value.item() if isinstance(value, np.ndarray) else value)
        except (AttributeError, LookupError, ValueError, TypeError):
            raise InputError(f"{where}: {_explained(message, path, steps)}") from None

    return get


def _field(owner: Any, name: str) -> Any:
    owner.__dataclass_fields__[name]  # what else a message or an array has is no field of it
    return getattr(owner, name)


def _element(owner: Any, array: Any, index: str) -> Any:
    return array[int(index) if index.isdecimal() else list(owner.name).index(index)]


def _explained(message: Any, path: str, steps: Steps) -> str:
    """Why there is no number at `path`, and what there is instead at the place where it leaves the message."""
    owner, value, reached = message, message, ""
    for name, index in steps:
        if name not in _names(value):
            return f"has no field {shown(path)}{_instead(message, path, owner, value, reached)}"
        owner, value = value, getattr(value, name)
        reached = f"{reached}.{name}" if reached else name
        if index is None:
            continue
        if not _is_array(value):
            return f"field {shown(reached)} is no array; write it without [{index}]"
        try:
            value = _element(owner, value, index)
        except (AttributeError, LookupError, ValueError):
            return f"field {shown(reached)} has no element [{index}]; {_elements(owner, value, reached)}"
        reached = f"{reached}[{index}]"
    return f"field {shown(reached)} is not a number{_instead(message, path, owner, value, reached)}"


def _instead(message: Any, path: str, owner: Any, value: Any, reached: str) -> str:
    """What to write: an element of the array that was reached, a number like that named, or one of those there are."""
    if _is_array(value):
        return f"; {_elements(owner, value, reached)}"
    if guess := _guess(message, path):
        return f"{guess} ({reached or 'it'} holds {some(_names(value))})" if _names(value) else guess
    names = [name for name in _names(value) if _is_array(getattr(value, name))]
    place = f"{reached}." if reached else ""
    arrays = [f"; {_elements(value, getattr(value, name), place + name)}" for name in names[:3]]
    below = [] if reached.startswith("header") else list(numbers(value, place))
    return f"; its numbers are {some(below or numbers(message))}{''.join(arrays)}"


def _guess(message: Any, path: str) -> str:
    """The number that is meant: one whose path holds the steps of `path` in order, else one that resembles it."""
    known = list(numbers(message))
    for candidate in sorted(known, key=lambda name: not name.endswith("z")):  # the usual axis first
        steps = iter(re.split(r"[.\[]", candidate.lower()))
        if all(step in steps for step in path.lower().split(".")):
            return f"; did you mean {shown(candidate)}?"
    return suggestion(path, known)


def _elements(owner: Any, array: Any, reached: str) -> str:
    """How an element of an array is written."""
    if len(array) == 0:
        return f"{reached} is empty: name another field or topic"
    names = getattr(owner, "name", None)
    if isinstance(names, list) and len(names) == len(array):
        return f"name a joint that moves along the contact as {reached}[NAME]: {some(names)}; or take another topic"
    rest = next(numbers(array[0], "."), "")
    return f"{reached} has {len(array)} elements: write {reached}[{_usual(array)}]{rest}"


def numbers(owner: Any, place: str = "") -> Iterator[str]:
    """The paths of the numbers in a message, but for those of its header; of an array that of one element."""
    for name in _names(owner):
        value, path = getattr(owner, name), f"{place}{name}"
        if _is_array(value) and len(value):
            value, path = value[_usual(value)], f"{path}[{_usual(value)}]"
        if _names(value):
            yield from numbers(value, f"{path}.") if name != "header" else ()
        elif not isinstance(value, str) and not _is_array(value):
            yield path


def _usual(array: Any) -> int:
    """The element of a force or a velocity along z, if there are so many."""
    return min(2, len(array) - 1)


def _names(owner: Any) -> list[str]:
    return [f.name for f in fields(owner) if not f.name.startswith("_")] if is_dataclass(owner) else []


def _is_array(value: Any) -> bool:
    return isinstance(value, list | np.ndarray)
