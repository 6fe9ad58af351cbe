"""`python -m acf_jax`: one command a file in this folder, imported only when it is called."""

import importlib
import io
import keyword
import os
import sys
from collections.abc import Sequence
from pathlib import Path

import click

from acf_jax import __version__
from acf_jax.cli._ending import end_well
from acf_jax.cli._group import Group
from acf_jax.cli._origin import ARGUMENTS

COMPLETE = "_ACF_JAX_COMPLETE"  # click's variable for shell completion


class CommandFolder(Group):
    """The commands are the modules beside this one that have a `command`; a new file is a new command."""

    def parse_args(self, context: click.Context, args: list[str]) -> list[str]:
        """As click does; results keep the line that was typed."""
        context.meta[ARGUMENTS] = tuple(args)
        return super().parse_args(context, args)

    def list_commands(self, context: click.Context) -> list[str]:
        files = Path(__file__).parent.glob("*.py")
        names = (f.stem for f in files if f.stem not in ("__init__", "main") and f.stem[0] != "_")
        return sorted(name.rstrip("_") for name in names)

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        if name not in self.list_commands(context):
            return None
        # a name that Python keeps for itself has a file with an underscore behind it
        module = importlib.import_module(f"acf_jax.cli.{name}{'_' * keyword.iskeyword(name)}")
        command: click.Command = module.command
        return command


@click.group(cls=CommandFolder, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="acf-jax")
def commands() -> None:
    """Peak contact force of an active contact flange: model, surrogate and gap diagnosis."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and end with its exit code."""
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="backslashreplace")  # as standard error: a file's name may be no text
    # A shell completes the installed program by its name; every other text names what works without installing.
    name = "acf-jax" if COMPLETE in os.environ else "python -m acf_jax"

    def work() -> int | None:
        code: int | None = commands.main(arguments, name, COMPLETE, standalone_mode=False)
        return code

    sys.exit(end_well(work))
