"""What an earlier run of the same command left in its folder."""

from pathlib import Path

CUTS, REFUSED = "import.html", "import_refused.html"  # the pages of an import, in its data set's folder


def foreign(data: Path, out: Path) -> list[str]:
    """The fault of `--out`, where the folder `data` of it holds a data set that no import wrote."""
    if (data / "trials.csv").exists() and not (data / CUTS).exists():
        return [f"--out {out}: holds a data set that no import wrote; name another folder"]
    return []


def traces_of(table: Path, mark: str) -> list[str]:
    """Traces of the trials in `table`, by their paths beside it; only the command fills the column `mark`."""
    from acf_jax.dataset.table import read_table

    rows = [row.cells for row in read_table(table, ("trial", mark)).rows]
    return [
        f"traces/{Path(cells['trial']).name}.csv" for cells in rows if cells.get("trial") and cells.get(mark)
    ]
