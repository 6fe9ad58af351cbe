"""Progress of training: a bar on a terminal, on standard error; nothing in a pipe."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from acf_jax.progress_lines import tell, wants_lines

Say = Callable[[str], object]  # of a run: what was done, a line or several


class Told(Protocol):
    """Told how many steps are done, and the mean loss of the last ones where there is one."""

    def __call__(self, step: int, loss: float | None = None) -> None: ...


@contextmanager
def progress(name: str, step: int, steps: int) -> Iterator[Told]:
    """A bar of `steps` steps, of which `step` are done: their number, the time left and the loss."""
    if wants_lines():
        every = max(steps // 100, 1)
        yield lambda step, loss=None: tell(name, step, steps) if step % every == 0 else None
        return
    columns = (
        TextColumn("{task.description:>13}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[loss]}"),
        TimeRemainingColumn(),
    )
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task(name, total=steps, completed=step, loss="")

        def update(step: int, loss: float | None = None) -> None:
            bar.update(task, completed=step, loss="" if loss is None else f"loss {loss:.1e}")

        yield update
