"""Progress of training: a bar on a terminal, plain lines elsewhere."""

import sys
import time
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

_LINES = 10  # a run, where there is no terminal


class Progress:
    """Shows step, time left and, where there is one, loss."""

    def __init__(self, name: str, step: int, steps: int):
        self.name, self.first, self.steps, self.start = name, step, steps, time.monotonic()
        self.next_line = step + steps / _LINES
        self.bar = None
        if sys.stdout.isatty():
            columns = (
                TextColumn("{task.description:>13}"),
                BarColumn(),
                MofNCompleteColumn(),
                TextColumn("{task.fields[loss]}"),
                TimeRemainingColumn(),
            )
            self.bar = Bar(*columns, console=Console())
            self.task = self.bar.add_task(name, total=steps, completed=step, loss="")

    def __enter__(self) -> Self:
        if self.bar:
            self.bar.start()
        return self

    def update(self, step: int, loss: float | None = None) -> None:
        """Say that `step` steps are done, the last of them with a mean `loss`."""
        shown = "" if loss is None else f"loss {loss:.1e}"
        if self.bar:
            self.bar.update(self.task, completed=step, loss=shown)
        elif step >= min(self.next_line, self.steps):
            self.next_line = step + self.steps / _LINES
            elapsed = time.monotonic() - self.start
            left = elapsed * (self.steps - step) / (step - self.first)
            words = (f"step {step:,} of {self.steps:,}", shown, f"{left:.0f} s left")
            print(f"{self.name}: {', '.join(word for word in words if word)}", flush=True)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.bar:
            self.bar.stop()
