"""Fits that an interrupted diagnosis leaves, and the diagnosis that goes on with them."""

import json
import pickle
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from acf_jax.cli.main import commands
from acf_jax.inference import fit as fitting
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import begin
from acf_jax.inference.unfinished import beside, digest, kept_in
from tests.few import few_explanations
from tests.imagined import RIG, imagined

EXAMPLE = Path(__file__).resolve().parents[2] / "examples/rig"


@pytest.fixture(scope="module")
def trials() -> Observations:
    return imagined("gravity", (6.0,))


@pytest.fixture
def searched(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, ...]]:
    """The explanations whose optimum was looked for."""
    found, optimum = [], fitting._optimum

    def counted(observations: Observations, explanation: tuple[str, ...], *rest: Any) -> Any:
        found.append(explanation)
        return optimum(observations, explanation, *rest)

    monkeypatch.setattr(fitting, "_optimum", counted)
    return found


def gravity(trials: Observations, size: float = 5.0) -> Fit:
    return fit(trials, ("gravity",), begin(RIG.values, [size]))


def interrupted(folder: Path, work: Callable[[], Fit]) -> Fit:
    with pytest.raises(KeyboardInterrupt), kept_in(folder):
        found = work()
        raise KeyboardInterrupt
    return found


def test_a_fit_that_is_known_is_the_same_to_the_last_digit(
    trials: Observations, searched: list[tuple[str, ...]], tmp_path: Path
) -> None:
    plain = gravity(trials)
    kept = interrupted(tmp_path / "fits", lambda: gravity(trials))
    assert len(searched) == 2
    with kept_in(tmp_path / "fits") as left:
        again = gravity(trials)
        assert left == 1 and len(searched) == 2
        gravity(trials, 4.0)
        gravity(replace(trials, noise=replace(trials.noise, std=0.3)))
        gravity(trials.subset(np.arange(len(trials.names)) != 3))
        assert len(searched) == 5  # another start, noise, or set of trials is another fit
    assert not (tmp_path / "fits").exists()
    for one in (kept, again):
        assert one.objective == plain.objective and one.grid == plain.grid
        for name in ("u", "nuisance", "hessian", "chi2"):
            assert np.array_equal(getattr(one, name), getattr(plain, name)), name


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", "pickle"])
def test_what_is_damaged_or_no_plain_numbers_is_fitted_anew(
    trials: Observations, searched: list[tuple[str, ...]], tmp_path: Path, content: bytes | str
) -> None:
    interrupted(tmp_path, lambda: gravity(trials))
    (path,) = tmp_path.glob("*.npz")
    path.write_bytes(pickle.dumps({"u": 1}) if isinstance(content, str) else content)
    interrupted(tmp_path, lambda: gravity(trials))
    assert len(searched) == 2


def test_a_folder_that_cannot_be_written_costs_nothing_else(trials: Observations, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with kept_in(tmp_path / "file/fits") as left:
        assert left == 0 and np.isfinite(gravity(trials).objective)


def test_every_part_counts_in_what_tells_fits_apart() -> None:
    values = [
        1,
        1.0,
        "1",
        None,
        True,
        (1,),
        (1, 2),
        ((1,), 2),
        np.ones(2),
        np.ones(2, np.float32),
        np.ones((1, 2)),
    ]
    assert len({digest(value) for value in values}) == len(values)
    assert digest((np.arange(3.0), RIG)) == digest((np.arange(3.0), replace(RIG)))


@pytest.mark.long
def test_a_diagnosis_that_was_interrupted_goes_on(
    searched: list[tuple[str, ...]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def diagnosed(out: Path) -> Any:
        command = ["diagnose", str(EXAMPLE), "--out", str(out), "--json"]
        with few_explanations(("end_stop", "gravity"), ()):
            return CliRunner().invoke(commands, command)

    whole = diagnosed(tmp_path / "whole")
    total, counted = len(searched), fitting._optimum
    assert total > 10 and "goes on" not in whole.stderr

    def stops(*arguments: Any) -> Any:
        if len(searched) == total + 8:
            raise KeyboardInterrupt
        return counted(*arguments)

    monkeypatch.setattr(fitting, "_optimum", stops)
    assert diagnosed(tmp_path / "out").exception is not None
    assert not (tmp_path / "out").exists() and beside(tmp_path / "out").is_dir()
    monkeypatch.setattr(fitting, "_optimum", counted)
    again = diagnosed(tmp_path / "out")
    assert "note: goes on with 8 fits of a diagnosis that was interrupted" in again.stderr
    assert len(searched) == 2 * total  # none is made twice
    assert json.loads(again.stdout) == json.loads(whole.stdout)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out", "whole"]
