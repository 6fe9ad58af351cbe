"""Whatever stands in a recording, a mapping or a review, it is read or refused with an `InputError`.

A longer run: ACF_FUZZ_EXAMPLES=5000 python -m pytest -q tests/recording/test_import_fuzz.py
"""

import os
import tempfile
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from needs import need_module
from sessions import FEW, columns, made, write_bag, write_csv

from acf_jax.errors import InputError
from acf_jax.recording import Mapping, Session, find_impacts, read_mapping, read_session
from acf_jax.recording.review import read_review
from acf_jax.recording.rig import read_rig_file
from acf_jax.recording.series import Series

LONG = int(os.environ.get("ACF_FUZZ_EXAMPLES", "0"))
settings.register_profile(
    "recordings",
    deadline=None,
    database=None,
    derandomize=not LONG,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
settings.load_profile("recordings")
KINDS = ("a.mcap", "b.db3", "c.bag", "d.csv", "e.npz", "f.npy", "g.parquet", "metadata.yaml")
SIZES = st.sampled_from(
    [b"\0", b"\xff", b"\xff\xff\xff\x7f", b"\xff" * 8, b"\0" * 8, b"\x01", b"\x80", b"[", b"&a [*a]"]
)


def examples(few: int):
    return settings(max_examples=LONG or few)


class Bytes(bytes):
    """File contents with a name short enough for a failure message."""

    def __repr__(self) -> str:
        return f"Bytes({len(self)})"


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> dict[str, Bytes]:
    """A sound small recording of each kind, and the metadata of a ROS 2 bag."""
    folder = tmp_path_factory.mktemp("sound")
    session = made(1, FEW[:1], rate=500.0)
    write_bag(folder / "a", session, "mcap")
    write_bag(folder / "b", session, "sqlite3")
    write_bag(folder / "c.bag", session, "ros1", speed="pose")
    write_csv(folder / "d.csv", session)
    table = columns(session)
    np.savez(folder / "e.npz", **table)
    array = np.empty(table["time_s"].size, [(name, float) for name in table])
    for name, values in table.items():
        array[name] = values
    np.save(folder / "f.npy", array)
    need_module("pyarrow.parquet").write_table(need_module("pyarrow").table(table), folder / "g.parquet")
    paths = [folder / "a/a.mcap", folder / "b/b.db3", *(folder / name for name in KINDS[2:-1])]
    return {p.name: Bytes(p.read_bytes()) for p in [*paths, folder / "a/metadata.yaml"]}


def refused_or(read) -> object:
    """What `read` returns, or the `InputError`, which has to name faults in a few words."""
    try:
        return read()
    except InputError as error:
        assert error.faults and all(fault.strip() and len(fault) < 4000 for fault in error.faults)
        return error


def read_back(files: dict[str, Bytes], kind: str, content: bytes) -> None:
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / kind
        path.write_bytes(content)
        if kind == "metadata.yaml":
            (Path(name) / "a.mcap").write_bytes(files["a.mcap"])
            path = Path(name)
        session = refused_or(lambda: read_session(path, Mapping(pretension=60)))
        if isinstance(session, Session):
            assert np.isfinite(session.force.value).all() and (np.diff(session.force.time) > 0).all()
            refused_or(lambda: find_impacts(session, Mapping().contacts, None))


@examples(250)
@given(
    kind=st.sampled_from(KINDS),
    at=st.floats(0, 1),
    near_an_end=st.booleans(),
    cut=st.integers(0, 40),
    put=st.binary(max_size=9) | SIZES,
)
def test_mutated_bytes(files, kind, at, near_an_end, cut, put):
    content = files[kind]
    reach = min(len(content), 1200)
    start = int(at * reach) - (reach if at > 0.4 else 0) if near_an_end else int(at * len(content))
    start %= len(content)
    read_back(files, kind, content[:start] + put + content[start + cut :])


@examples(60)
@given(kind=st.sampled_from(KINDS), content=st.binary(max_size=200) | st.text(max_size=200).map(str.encode))
def test_any_content(files, kind, content):
    read_back(files, kind, content)


@examples(80)
@given(
    rows=st.lists(
        st.lists(st.sampled_from(["", "1", "-2.5", "nan", "1e999", "x", '"', "0,5", " 3", "\0"]), max_size=5),
        max_size=8,
    ),
    separator=st.sampled_from(",;\t"),
)
def test_any_cells(files, rows, separator):
    text = "\n".join(separator.join(row) for row in [["time_s", "force_n", "velocity"], *rows])
    read_back(files, "d.csv", text.encode())


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.dates(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6), inner, max_size=3),
    max_leaves=5,
)
KEYS = st.sampled_from(
    ["force", "velocity", "position", "pretension", "time", "time_scale", "contacts", "cuts", "rig"]
)


@examples(120)
@given(document=st.dictionaries(KEYS | st.text(max_size=5), VALUES, max_size=3) | VALUES)
def test_any_yaml(document):
    with tempfile.TemporaryDirectory() as name:
        path = Path(name, "any.yaml")
        path.write_text(yaml.safe_dump(document, allow_unicode=True), "utf-8")
        refused_or(lambda: read_mapping(path, {}))
        refused_or(lambda: read_review(path, "log.mcap", 10.0))
        refused_or(lambda: read_rig_file(path))


SHAPES = {
    "constant": lambda rng, n: np.full(n, rng.choice([0.0, 1e-9, 100.0, -50.0])),
    "noise": lambda rng, n: rng.normal(0.0, 10.0 ** rng.uniform(-6, 3), n),
    "steps": lambda rng, n: np.repeat(rng.integers(-1, 4, n // 50 + 1) * 60.0, 50)[:n],
    "pulses": lambda rng, n: (
        200.0 * (np.sin(np.arange(n) * rng.uniform(1e-3, 0.5)) > 0.9) + rng.normal(0.0, 1.0, n)
    ),
    "huge": lambda rng, n: rng.normal(0.0, 1e11, n),
}


@examples(80)
@given(
    seed=st.integers(0, 10**6),
    force=st.sampled_from([*SHAPES]),
    speed=st.sampled_from([*SHAPES]),
    is_position=st.booleans(),
)
def test_any_signals(seed, force, speed, is_position):
    rng = np.random.default_rng(seed)
    sizes = rng.choice([1, 2, 30, 500, 5000], 2)
    steps = [rng.choice([1, 10**5, 10**6, 10**9]) * rng.integers(1, 3, size) for size in sizes]
    times = [np.cumsum(step).astype(np.int64) for step in steps]
    with np.errstate(over="ignore"):
        values = [SHAPES[name](rng, size) for name, size in zip((force, speed), sizes, strict=True)]
    signals = [Series(time, value) for time, value in zip(times, values, strict=True)]
    labels = {"force": "f", "speed": "v"}
    session = Session(Path("any"), signals[0], signals[1], is_position, 60.0, labels, ())
    refused_or(lambda: find_impacts(session, Mapping().contacts, None))
