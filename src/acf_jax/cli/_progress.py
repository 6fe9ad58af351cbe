"""Progress on standard error: a bar on a terminal, nothing in a pipe, JSON lines for a program that asks for them.

rich leaves colours out where NO_COLOR is set.
"""

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

from acf_jax.progress_lines import tell, wants_lines

Item = TypeVar("Item")
Stage = Callable[[str], None]
Count = Callable[[str, int, int], None]


@contextmanager
def stages(note: str = "") -> Iterator[Stage]:
    """A line that tells the stage and the time, and a note beside it on a terminal."""
    if wants_lines():
        yield tell
        return
    if not sys.stderr.isatty():
        yield lambda stage: None
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("starting", total=None)
        yield lambda stage: bar.update(task, description=f"{stage} {note}".rstrip())


@contextmanager
def counts() -> Iterator[Count]:
    """A bar for each stage: its name, how many are done, of how many."""
    if wants_lines():
        yield tell
        return
    if not sys.stderr.isatty():
        yield lambda stage, done, total: None
        return
    from rich.console import Console
    from rich.progress import Progress, TaskID

    with Progress(console=Console(stderr=True), transient=True) as bar:
        tasks: dict[str, TaskID] = {}

        def count(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                tasks[stage] = bar.add_task(stage, total=None)
            bar.update(tasks[stage], completed=done, total=total or None)

        yield count


def counted(items: Sequence[Item], what: str) -> Iterator[Item]:
    """The items one by one, with a bar that counts them."""
    with counts() as count:
        for done, item in enumerate(items):
            count(what, done, len(items))
            yield item
