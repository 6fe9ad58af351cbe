"""The border to other people's readers: their exceptions become an `InputError` that names file and remedy."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TypeVar

from acf_jax.errors import InputError, shown

_SHOWN = 10  # names in a message
T = TypeVar("T")
Faults = tuple[type[Exception], ...]


class Oversized(Exception):
    """What a file would unfold to is more than it can hold; the text ends with the remedy."""


def need(module: str, extra: str, what: str) -> ModuleType:
    """The module of an optional extra; `InputError` names the extra when it is missing."""
    try:
        return import_module(module)
    except ModuleNotFoundError:
        raise InputError(
            f"{what} needs {module.split('.')[0]}, which is not installed; pip install 'acf-jax[{extra}]'"
        ) from None


@contextmanager
def border(path: Path, faults: Faults, remedy: str) -> Iterator[None]:
    """Turn `faults` raised inside, or `Oversized`, into an `InputError` about `path`."""
    try:
        yield
    except InputError:
        raise
    except Oversized as error:
        raise InputError(f"{path}: {error}") from None
    except faults as error:
        raise InputError(f"{path}: cannot be read ({in_words(error)}); {remedy}") from None


def within(items: Iterable[T], path: Path, faults: Faults, remedy: str) -> Iterator[T]:
    """The items, with `border` about getting each but not about what the caller does with it."""
    source = iter(items)
    while True:
        with border(path, faults, remedy):
            try:
                item = next(source)
            except StopIteration:
                return
        yield item


def in_words(error: Exception) -> str:
    """An exception on one short line."""
    text = " ".join(str(error).split()).rstrip(".") or "it is damaged"
    text = text if len(text) <= 160 else text[:157] + "..."
    speaks = isinstance(error, OSError) or type(error).__name__.endswith("ReaderError")
    return text if speaks else f"{type(error).__name__}: {text}"


def some(names: Iterable[object]) -> str:
    """Names in a message: the first ten, each short."""
    every = list(names)
    rest = f" and {len(every) - _SHOWN} more" if len(every) > _SHOWN else ""
    return (", ".join(shown(name) for name in every[:_SHOWN]) or "none") + rest
