"""How every command ends: one exit code, and one message in place of a traceback.

0: done. 1: done, and the answer is no (a contact not allowed, nothing feasible, too little data, a training that
diverged). 2: a fault
of the options, of the input or of a file that cannot be written. 130: stopped by Ctrl-C.
"""

import _thread
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click

from acf_jax.errors import InputError, TooLittleData, one_line

NO, FAULT, STOPPED = 1, 2, 130
NOTHING_LEFT = "nothing is left half-written"
AGAIN = 0.05  # s, until Ctrl-C is told again where it fell into a callback


@contextmanager
def resumable(how: str) -> Iterator[None]:
    """Work that goes on where Ctrl-C stopped it; `how` says by which command."""
    try:
        yield
    except KeyboardInterrupt:
        raise KeyboardInterrupt(how) from None


def end_well(work: Callable[[], int | None]) -> int:
    """The exit code of `work`, after one message on standard error where it did not end by itself."""
    try:
        with _ctrl_c_counts_everywhere():
            return work() or 0
    except TooLittleData as refusal:
        return _say(NO, *(f"no answer: {reason}" for reason in refusal.faults))
    except InputError as error:
        return _say(FAULT, *(f"error: {fault}" for fault in error.faults))
    except click.exceptions.NoArgsIsHelpError as error:
        return _say(FAULT, error.format_message())
    except click.ClickException as error:
        return _say(FAULT, f"error: {one_line(error.format_message())}", *_usage(error))
    except click.Abort as abort:  # click's name for Ctrl-C
        return _say(STOPPED, f"stopped; {str(abort.__cause__ or '') or NOTHING_LEFT}")
    except KeyboardInterrupt as stop:
        return _say(STOPPED, f"\nstopped; {str(stop) or NOTHING_LEFT}")
    except OSError as error:
        # of a rename one name is temporary, the other the one that is meant
        names = " to ".join(str(name) for name in (error.filename, error.filename2) if name)
        what = error.strerror or str(error)
        return _say(FAULT, f"error: {f'{names}: ' if names else ''}{what}; check path, permissions and disk")


@contextmanager
def _ctrl_c_counts_everywhere() -> Iterator[None]:
    """Python only reports what is raised in a callback of its garbage collector, of which JAX has one."""
    report = sys.unraisablehook

    def heard(unraisable: "sys.UnraisableHookArgs") -> None:
        if issubclass(unraisable.exc_type, KeyboardInterrupt):
            threading.Timer(AGAIN, _thread.interrupt_main).start()
        else:
            report(unraisable)

    sys.unraisablehook = heard
    try:
        yield
    finally:
        sys.unraisablehook = report


def _usage(error: click.ClickException) -> list[str]:
    context = getattr(error, "ctx", None)
    return [f"{context.command_path} --help tells how it is used"] if context else []


def _say(code: int, *lines: str) -> int:
    print("\n".join(lines), file=sys.stderr)
    return code
