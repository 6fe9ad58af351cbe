"""What a command leaves of itself beside its results, and what it may overwrite."""

import re
import shlex
from collections.abc import Iterable, Mapping
from pathlib import Path

import click

from acf_jax.provenance import Origin

ARGUMENTS = "acf_jax.arguments"  # in click's `meta`
_OURS = re.compile(rb"acf[-_ ](jax|gap|peak|find|import)|contact_peak_force_std_n|must_stop_within_s")
OVERWRITE = click.option("--overwrite", is_flag=True, help="Also overwrite files that acf-jax did not write.")


def origin(made_of: Mapping[str, str]) -> Origin:
    """Of what the running command makes: its line as it was typed, and its inputs' SHA-256 by their names."""
    arguments = click.get_current_context().find_root().meta.get(ARGUMENTS, ())
    return Origin(shlex.join(["acf-jax", *arguments]), made_of)


def foreign_files(paths: Iterable[Path | None], overwrite: bool) -> list[str]:
    """The faults of results to be written where another program's file lies; none where that is allowed.

    A file of acf-jax names it, its schema or its columns.
    """
    if overwrite:
        return []
    return [
        not_ours(path)
        for path in paths
        if path is not None and path.is_file() and path.stat().st_size and not _is_ours(path)
    ]


def not_ours(path: Path) -> str:
    """The fault of a result to be written where another program's file lies."""
    return f"{path}: is there already, and acf-jax did not write it; name another place, or give --overwrite"


def _is_ours(path: Path) -> bool:
    try:
        return _OURS.search(path.read_bytes()) is not None
    except OSError:
        return True  # writing it will say what is wrong
