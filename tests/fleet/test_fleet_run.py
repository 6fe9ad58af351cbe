"""A fleet on a real local cluster, one process of which is killed; and what a second run does again."""

import json
import shutil
import subprocess
import sys
from itertools import count
from pathlib import Path

import pytest
from needs import need_module

from acf_jax.dataset import read_dataset
from acf_jax.errors import InputError
from acf_jax.fleet import run as fleet_run
from acf_jax.fleet.run import run_fleet
from acf_jax.workers import Where, run_all
from tests.fleet.pieces import KILLED, process_after, refuse, weigh, weigh_or_die

EXAMPLE = Path(__file__).parents[2] / "examples/rig"
NAMES = ("a", "b", "c")
SCHEDULER = """
import time
from distributed import LocalCluster
options = {"processes": False, "protocol": "tcp", "dashboard_address": None, "memory_limit": 0}
with LocalCluster(n_workers=1, threads_per_worker=1, **options) as cluster:
    print(cluster.scheduler_address, flush=True)
    time.sleep(600)
"""


def drop_trial(folder: Path, index: int) -> None:
    rows = (folder / "trials.csv").read_text("utf-8").splitlines(keepends=True)
    (folder / "trials.csv").write_text("".join(rows[: index + 1] + rows[index + 2 :]), "utf-8")


@pytest.fixture(scope="module")
def rigs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three rigs, and a fourth folder whose trials.csv is missing."""
    folder = tmp_path_factory.mktemp("fleet") / "rigs"
    for left_out, name in enumerate(NAMES):
        shutil.copytree(EXAMPLE, folder / name)
        drop_trial(folder / name, left_out)
    shutil.copytree(folder / "a", folder / "d")
    (folder / "d" / "trials.csv").unlink()
    return folder


def quiet(done: int, total: int) -> None:
    pass


@pytest.fixture(scope="module")
def made(rigs: Path, tmp_path_factory: pytest.TempPathFactory):  # type: ignore[no-untyped-def]
    """The results of a run in which a process was killed, and what was said of its progress."""
    need_module("distributed", "pip install 'acf-jax[fleet]'")
    out, told, said = tmp_path_factory.mktemp("made") / "out", [], []
    where = Where(workers=2, say=said.append)
    fleet = run_fleet(rigs, out, 0, where, lambda *done: told.append(done), weigh_or_die)
    assert (rigs / "b" / KILLED).exists(), "the process must have been killed"
    return out, fleet, told, said


@pytest.mark.long
def test_a_killed_process_loses_nothing_and_changes_no_result(rigs, made) -> None:  # type: ignore[no-untyped-def]
    out, fleet, told, said = made
    assert told[0] == (0, 4) and told[-1] == (4, 4)
    assert said[0].startswith("dashboard: http://127.0.0.1:")
    assert [rig.rig for rig in fleet.rigs] == ["a", "b", "c", "d"]
    for name in NAMES:
        for file, content in weigh((read_dataset(rigs / name), 0)).items():
            assert (out / name / file).read_bytes() == content, f"{name}/{file}"
    assert len({rig.parameters["moving_mass_kg"].value for rig in fleet.rigs[:3]}) == 3
    assert "trials.csv: no such file" in fleet.rigs[3].fault
    assert not (out / "d").exists()


def test_only_what_changed_is_diagnosed_again(rigs, made, tmp_path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    out, before, *_ = made
    changed = shutil.copytree(rigs, tmp_path / "rigs")
    drop_trial(changed / "c", 5)

    def here(work, pieces, where):  # type: ignore[no-untyped-def]
        for name, task in pieces:
            with pytest.raises(RuntimeError) as error:
                work(task)
            yield name, error.value

    monkeypatch.setattr(fleet_run, "run_all", here)
    after = run_fleet(changed, out, 0, Where(), quiet, refuse)
    assert after.rigs[:2] == before.rigs[:2]
    assert after.rigs[2].fault.endswith("the diagnosis failed (RuntimeError: was asked to diagnose)")
    with_other_seed = run_fleet(rigs, out, 1, Where(), quiet, refuse)
    assert all("was asked to diagnose" in rig.fault for rig in with_other_seed.rigs[:3])


@pytest.mark.parametrize("file", ["diagnosis.json", "model.json", "report.html", "source.json"])
def test_a_diagnosis_that_is_not_whole_is_made_again(file, rigs, made, tmp_path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    out, before, again = shutil.copytree(made[0], tmp_path / "out"), made[1], []
    (out / "a" / file).unlink()
    (out / "b" / "diagnosis.json").write_bytes((out / "b" / "diagnosis.json").read_bytes()[:-9])
    (out / "c" / "diagnosis.json").write_text('{"gap": []}')

    def here(work, pieces, where):  # type: ignore[no-untyped-def]
        for name, task in pieces:
            again.append(name)
            yield name, work(task)

    monkeypatch.setattr(fleet_run, "run_all", here)
    assert run_fleet(rigs, out, 0, Where(), quiet, weigh).rigs == before.rigs
    assert again == list(NAMES) and (out / "a" / file).exists()


def test_a_folder_without_data_sets_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no data sets"):
        run_fleet(tmp_path, tmp_path / "out", 0, Where(), quiet)


def test_nothing_to_do_starts_no_processes() -> None:
    assert list(run_all(json.dumps, [], Where("tcp://nowhere:1"))) == []


@pytest.mark.long
def test_as_many_processes_work_as_were_asked_for() -> None:
    need_module("distributed", "pip install 'acf-jax[fleet]'")
    processes = [process for _, process in run_all(process_after, enumerate([0.3] * 6), Where(workers=3))]
    assert len(set(processes)) == 3


def test_a_scheduler_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    need_module("distributed", "pip install 'acf-jax[fleet]'")
    monkeypatch.setattr("acf_jax.workers.REACH_S", 0.1)
    with pytest.raises(InputError, match=r"--scheduler tcp://127\.0\.0\.1:1: cannot be reached"):
        list(run_all(json.dumps, [("a", 1)], Where("tcp://127.0.0.1:1")))


def test_a_scheduler_that_dies_in_the_middle_is_named(monkeypatch: pytest.MonkeyPatch, capfd) -> None:  # type: ignore[no-untyped-def]
    """A scheduler and its worker in a process of their own, on which work is done before they are killed."""
    need_module("distributed", "pip install 'acf-jax[fleet]'")
    monkeypatch.setattr("acf_jax.workers.REACH_S", 2)
    with subprocess.Popen([sys.executable, "-c", SCHEDULER], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        try:
            results = run_all(abs, ((i, -i) for i in count()), Where(process.stdout.readline().strip()))
            assert all(key == outcome for key, outcome in (next(results) for _ in range(5)))
            process.kill()
            with pytest.raises(InputError, match=r"--scheduler: went away; .*goes on where it was"):
                assert all(key == outcome for key, outcome in results)
        finally:
            process.kill()
    assert capfd.readouterr().err == "", "and nothing else is said"


def test_processes_without_the_device_that_is_asked_for_are_told_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    need_module("distributed", "pip install 'acf-jax[fleet]'")
    monkeypatch.setenv("JAX_PLATFORMS", "nonsense")  # which the processes inherit
    with pytest.raises(InputError) as error:
        list(run_all(abs, [("a", -1), ("b", -2)], Where(workers=1)))
    (fault,) = error.value.faults
    assert fault.startswith("JAX_PLATFORMS='nonsense': JAX has no such device here (")
    assert fault.endswith("; unset the variable, set it to cpu, or install JAX for that device")
