"""What an earlier run of the same command left in its folder, and what is not of it."""

from collections.abc import Iterable
from pathlib import Path

from acf_jax.cli._origin import foreign_files, not_ours
from acf_jax.provenance import FILE

TRACES = ("traces", "motion")  # folders of a data set
MARK = "contact_s"  # a column of trials.csv that only an import fills


def foreign(data: Path, out: Path, overwrite: bool) -> list[str]:
    """The faults of `--out`, where the folder `data` of it holds a data set, or files, that no import wrote."""
    from acf_jax.recording.write import CUTS, REFUSED

    if overwrite:
        return []
    if (data / "trials.csv").exists() and not (data / CUTS).exists():
        return [
            f"--out {out}: holds a data set that no import wrote; name another folder, or give --overwrite"
        ]
    traces = [path for name in TRACES for path in sorted((data / name).glob("t[0-9]*.csv"))]
    return [*foreign_files((data / n for n in (CUTS, REFUSED, FILE)), False), *_unknown_traces(traces, data)]


def foreign_traces(data: Path, trials: Iterable[str], overwrite: bool) -> list[str]:
    """The fault of `--out`, where a file that no import wrote lies in the place of a trace of these trials."""
    paths = [] if overwrite else [data / name / f"{trial}.csv" for trial in trials for name in TRACES]
    return _unknown_traces([path for path in paths if path.is_file()], data)


def _unknown_traces(paths: list[Path], data: Path) -> list[str]:
    return unknown(paths, data, traces_of(data / "trials.csv", MARK)) if paths else []


def unknown(paths: Iterable[Path], folder: Path, known: Iterable[str]) -> list[str]:
    """The fault of the first file that is there and not of an earlier run, whose files in `folder` are `known`.

    A table of numbers does not say which program wrote it.
    """
    there = {folder / name for name in known}
    return [not_ours(path) for path in paths if path.is_file() and path not in there][:1]


def foreign_training(out: Path, overwrite: bool) -> list[str]:
    """The faults of the folder of a training run, where it holds results that no training wrote."""
    plain = () if (out / "metrics.json").is_file() else ("timings.json",)  # which names no program
    names = ("model.eqx", "report.html", "metrics.json", "config.yaml", FILE, *plain)
    return foreign_files((out / name for name in names), overwrite)


def of_import(data: Path) -> list[str]:
    """The files of an earlier import into the folder `data`, by their paths in it."""
    from acf_jax.recording.write import CUTS, REFUSED

    return ["dataset.yaml", "trials.csv", CUTS, REFUSED, FILE, *traces_of(data / "trials.csv", MARK)]


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
