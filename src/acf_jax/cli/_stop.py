"""Options that say how a contact ends, the same of every command."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from acf_jax.contact.ending import Ending

OPTIONS = {
    "stop_after": "--stop-after",
    "travel": "--travel",
    "reaction": "--reaction",
    "deceleration": "--deceleration",
}
HELP = {
    "stop_after": "The robot has stopped so many s after first contact; until then it keeps its speed.",
    "travel": "What is left of the flange's stroke, m: the robot has stopped before it has come so far.",
    "reaction": "The robot brakes from so many s after first contact on.",
    "deceleration": "It brakes with so many m/s^2.",
}


def ending_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Adds the options to a command."""
    for name in reversed(OPTIONS):
        command = click.option(OPTIONS[name], name, type=float, help=HELP[name])(command)
    return command


def make_ending(**given: float | None) -> "tuple[Ending, list[str]]":
    """The ending that the options say, and what is wrong with it."""
    from acf_jax.contact import ending

    return ending.make_ending(given, OPTIONS)
