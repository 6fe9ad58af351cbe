"""What an earlier run of the same command left in its folder."""

from pathlib import Path


def traces_of(table: Path, mark: str) -> list[str]:
    """Traces of the trials in `table`, by their paths beside it; only the command fills the column `mark`."""
    from acf_jax.dataset.table import read_table

    rows = [row.cells for row in read_table(table, ("trial", mark)).rows]
    return [
        f"traces/{Path(cells['trial']).name}.csv" for cells in rows if cells.get("trial") and cells.get(mark)
    ]
