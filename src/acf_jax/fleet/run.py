"""Diagnose every data set of a folder: in many processes, and only what is not diagnosed yet."""

import json
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from acf_jax import __version__
from acf_jax.dataset import GapDataset, data_sets, read_dataset
from acf_jax.errors import InputError
from acf_jax.files import read_json_mapping, read_text, write_text
from acf_jax.fleet.record import Fleet, Rig, rig_of
from acf_jax.fleet.results import new_fleet
from acf_jax.folders import read_folder, write_folder
from acf_jax.workers import Where, run_all

DIAGNOSIS = "diagnosis.json"
WRITTEN = (DIAGNOSIS, "model.json", "report.html")
SOURCE = "source.json"  # of which data a diagnosis was made, beside it

Task = tuple[GapDataset, int]  # a data set and the seed
Files = dict[str, bytes]


def diagnose_one(task: Task) -> Files:
    """The files that `diagnose` writes for a data set."""
    from acf_jax.diagnosis import diagnose
    from acf_jax.diagnosis.results import write_results
    from acf_jax.report import write_report

    diagnosis = diagnose(*task)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        write_report(folder / "report.html", diagnosis, write_results(folder, diagnosis))
        return read_folder(folder)


def run_fleet(
    folder: Path,
    out: Path,
    seed: int,
    where: Where,
    report: Callable[[int, int], None],
    work: Callable[[Task], Files] = diagnose_one,
) -> Fleet:
    """Diagnose the data sets of `folder` into folders of the same names in `out`.

    A diagnosis that is there already stays if it is whole and made of the same data, with the same seed and version.

    **Arguments:** `report`: told how many rigs of how many are done.

    **Returns:** a line a rig; a data set that cannot be used, or whose diagnosis failed, has its fault there.

    **Raises:** `InputError` where the folder holds no data sets, or the processes cannot be had.
    """
    names = data_sets(folder)
    rigs: dict[str, Rig] = {}
    sources: dict[str, Source] = {}
    done = 0

    def told() -> None:
        report(done, len(names))

    def missing() -> Iterator[tuple[str, Task]]:
        nonlocal done
        for name in names:
            try:
                dataset = read_dataset(folder / name)
            except InputError as error:
                rigs[name] = Rig(rig=name, fault=str(error))
            else:
                sources[name] = Source(dataset.digest, seed)
                made = _made(out / name, sources[name])
                if made is None:
                    yield name, (dataset, seed)
                    continue
                rigs[name] = made
            done += 1
            told()

    told()
    for name, outcome in run_all(work, missing(), where):
        done += 1
        if isinstance(outcome, Exception):
            why = " ".join(f"{type(outcome).__name__}: {outcome}".split())
            rigs[name] = Rig(rig=name, fault=f"{folder / name}: the diagnosis failed ({why})")
        else:
            (out / name / SOURCE).unlink(missing_ok=True)
            write_folder(out / name, outcome)
            write_text(out / name / SOURCE, sources[name].text)  # last: with it the diagnosis is whole
            rigs[name] = rig_of(name, sources[name].digest, json.loads(outcome[DIAGNOSIS]))
        told()
    return new_fleet(out.resolve().name, [rigs[name] for name in names])


class Source(NamedTuple):
    """What a diagnosis depends on."""

    digest: str  # of the data
    seed: int
    version: str = __version__

    @property
    def text(self) -> str:
        return json.dumps(self._asdict()) + "\n"


def _made(result: Path, source: Source) -> Rig | None:
    """The line of a rig whose diagnosis of this source is there; None where a file of it is missing or broken."""
    try:
        if read_text(result / SOURCE) != source.text or not all(
            (result / file).is_file() for file in WRITTEN
        ):
            return None
        return rig_of(result.name, source.digest, read_json_mapping(result / DIAGNOSIS, "diagnose again"))
    except (AttributeError, LookupError, TypeError, ValueError):  # cut off, or written by hand
        return None
