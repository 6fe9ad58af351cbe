"""Samples: inside the box, distinct by purpose, those without a peak set apart."""

from pathlib import Path

import jax
import numpy as np
import pytest

from acf_jax.surrogate import load_surrogate
from acf_jax.training import evaluate
from acf_jax.training.config import read_config
from acf_jax.training.data import PURPOSES, draw_samples, make_data


@pytest.mark.parametrize("method", ["sobol", "latin_hypercube"])
@pytest.mark.parametrize("towards_edges", [False, True])
def test_samples_fill_the_box(small: Path, method: str, towards_edges: bool) -> None:
    ranges = read_config(small).ranges
    rig, impact = draw_samples(ranges, 3000, method, 1, towards_edges)
    assert rig.m.shape == impact.f_p.shape == (3000,)
    assert 0.5 <= rig.m.min() < 0.6 and 9.5 < rig.m.max() <= 10
    assert 0 <= rig.zeta.min() < 0.02 and 1.48 < rig.zeta.max() <= 1.5 + 1e-9
    assert 0.01 <= impact.v_e.min() < 0.0105 and 0.95 < impact.v_e.max() <= 1
    # the logarithmic middle of v is 0.1: half of the samples on either side, whatever the density
    assert abs(np.mean(np.asarray(impact.v_e) < 0.1) - 0.5) < 0.01
    near_faces = np.mean(np.asarray(impact.f_p) < 50)
    assert near_faces == pytest.approx(
        2 / np.pi * np.arcsin(np.sqrt(0.1)) if towards_edges else 0.1, abs=0.01
    )


def test_no_sample_serves_two_purposes(small: Path) -> None:
    config = read_config(small)
    seen = [np.asarray(make_data(config, purpose).rig.m) for purpose in PURPOSES]
    values = np.concatenate([np.unique(x) for x in seen])
    assert np.unique(values).size == values.size


def test_samples_without_a_peak_are_set_apart(small: Path) -> None:
    data = make_data(read_config(small), "test")
    counts = data.sizes()
    assert counts["without_peak"] > 0
    assert counts["with_peak"] + counts["without_peak"] == 4096
    assert data.f_max.size == counts["with_peak"]
    answers = evaluate.ask(load_surrogate(), data)
    assert answers.error.size == counts["with_peak"]
    assert all(np.isfinite(leaf).all() for leaf in (*answers, *jax.tree.leaves(data.peak)))


def test_table_1_is_that_of_the_configurations() -> None:
    lines = (Path(__file__).parents[2] / "configs/table1.csv").read_text("utf-8").splitlines()[1:]
    assert tuple(tuple(map(float, line.split(",")[1:])) for line in lines) == evaluate.TABLE1
