"""Whatever the traces look like, they can be assessed; tests/fuzz has the files."""

from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from impacts import RIG

from acf_jax.dataset import GapDataset, Measurement, Trace, Trial, assess_dataset

settings.register_profile("dataset", deadline=2000, derandomize=True, database=None)
settings.load_profile("dataset")

SHAPES = {
    "constant": lambda rng, n: np.full(n, rng.choice([0.0, 1e-9, 100.0, -50.0])),
    "noise": lambda rng, n: rng.normal(0.0, 10.0 ** rng.uniform(-6, 3), n),
    "hump": lambda rng, n: 200.0 * np.sin(np.linspace(0.0, np.pi, n)) + rng.normal(0.0, 1.0, n),
    "steps": lambda rng, n: rng.integers(-1, 3, n) * 100.0,
    "huge": lambda rng, n: rng.normal(0.0, 1e9, n),
}


@settings(max_examples=120)
@given(seed=st.integers(0, 10**6), count=st.integers(3, 12), shape=st.sampled_from([*SHAPES, "any"]))
def test_any_traces_can_be_assessed(seed, count, shape):
    rng = np.random.default_rng(seed)
    trials = []
    for i in range(count):
        n = int(rng.integers(3, 120))
        time = np.sort(rng.uniform(-0.003, 0.02, n)) if rng.random() < 0.5 else np.arange(n) * 1.25e-4
        kind = rng.choice(list(SHAPES)) if shape == "any" else shape
        trace = Trace(time, SHAPES[kind](rng, n)) if rng.random() < 0.9 else None
        condition = rng.choice([0.05, 0.3]), rng.choice([0.0, 60.0])
        trials.append(Trial(f"t{i}", *condition, 100.0 if trace is None else None, trace))
    stated = Measurement(rng.choice([None, 1e-6, 1.0]))
    quality = assess_dataset(GapDataset(Path("any"), "", RIG, stated, tuple(trials)))
    assert np.isfinite(quality.noise.std) and quality.noise.std > 1e-9
    void = {t.name for t in quality.trials if t.tells_nothing}  # left out in any case
    judged = set(quality.excluded) - void
    assert void <= set(quality.excluded) and len(judged) <= max(1, count // 4)
    assert len(quality.used) >= 3 or not judged
    assert set(quality.damaged).isdisjoint(quality.excluded)
