"""Hooks of mkdocs: a mark `<!-- options: peak -->` becomes a table of options; pages load nothing from elsewhere."""

import logging
import re
from typing import Any

import click

from acf_jax.cli.main import commands

log = logging.getLogger("mkdocs.hooks.options")  # a warning of mkdocs ends a strict build
ELSEWHERE = re.compile(r'<(?:script|img|link)[^>]+(?:src|href)="(?:https?:)?//[^"]+')
MARK = re.compile(r"<!-- options: ([a-z ]+) -->")


def on_page_markdown(markdown: str, **page: Any) -> str:
    """The page with each mark replaced."""
    return MARK.sub(lambda mark: _table(mark[1].split()), markdown)


def on_post_page(output: str, **kept: Any) -> str:
    """The page as it is, once it is known to load nothing."""
    for found in ELSEWHERE.findall(output):
        log.warning("%s loads %s", kept["page"].file.src_path, found)
    return output


def _table(path: list[str]) -> str:
    command: click.Command = commands
    context = click.Context(command)
    for name in path:
        assert isinstance(command, click.Group), path
        found = command.get_command(context, name)
        assert found is not None, f"no command {' '.join(path)}"
        command = found
    rows = [
        _row(parameter, context) for parameter in command.params if not getattr(parameter, "hidden", False)
    ]
    return "\n".join(["| | |", "|---|---|", *rows])


def _row(parameter: click.Parameter, context: click.Context) -> str:
    if isinstance(parameter, click.Argument):
        return f"| `{parameter.human_readable_name.upper()}` | |"
    assert isinstance(parameter, click.Option)
    words, text = parameter.get_help_record(context) or ("", "")
    return f"| `{words}` | {text} |".replace("[", "\\[")
