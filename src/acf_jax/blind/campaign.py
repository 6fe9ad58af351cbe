"""A blind run: make the data sets, seal their answers, diagnose as a user would. Each stage resumes where it was."""

import json
import multiprocessing
import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from acf_jax.blind.plan import WEAK, Order, draw_plan
from acf_jax.blind.seal import SEAL, seal_answers
from acf_jax.errors import InputError, shown
from acf_jax.files import read_json_mapping, read_yaml_mapping, whole_folder, write_text

WITHHELD = "withheld.json"  # the effects that a diagnosis shall not know, by data set
RUN = "run.json"  # what a run was started with

Report = Callable[[str, int, int], None]


def _describe(folder: Path, arguments: dict[str, Any]) -> None:
    """Keep what a run was started with; `InputError` where the folder holds another one."""
    file = folder / RUN
    if not file.exists():
        if folder.exists() and any(folder.iterdir()):
            raise InputError(f"{folder}: holds files of something else; name another --out")
        write_text(file, json.dumps(arguments) + "\n")
    elif (before := read_json_mapping(file, "name another --out")) != arguments:
        raise InputError(
            f"{file}: the run in this folder has {before}; go on with these, or name another --out"
        )


class Made(NamedTuple):
    """Where a case goes: its data set for all to see, its answer apart."""

    order: Order
    folder: Path
    answer: Path


def make(folder: Path, seed: int, cases: int, worlds: Sequence[str], workers: int, report: Report) -> None:
    """Write the data sets of a run into `folder` and seal their answers.

    Raises:
        InputError: where a world does not exist, or the folder holds another run or something else.
    """
    from acf_jax.worlds import find_world

    plan = draw_plan(seed, cases, [find_world(name) for name in worlds])
    _describe(folder, {"seed": seed, "cases": cases, "worlds": list(worlds)})
    apart = folder / ".answers"
    if not (folder / SEAL).exists():
        todo = [
            Made(order, folder / f"case-{k:03d}", apart / f"case-{k:03d}.yaml")
            for k, order in enumerate(plan)
        ]
        missing = [made for made in todo if not made.answer.exists()]
        _all(workers, _make_one, missing, partial(report, "drawing data sets"), len(todo))
        withheld = {made.folder.name: made.order.without for made in todo if made.order.without}
        write_text(folder / WITHHELD, json.dumps(withheld))
        seal_answers(folder, {made.folder.name: read_yaml_mapping(made.answer) for made in todo})
    shutil.rmtree(apart, ignore_errors=True)


def _make_one(made: Made) -> None:
    import yaml

    from acf_jax.blind.imitate import imitators
    from acf_jax.worlds import answer_of, make_case, write_data

    order = made.order
    case = make_case(order.seed, order.effects, None, order.target, order.world, order.coloured)
    answer: dict[str, Any] = {**answer_of(case), "withheld": order.without}
    if case.outside_library or order.without:
        answer["neighbours"] = imitators(case, without=order.without)
    if len(order.effects) == 1 and not order.without and case.distance < WEAK[1] and not case.outside_library:
        from acf_jax.blind.ceiling import ceiling

        answer["ceiling"] = ceiling(case)
    write_data(case, made.folder)
    write_text(made.answer, yaml.safe_dump(answer, sort_keys=False))


def data_sets(folder: Path) -> list[str]:
    """The names of the data sets in a folder; `InputError` where there is none."""
    names = sorted(p.parent.name for p in folder.glob("*/dataset.yaml"))
    if not names:
        raise InputError(
            f"{folder}: holds no data sets; name a folder whose folders hold a dataset.yaml each"
        )
    return names


def diagnose_all(folder: Path, results: Path, workers: int, report: Report) -> list[str]:
    """Diagnose every data set of `folder` that has no diagnosis in `results` yet; returns their names."""
    names = data_sets(folder)
    withheld: dict[str, str] = {}
    if (folder / WITHHELD).exists():
        from acf_jax.effects import library

        withheld = read_json_mapping(folder / WITHHELD, "draw the run again")
        if strange := [name for name in withheld.values() if name not in list(library())]:
            raise InputError(f"{folder / WITHHELD}: {shown(strange[0])} is no effect; draw the run again")
    todo = [
        (folder / name, results / name, withheld.get(name, ""))
        for name in names
        if not (results / name / "diagnosis.json").exists()
    ]
    _all(workers, _diagnose_one, todo, partial(report, "diagnosing"), len(names))
    return names


def _diagnose_one(task: tuple[Path, Path, str]) -> None:
    import time

    from acf_jax.dataset import read_dataset
    from acf_jax.diagnosis.diagnose import diagnose
    from acf_jax.diagnosis.results import write_results

    data, out, without = task
    begin = time.perf_counter()
    try:
        diagnosis = diagnose(read_dataset(data), without=[without] if without else [])
    except InputError as error:  # a data set that cannot be used is a result as well
        write_text(out / "diagnosis.json", json.dumps({"error": str(error)}))
        return
    with whole_folder(out) as scratch:
        write_results(scratch, diagnosis)
        write_text(scratch / "seconds.txt", f"{time.perf_counter() - begin:.2f}\n")


def _start() -> None:
    from acf_jax.start import start_jax

    start_jax()


def _all(
    workers: int,
    work: Callable[[Any], None],
    todo: Sequence[Any],
    report: Callable[[int, int], None],
    total: int,
) -> None:
    """Run `work` on all of `todo` in processes of their own."""
    done = total - len(todo)
    report(done, total)
    if not todo:
        return
    with (
        _single_threaded(),
        ProcessPoolExecutor(
            min(workers, len(todo)), multiprocessing.get_context("spawn"), initializer=_start
        ) as pool,
    ):
        failed = []
        for future in as_completed([pool.submit(work, item) for item in todo]):
            if error := future.exception():
                failed.append(error)  # the others go on; the next run tries this one again
                continue
            done += 1
            report(done, total)
    if failed:
        raise failed[0]


@contextmanager
def _single_threaded() -> Iterator[None]:
    """Matrices are tiny: threads of the linear algebra in each process would only wait for each other."""
    before = os.environ.get("OMP_NUM_THREADS")
    os.environ["OMP_NUM_THREADS"] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ["OMP_NUM_THREADS"]
        else:
            os.environ["OMP_NUM_THREADS"] = before
