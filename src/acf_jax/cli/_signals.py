"""Options that name the signals of a recording, the same of every command that reads one."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

SIGNAL = "[SCALE*]COLUMN or [SCALE*]/TOPIC[:FIELD]"
OPTIONS = (
    click.option(
        "--with",
        "other",
        type=click.Path(path_type=Path),
        help="Recording of the robot, where that is one of its own.",
    ),
    click.option("--mapping", type=click.Path(path_type=Path), help="YAML file: what the signals are."),
    click.option("--force", metavar="SIGNAL", help=f"N, positive in contact: {SIGNAL}."),
    click.option("--velocity", metavar="SIGNAL", help="m/s, of the robot towards the part; or a number."),
    click.option("--position", metavar="SIGNAL", help="m, in place of the velocity: its derivative counts."),
    click.option("--pretension", metavar="SIGNAL", help="N; or a number."),
    click.option("--time", metavar="COLUMN", help="Of the times, in a table; or A+B, their sum."),
    click.option(
        "--rate", "sample_rate_hz", type=float, metavar="HZ", help="Sampling rate of a table without times."
    ),
    click.option(
        "--tare/--no-tare",
        default=None,
        help="Take off what the force reads while nothing is touched; done by default.",
    ),
)


def signal_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Adds the options to a command, which gets what they name of signals as further keywords."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command
