"""The one error that a user's input can cause."""

import difflib
import reprlib
from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

Result = TypeVar("Result")


class InputError(ValueError):
    """Faults of one input, listed together; the command line prints them and exits with code 2.

    Each fault names the file, the row or key, and the remedy.
    """

    def __init__(self, faults: Sequence[str] | str):
        listed = [faults] if isinstance(faults, str) else list(dict.fromkeys(faults))
        if (rest := len(listed) - _MOST) > 0:
            listed[_MOST:] = [f"{rest:,} more faults are not shown; correct these first"]
        self.faults = [one_line(fault) for fault in listed]
        super().__init__("\n".join(self.faults))


class TooLittleData(InputError):
    """The data behind a model do not carry an answer; the command line prints what is missing and exits with code 1."""


def collected(faults: list[str], read: Callable[[], Result]) -> Result | None:
    """What `read` returns; None where the input has faults, which are added to `faults`."""
    try:
        return read()
    except InputError as error:
        faults += error.faults
        return None


_MOST = 100  # faults of an input that are listed
_NAMED = 3  # inputs that are named where more have the same fault
_LONGEST = 1000  # characters of a message; its end, the remedy, is kept


def merged(faults: Iterable[tuple[str, Sequence[str]]]) -> list[str]:
    """The faults of many inputs, with one line for a fault that more than three of them share, in place of a line each.

    **Arguments:** `faults`: of each input its path and its faults, those of its files beginning with that path.
    """
    places: dict[tuple[str, str], list[str]] = {}  # by the file within its input, and what is wrong
    for path, own in faults:
        for fault in own:
            inner, colon, what = fault.removeprefix(path).partition(": ")
            is_within = bool(colon) and fault.startswith(path)
            key = (inner, what) if is_within else ("", fault)
            places.setdefault(key, []).append(f"{path}{inner}" if is_within else "")
    lines = []
    for (_, what), named in places.items():
        if not named[0]:
            lines.append(what)
        elif len(named) > _NAMED:
            lines.append(f"{', '.join(named[:_NAMED])} and {len(named) - _NAMED:,} more: {what}")
        else:
            lines += [f"{place}: {what}" for place in named]
    return lines


def one_line(fault: str) -> str:
    """A message with whatever a file brought into it, a key with a line break for example, on one line."""
    text = "".join(c if c.isprintable() else repr(c)[1:-1] for c in fault)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST // 2]}...{text[-_LONGEST // 2 :]}"


_SHORT = reprlib.Repr()
_SHORT.maxlevel, _SHORT.maxstring, _SHORT.maxother = 2, 40, 40


def shown(value: object) -> str:
    """`value` as it is written in Python, on one line and short enough for a message."""
    return _SHORT.repr(value)


def suggestion(name: str, known: Sequence[str]) -> str:
    """`; did you mean ...` when one of `known` resembles `name`, else an empty string."""
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.6)
    return f"; did you mean {shown(close[0])}?" if close else ""
