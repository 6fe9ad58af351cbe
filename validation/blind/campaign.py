"""A blind run: make the data sets, seal their answers, diagnose as a user would. Each stage resumes where it was."""

import json
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from acf_jax.dataset import GapDataset, data_sets, read_dataset
from acf_jax.documents import yaml_text
from acf_jax.errors import InputError, shown
from acf_jax.files import read_json_mapping, read_text, read_yaml_mapping, write_text
from acf_jax.folders import read_folder, write_folder
from acf_jax.workers import Where, run_all
from validation.blind.answer import DIAGNOSIS, SECONDS
from validation.blind.plan import WEAK, Order, draw_plan
from validation.blind.seal import ENDED, SEAL, is_opened, seal_answers

WITHHELD = "withheld.json"  # the effects that a diagnosis shall not know, by data set
RUN = "run.json"  # what a run was started with
SOURCE = "source.txt"  # of which data a diagnosis was made, beside it
UNREADABLE = "data that cannot be read"
SHOWN = 8  # data sets that are named where many fail

Report = Callable[[str, int, int], None]
Files = dict[str, bytes]


def _describe(folder: Path, arguments: dict[str, Any]) -> None:
    """Keep what a run was started with; `InputError` where the folder holds another one."""
    file = folder / RUN
    if not file.exists():
        if folder.exists() and any(folder.iterdir()):
            raise InputError(f"{folder}: holds files of something else; name another --out")
        write_text(file, json.dumps(arguments) + "\n")
    elif (before := read_json_mapping(file, "name another --out")) != arguments:
        raise InputError(
            f"{file}: the run in this folder has {shown(before)}; go on with these, or name another --out"
        )


def make(folder: Path, seed: int, cases: int, worlds: Sequence[str], where: Where, report: Report) -> None:
    """Write the data sets of a run into `folder` and seal their answers.

    **Raises:** `InputError` where a world does not exist, or the folder holds another run or something else.
    """
    from validation.worlds import find_world

    plan = draw_plan(seed, cases, [find_world(name) for name in worlds])
    _describe(folder, {"seed": seed, "cases": cases, "worlds": list(worlds)})
    apart = folder / ".answers"
    if not (folder / SEAL).exists():
        orders = {f"case-{k:03d}": order for k, order in enumerate(plan)}
        answers = {name: apart / f"{name}.yaml" for name in orders}
        missing = {name: order for name, order in orders.items() if not answers[name].exists()}

        def keep(name: str, made: tuple[Files, str]) -> None:
            data, answer = made
            write_folder(folder / name, data)
            write_text(answers[name], answer)  # last: with it the case is whole

        told = partial(report, "drawing data sets")
        _each(_make_one, missing.items(), keep, where, told, len(orders) - len(missing), len(orders))
        withheld = {name: order.without for name, order in orders.items() if order.without}
        write_text(folder / WITHHELD, json.dumps(withheld))
        seal_answers(folder, {name: read_yaml_mapping(answer) for name, answer in answers.items()})
    shutil.rmtree(apart, ignore_errors=True)


def _make_one(order: Order) -> tuple[Files, str]:
    """The files of a data set, and its answer, which goes elsewhere."""
    from validation.blind.imitate import imitators
    from validation.worlds import answer_of, make_case, make_lifelike, write_data

    if order.kind == "lifelike":
        case = make_lifelike(order.seed, order.effects, order.world, order.coloured)
    else:
        case = make_case(order.seed, order.effects, None, order.target, order.world, order.coloured)
    answer: dict[str, Any] = {**answer_of(case), "withheld": order.without}
    if order.kind in ("beyond", "withheld"):
        answer["neighbours"] = imitators(case, without=order.without)
    if order.kind == "single" and case.distance < WEAK[1]:
        from validation.blind.ceiling import ceiling

        answer["ceiling"] = ceiling(case)
    with tempfile.TemporaryDirectory() as scratch:
        write_data(case, Path(scratch))
        return read_folder(Path(scratch)), yaml_text(answer)


def diagnose_all(folder: Path, results: Path, where: Where, report: Report) -> list[str]:
    """Diagnose every data set of `folder` that has no diagnosis in `results` yet; returns their names.

    **Raises:** `InputError` where data were changed after their diagnosis, or diagnoses failed.
    """
    names = data_sets(folder)
    withheld: dict[str, str] = {}
    if (folder / WITHHELD).exists():
        from acf_jax.effects import library

        withheld = read_json_mapping(folder / WITHHELD, "draw the run again")
        if strange := [name for name in withheld.values() if name not in list(library())]:
            raise InputError(f"{folder / WITHHELD}: {shown(strange[0])} is no effect; draw the run again")
    missing = [name for name in names if not (results / name / DIAGNOSIS).exists()]
    if changed := [name for name in names if name not in missing and _changed(folder / name, results / name)]:
        opened = is_opened(folder, results)
        raise InputError(
            [
                f"{folder / name}: was changed after its diagnosis;"
                f" {ENDED if opened else f'remove {results / name}, and go on'}"
                for name in changed
            ]
        )

    def pieces() -> Iterator[tuple[str, tuple[GapDataset, str]]]:
        for name in missing:
            try:
                yield name, (read_dataset(folder / name), withheld.get(name, ""))
            except InputError as error:
                write_folder(results / name, _unusable(error, UNREADABLE))

    def keep(name: str, files: Files) -> None:
        write_folder(results / name, files)

    told = partial(report, "diagnosing")
    _each(_diagnose_one, pieces(), keep, where, told, len(names) - len(missing), len(names))
    return names


def _diagnose_one(task: tuple[GapDataset, str]) -> Files:
    """The files of a diagnosis, and how long it took."""
    import time

    from acf_jax.diagnosis import diagnose
    from acf_jax.diagnosis.results import write_results

    dataset, without = task
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as scratch:
        try:
            write_results(Path(scratch), diagnose(dataset, without=[without] if without else []))
        except InputError as error:
            return _unusable(error, dataset.digest)
        write_text(Path(scratch) / SOURCE, dataset.digest)
        write_text(Path(scratch) / SECONDS, f"{time.perf_counter() - begin:.2f}\n")
        return read_folder(Path(scratch))


def _unusable(error: InputError, source: str) -> Files:
    """A data set that cannot be used is a result as well."""
    return {DIAGNOSIS: json.dumps({"error": str(error)}).encode(), SOURCE: source.encode()}


def _changed(data: Path, result: Path) -> bool:
    """Whether a diagnosis was made of other data than those that are there; older ones do not tell."""
    if not (result / SOURCE).exists():
        return False
    try:
        source = read_dataset(data).digest
    except InputError:
        source = UNREADABLE
    return read_text(result / SOURCE) != source


def _each(
    work: Callable[[Any], Any],
    pieces: Iterable[tuple[str, Any]],
    keep: Callable[[str, Any], None],
    where: Where,
    report: Callable[[int, int], None],
    done: int,
    total: int,
) -> None:
    """Do `work` on all pieces and keep each result; `InputError` names those that failed when all others are done."""
    report(done, total)
    failed = []
    for name, outcome in run_all(work, pieces, where):
        if isinstance(outcome, Exception):
            failed.append(f"{name}: failed ({type(outcome).__name__}: {outcome}); {where.again}")
            continue
        keep(name, outcome)
        done += 1
        report(done, total)
    if failed:
        more = len(failed) - SHOWN
        raise InputError([*failed[:SHOWN], *([f"and {more} more failed"] if more > 0 else [])])
