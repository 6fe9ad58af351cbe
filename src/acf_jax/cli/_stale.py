"""What an earlier run of the same command left in its folder."""

from pathlib import Path

from acf_jax.provenance import FILE


def foreign(data: Path, out: Path, overwrite: bool) -> list[str]:
    """The fault of `--out`, where the folder `data` of it holds a data set that no import wrote."""
    from acf_jax.recording.write import CUTS

    if (data / "trials.csv").exists() and not (data / CUTS).exists() and not overwrite:
        return [
            f"--out {out}: holds a data set that no import wrote; name another folder, or give --overwrite"
        ]
    return []


def of_import(data: Path) -> list[str]:
    """The files of an earlier import into the folder `data`, by their paths in it."""
    from acf_jax.recording.write import CUTS, REFUSED

    return ["dataset.yaml", "trials.csv", CUTS, REFUSED, FILE, *traces_of(data / "trials.csv", "contact_s")]


def traces_of(table: Path, mark: str) -> list[str]:
    """Traces, and motions, of the trials in `table`, by their paths beside it; only the command fills `mark`."""
    from acf_jax.dataset.table import read_table

    rows = [row.cells for row in read_table(table, ("trial", mark)).rows]
    written = [
        (folder, Path(cells["trial"]).name)
        for cells in rows
        if cells.get("trial") and cells.get(mark)
        for folder in ("traces", *(["motion"] if cells.get("motion") else []))
    ]
    return [f"{folder}/{name}.csv" for folder, name in written]
