"""The one error that a user's input can cause."""

import difflib
import reprlib
from collections.abc import Sequence


class InputError(ValueError):
    """Faults of one input, listed together; the command line prints them and exits with code 2.

    Each fault names the file, the row or key, and the remedy.
    """

    def __init__(self, faults: Sequence[str] | str):
        listed = [faults] if isinstance(faults, str) else list(faults)
        if (rest := len(listed) - _MOST) > 0:
            listed[_MOST:] = [f"{rest:,} more faults are not shown; correct these first"]
        self.faults = [one_line(fault) for fault in listed]
        super().__init__("\n".join(self.faults))


_MOST = 100  # faults of an input that are listed
_LONGEST = 1000  # characters of a message; its end, the remedy, is kept


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
