"""The one error that a user's input can cause."""

import reprlib
from collections.abc import Sequence


class InputError(ValueError):
    """Faults of one input, listed together; the command line prints them and exits with code 2.

    Each fault names the file, the row or key, and the remedy.
    """

    def __init__(self, faults: Sequence[str] | str):
        self.faults = [faults] if isinstance(faults, str) else list(faults)
        super().__init__("\n".join(self.faults))


_SHORT = reprlib.Repr()
_SHORT.maxlevel, _SHORT.maxstring, _SHORT.maxother = 2, 40, 40


def shown(value: object) -> str:
    """`value` as it is written in Python, on one line and short enough for a message."""
    return _SHORT.repr(value)
