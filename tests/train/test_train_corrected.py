"""A surrogate of a corrected model: labels that resume, errors that are true, bounds that the check respects."""

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import yaml
from needs import need_module

from acf_jax.contact.body import WALL, Body
from acf_jax.contact.model import forces
from acf_jax.contact.model_file import ModelFile
from acf_jax.dataset.description import LowPassForm
from acf_jax.errors import InputError
from acf_jax.gap_model import write_model
from acf_jax.safety.check import Checker
from acf_jax.safety.limits import read_limits
from acf_jax.safety.situation import Situation
from acf_jax.surrogate import load_corrected
from acf_jax.surrogate.corrected_file import save_corrected
from acf_jax.surrogate.load import Shape, with_dtype
from acf_jax.training import corrected, judge, labels
from acf_jax.training.judge import Answers
from tests.corrected import gap_model
from train import fit

SMALL: dict[str, Any] = {
    "output": "run",
    "ranges": {
        "k_c": {"low": 4e4, "high": 9e4, "unit": "N/m", "scale": "log"},
        "mobility": {"low": 0, "high": 1, "unit": "1/kg"},
    },
    "samples": {"train": 4096, "held_out": 1024, "test": 1024},
    "network": {"width": 16, "depth": 2},
    "optimiser": {
        "learning_rate": 1e-2,
        "warm_up_steps": 50,
        "steps": 1500,
        "batch": 256,
        "steps_per_checkpoint": 500,
    },
}


def configuration(
    folder: Path, effect: str = "gravity", values: tuple[float, ...] = (-8.0,), **more: Any
) -> Path:
    """The small configuration and the model that it names, as files."""
    (folder / "model.json").write_text(write_model(gap_model((effect,), values)), "utf-8")
    content = SMALL | {"labels": {"model": str(folder / "model.json")}} | more
    path = folder / "small.yaml"
    path.write_text(yaml.safe_dump(content), "utf-8")
    return path


def train(config: Path, folder: Path, *more: str) -> int:
    return fit.main(["--config", str(config), "--set", f"output={folder}", *more])


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a finished run; the configuration lies beside it."""
    folder = tmp_path_factory.mktemp("corrected")
    assert train(configuration(folder), folder / "run") == 0
    return folder / "run"


def test_errors_are_those_of_the_loaded_surrogate_against_the_simulation(finished: Path) -> None:
    metrics = json.loads((finished / "metrics.json").read_text())
    relative = metrics["errors"]["box"]["relative"]
    assert 0 < relative["median"] < relative["p99"] < relative["max"] < 0.03
    model, surrogate = ModelFile(finished / "model.eqx").load_exact()
    assert surrogate is not None and metrics["bounds"]["force"] == pytest.approx(
        float(surrogate.bounds.force)
    )
    domain, random = surrogate.domain, np.random.default_rng(5)
    q = domain.at(random.random((300, len(domain.free))))
    for mobility in (0.0, 0.5):
        q[:, -1] = mobility
        answers = jax.vmap(surrogate.predict)(jnp.asarray(q))
        exact, exists = forces(model.main.peak, q[:, :-1], Body(0.0, mobility))
        inside = np.asarray(answers.is_inside)
        assert inside.mean() > 0.9 and exists[inside].all()
        error = np.abs(np.asarray(answers.force) - exact)[inside]
        assert (error <= np.asarray(answers.error_bound)[inside]).all()
        assert error.max() > 0.1 * relative["max"] * exact.min(), "the stated errors must be of this size"


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.long
def test_resuming_changes_nothing_and_makes_no_label_again(
    finished: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], workers: int
) -> None:
    """Whoever labels, this process or two others."""
    if workers > 1:
        need_module("distributed", "pip install 'acf-jax[fleet]'")
    before = (finished / "metrics.json").read_bytes(), (finished / "model.eqx").read_bytes()
    lost = finished / "labels" / "test_0000.eqx"
    lost.write_bytes(lost.read_bytes()[:-50])
    made = []
    write = labels.write_tree
    monkeypatch.setattr(
        labels, "write_tree", lambda path, *more: (made.append(path.name), write(path, *more))
    )
    more = ("--set", f"labels.workers={workers}", "--resume")
    assert train(finished.parent / "small.yaml", finished, *more) == 0
    assert made == ["test_0000.eqx"], "only the damaged block is made again"
    assert len(capsys.readouterr().err.splitlines()) == workers - 1, (
        "no progress in a pipe, at most a dashboard"
    )
    assert ((finished / "metrics.json").read_bytes(), (finished / "model.eqx").read_bytes()) == before


@pytest.mark.parametrize(
    ("between", "told"),
    [({"low_pass": LowPassForm(cutoff_hz=200.0)}, "a low-pass"), ({"tool_mass_kg": 1.0}, "a tool")],
)
def test_readings_behind_a_filter_or_a_tool_are_not_learnt(
    between: dict[str, Any], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = configuration(tmp_path)
    model = gap_model(("gravity",), (-8.0,)).model_copy(update=between)
    (tmp_path / "model.json").write_text(write_model(model), "utf-8")
    assert train(config, tmp_path / "run", "--set", "labels.force=sensed") == 2
    assert f"'sensed', but {told} lies between" in capsys.readouterr().err


def test_another_range_is_refused_before_labels_are_made(
    finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """And a run that starts afresh makes no label again that is there."""
    folder, config = tmp_path / "run", finished.parent / "small.yaml"
    shutil.copytree(finished, folder)
    made: list[str] = []
    monkeypatch.setattr(labels, "write_tree", lambda path, *_: made.append(path.name))
    before = {path: path.read_bytes() for path in (folder / "labels").iterdir()}
    assert train(config, folder, "--resume", "--set", "ranges.k_c.high=8.5e4") == 2
    assert "was written with another configuration" in capsys.readouterr().err

    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(corrected, "_train", stopped)
    assert train(config, folder) == 130
    assert not made and {path: path.read_bytes() for path in (folder / "labels").iterdir()} == before


def test_a_refusal_tells_the_share_of_evenly_spread_impacts(
    finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Not of what a search looks for: here it finds nothing but forces that grow later."""
    folder = tmp_path / "run"
    shutil.copytree(finished, folder)

    def search(*more: Any) -> Answers:
        answers = judge.search_worst(*more)
        return answers._replace(is_first=np.zeros_like(answers.is_first), force=answers.force + 10)

    monkeypatch.setattr(corrected, "search_worst", search)
    monkeypatch.setattr(corrected, "DISTANCE", 10.0)  # nothing is answered for sure
    assert train(finished.parent / "small.yaml", folder, "--resume") == 2
    assert "which it does in 0 % of the impacts" in capsys.readouterr().err


def test_the_check_asks_the_surrogate_and_falls_back_to_the_simulation(finished: Path) -> None:
    model, surrogate = ModelFile(finished / "model.eqx").load_exact()
    quick, exact = Checker(model, surrogate), Checker(model)
    limits = read_limits()

    chest = limits.find("Sternum")[0]._replace(stiffness=1.5e5)  # with the pad still inside the box

    def ask(checker: Checker, v: float):
        return checker(Situation("", (chest,), "transient", v, 70.0))

    for v in (0.08, 0.2, 0.34):
        a, b = ask(quick, v), ask(exact, v)
        assert a.decided_by == "surrogate" and b.decided_by == "simulation"
        assert a.verdict == b.verdict and a.upper >= b.upper
        assert a.upper == pytest.approx(b.upper, rel=0.05)
    assert ask(quick, 0.36).verdict == "not decidable", "outside the trials nothing is allowed"
    soft = Situation("", (chest._replace(stiffness=5e3),), "transient", 0.2, 70.0)
    assert quick(soft).decided_by == "simulation" and quick(soft).verdict == exact(soft).verdict
    near = ask(quick, 0.2)
    area = near.area._replace(force=near.upper / 2.0, force_factor=2.0)
    assert quick(near.situation._replace(areas=(area,))).decided_by == "simulation"


def test_design_adds_the_bound_and_knows_no_peak_outside(finished: Path) -> None:
    file = ModelFile(finished / "model.eqx")
    learnt, (model, surrogate) = file.load(), file.load_exact()
    z = np.array([model.at(v, f) for v in (0.06, 0.3) for f in (55.0, 85.0)])
    above, exists = forces(learnt.main.peak, z, WALL)
    exact = forces(model.main.peak, z, WALL)[0]
    assert exists.all() and (above >= exact).all()
    assert above == pytest.approx(exact, rel=2.1 * float(surrogate.bounds.force))
    assert not forces(learnt.main.peak, model.at(0.4, 70.0)[None], WALL)[1].any()


def test_what_has_learnt_the_sensors_reading_is_refused(finished: Path, tmp_path: Path) -> None:
    surrogate, model = load_corrected(finished / "model.eqx")
    shape = Shape(**SMALL["network"])
    path = tmp_path / "model.eqx"
    save_corrected(path, with_dtype(replace(surrogate, which="sensed"), "float32"), shape, model, {})
    assert load_corrected(path)[0].which == "sensed"
    with pytest.raises(InputError, match="has learnt the sensor's reading"):
        ModelFile(path)


def test_every_fault_of_the_ranges_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ranges = {
        "k_c": {"low": 1e4, "high": 2e4, "unit": "N/m"},  # leaves out the fitted 8e4
        "v_e": {"low": 0, "high": 0.3, "unit": "m/s"},
        "gravity.force_n": {"low": -2e4, "high": 2, "unit": "kg"},
        "stroke": {"low": 0, "high": 1, "unit": "m"},
    }
    assert train(configuration(tmp_path, ranges=ranges), tmp_path / "run") == 2
    said = capsys.readouterr().err
    for part in (
        "leaves out the fitted 80000",
        "needs a positive v_e",
        "unit must be N",
        "gravity.force_n: -20000 to 2 kg leaves what it can be, -",
        "ranges.stroke: is no",
    ):
        assert part in said
    assert not (tmp_path / "run").exists()
