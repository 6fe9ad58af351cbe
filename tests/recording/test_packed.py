"""Small files that would fill the memory are refused before they are unpacked."""

import gzip
import re
import tracemalloc
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from needs import need_module
from scipy.io import savemat

from acf_jax.errors import InputError
from acf_jax.recording.mapping import Source
from acf_jax.recording.readers import _bounds, open_recording
from tests.recording import sessions

MANY = 100_000


@pytest.fixture(autouse=True)
def low_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_bounds, "_ROWS", 1000)
    monkeypatch.setattr(_bounds, "_BYTES", 100_000)


def refused(path: Path) -> str:
    """What is said of a file; a tenth of what it would unpack to suffices."""
    with pytest.raises(InputError) as caught:
        recording = open_recording(path)
        recording.read({"force": Source(name="force")}, lambda *_: None)
    return str(caught.value)


def zeros() -> dict[str, np.ndarray]:
    return {"time": np.zeros(MANY), "force": np.zeros(MANY)}


def as_gz(path: Path) -> None:
    path.write_bytes(gzip.compress(b"time,force\n" + b"0,0\n" * MANY))


def as_npz(path: Path) -> None:
    np.savez_compressed(path, **zeros())


def as_parquet(path: Path) -> None:
    arrow = need_module("pyarrow", "pip install 'acf-jax[parquet]'")
    need_module("pyarrow.parquet").write_table(arrow.table(zeros()), path)


def as_hdf5(path: Path) -> None:
    """A claim alone: nothing is stored."""
    with need_module("h5py", "pip install 'acf-jax[hdf5]'").File(path, "w") as file:
        for name in zeros():
            file.create_dataset(name, (10**12,), "f8", chunks=(1000,))


@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("a.csv.gz", as_gz),
        ("a.npz", as_npz),
        ("a.parquet", as_parquet),
        ("a.h5", as_hdf5),
    ],
)
def test_more_rows_than_bytes(name: str, write: Callable[[Path], None], tmp_path: Path) -> None:
    write(tmp_path / name)
    assert re.search(
        r"says to hold \S+ values of a signal in [\d,]+ bytes; it is damaged", refused(tmp_path / name)
    )


def long_lines(path: Path) -> None:
    path.write_bytes(gzip.compress(b"time,force\n0,0\n" + (b" " * 10_000 + b"\n") * 1000))


def one_matrix(path: Path) -> None:
    savemat(
        path,
        {"time": np.zeros(20), "force": np.zeros(20), "other": np.zeros((MANY, 20))},
        do_compression=True,
    )


def a_large_part(path: Path) -> None:
    sessions.write_xlsx(path, {"time": np.arange(50.0), "force": np.arange(50.0) % 3})
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as file:
        file.writestr("xl/sharedStrings.xml", b"<sst>" + b" " * 10**7 + b"</sst>")


def wide_chunks(path: Path) -> None:
    with need_module("h5py", "pip install 'acf-jax[hdf5]'").File(path, "w") as file:
        file["time"] = np.arange(100.0)
        file.create_dataset("force", (100,), "f8", chunks=(10**8,), maxshape=(None,))


@pytest.mark.parametrize(
    ("name", "write"),
    [("a.csv.gz", long_lines), ("a.mat", one_matrix), ("a.xlsx", a_large_part), ("a.h5", wide_chunks)],
)
def test_more_bytes_than_belong_into_a_file(name: str, write: Callable[[Path], None], tmp_path: Path) -> None:
    write(tmp_path / name)
    assert re.search(
        r"[\d,]+ bytes unpack to \S+ or more; it is damaged or no recording", refused(tmp_path / name)
    )


def test_a_chunk_that_unpacks_to_more_than_it_says(tmp_path: Path) -> None:
    h5py = need_module("h5py", "pip install 'acf-jax[hdf5]'")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["time"] = np.arange(100.0)
        data = file.create_dataset("force", (100,), "f8", chunks=(100,), compression="gzip")
        data.id.write_direct_chunk((0,), zlib.compress(bytes(300_000_000), 9))
    tracemalloc.start()
    try:
        assert "a chunk of /force unpacks to more than it is said to hold" in refused(tmp_path / "a.h5")
        assert tracemalloc.get_traced_memory()[1] < 10_000_000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("begins", "says"),
    [("", "holds no text"), ("5" * 3_000_000, "is longer than 1,000,000 characters; save it as text")],
)
def test_a_line_without_end(begins: str, says: str, tmp_path: Path) -> None:
    """Refused when its first megabyte is read."""
    path = tmp_path / "a.csv"
    path.write_text("time_s,force\n" + begins)
    with path.open("r+b") as file:
        file.truncate(3 << 30)
    tracemalloc.start()
    try:
        assert says in refused(path)
        assert tracemalloc.get_traced_memory()[1] < 50_000_000
    finally:
        tracemalloc.stop()


def test_rows_far_below_the_others(tmp_path: Path) -> None:
    """A sheet ends where a block of its rows is empty; rows of zeros are not."""
    path = tmp_path / "a.xlsx"
    sessions.write_xlsx(path, {"time": np.arange(50.0), "force": np.zeros(50)})
    with zipfile.ZipFile(path) as file:
        parts = {name: file.read(name) for name in file.namelist()}
    sheet = re.sub(rb"<dimension[^>]*>", b"", parts["xl/worksheets/sheet1.xml"])
    parts["xl/worksheets/sheet1.xml"] = sheet.replace(b'r="51"', b'r="4000000000"')
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in parts.items():
            file.writestr(name, content)
    series = open_recording(path).read({"force": Source(name="force")}, lambda *_: None)["force"]
    assert np.array_equal(series.value, np.zeros(49))


def test_columns_without_end(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(
        "\n".join([",".join(f"c{i}" for i in range(20_000)), ",".join("0" * 20_000)])
    )
    assert "holds 20,000 columns; keep those that are needed" in refused(tmp_path / "a.csv")
