"""A command that holds others, and says which one a misspelt name means."""

import click

from acf_jax.errors import shown, suggestion


class Group(click.Group):
    """As click's, with a suggestion in the message for a command that is not there."""

    def resolve_command(
        self, context: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """As click does."""
        known = self.list_commands(context)
        name = args[0]
        if name not in known and not name.startswith("-") and not context.resilient_parsing:
            hint = suggestion(name.lower(), known) or f"; known are {', '.join(known)}"
            context.fail(f"no such command {shown(name)}{hint}")
        return super().resolve_command(context, args)
