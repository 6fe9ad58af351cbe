"""What the scale curves share."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any


def write_csv(path: Path | None, rows: Sequence[Any]) -> None:
    """Write named tuples as a table, where there is a path."""
    if path is not None:
        lines = [",".join(rows[0]._fields), *(",".join(f"{value:.6g}" for value in row) for row in rows)]
        path.write_text("\n".join(lines) + "\n", "utf-8")
