"""Whatever stands in the files, reading ends in a data set or in an `InputError`."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from impacts import RIG, YAML, write

from acf_jax.dataset import (
    GapDataset,
    Measurement,
    Trace,
    Trial,
    assess_dataset,
    read_conditions,
    read_dataset,
)
from acf_jax.errors import InputError

FILES = ("dataset.yaml", "trials.csv", "traces/t001.csv")
settings.register_profile("dataset", deadline=2000, derandomize=True, database=None)
settings.load_profile("dataset")


class Files(dict[str, bytes]):
    """File contents by relative path, with a name short enough for a failure message."""

    def __repr__(self) -> str:
        return f"Files({sorted(self)})"


@pytest.fixture(scope="module")
def template(tmp_path_factory) -> Files:
    folder = write(tmp_path_factory.mktemp("fuzz") / "set")
    return Files({str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()})


def read_back(files: Files) -> None:
    with tempfile.TemporaryDirectory() as name:
        for relative, content in files.items():
            path = Path(name, relative)
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(content)
        try:
            assert isinstance(read_dataset(name), GapDataset)
        except InputError as error:
            assert error.faults
            for fault in error.faults:
                assert "\n" not in fault and len(fault) < 1000
                assert ";" in fault or "must hold" in fault  # the remedy


@settings(max_examples=100)
@given(
    file=st.sampled_from(FILES),
    at=st.floats(0, 1),
    cut=st.integers(0, 60),
    put=st.binary(max_size=12)
    | st.sampled_from([b",", b'"', b"\n", b"nan", b"-", b"1e999", b"&a [*a]", b"\0"]),
)
def test_mutated_bytes(template, file, at, cut, put):
    content = template[file]
    start = int(at * len(content))
    read_back(Files({**template, file: content[:start] + put + content[start + cut :]}))


@settings(max_examples=40)
@given(file=st.sampled_from(FILES), content=st.binary(max_size=400) | st.text(max_size=400).map(str.encode))
def test_any_content(template, file, content):
    read_back(Files({**template, file: content}))


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.dates(),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5) | st.integers(), inner, max_size=3)
    ),
    max_leaves=5,
)
KEYS = [("schema",), ("rig",), ("rig", "moving_mass_kg"), ("rig", "moving_mass_kg", "std"), ("measurement",)]


@settings(max_examples=80)
@given(keys=st.sampled_from(KEYS) | st.tuples(st.text(max_size=6)), value=VALUES)
def test_any_value_in_the_description(template, keys, value):
    document = yaml.safe_load(YAML)
    place = document
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = value
    read_back(Files({**template, "dataset.yaml": yaml.safe_dump(document).encode()}))


@settings(max_examples=60)
@given(content=st.text(st.sampled_from('ab0.,1-"\n\r e/\0;'), max_size=60))
def test_any_conditions(content):
    with tempfile.TemporaryDirectory() as name:
        path = Path(name, "conditions.csv")
        path.write_text("trial,contact_velocity_m_per_s,pretension_n\n" + content)
        try:
            for trial in read_conditions(path):
                assert Path(trial.name).name == trial.name
        except InputError as error:
            assert error.faults


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
    assert np.isfinite(quality.noise.std)
    assert len(quality.excluded) <= max(1, count // 4)
    assert len(quality.used) >= 3 or not quality.excluded
