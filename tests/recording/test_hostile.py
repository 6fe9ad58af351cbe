"""Recordings made to hang an import or to fill the memory: each is refused before it is read."""

import bz2
import os
import socket
import sqlite3
import struct
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from needs import need_module
from sessions import FEW, made, write_bag

from acf_jax.errors import InputError
from acf_jax.recording import Mapping, read_session
from acf_jax.recording.readers import _bag_bounds, open_recording
from acf_jax.recording.readers._times import Clock, Stamps, find_clocks

SHORT = made(1, FEW[:1], rate=500.0)
MANY = _bag_bounds.MAX_BYTES + 1


def refused(path: Path) -> str:
    """What an import of `path` says, which also a list of its topics would say."""
    with pytest.raises(InputError) as caught:
        read_session(path, Mapping(pretension=60.0))
    return str(caught.value)


def to_pipe(path: Path) -> None:
    os.mkfifo(path)


def to_device(path: Path) -> None:
    path.symlink_to("/dev/zero")


def to_socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(os.path.relpath(path))


@pytest.mark.parametrize("make", [to_pipe, to_device, to_socket])
def test_what_is_no_file_is_not_opened(make: Callable[[Path], None], tmp_path, monkeypatch):
    need_module("rosbags")
    monkeypatch.chdir(tmp_path)
    names = ("x.mcap", "x.db3", "metadata.yaml")
    for name in names:
        bag = tmp_path / name.replace(".", "_")
        bag.mkdir()
        make(bag / name)
        assert refused(bag) == f"{bag / name}: is not an ordinary file; name a file"
    for name in ("x.mcap", "x.bag", "x.db3", "x.csv", "x.npz", "x.npy", "x.parquet"):
        make(tmp_path / name)
        assert refused(tmp_path / name) == f"{tmp_path / name}: is not an ordinary file; name a file"


def test_a_link_to_a_file_is_that_file(tmp_path):
    write_bag(tmp_path / "log", SHORT, "mcap")
    (tmp_path / "there").mkdir()
    (tmp_path / "there/log.mcap").symlink_to(tmp_path / "log/log.mcap")
    assert read_session(tmp_path / "there", Mapping()).force.value.size == SHORT.time.size


def test_a_file_that_a_bag_names_by_another_ending(tmp_path):
    bag = write_bag(tmp_path / "log", SHORT, "mcap")
    (bag / "log.mcap").unlink()
    os.mkfifo(bag / "part")
    text = (bag / "metadata.yaml").read_text()
    (bag / "metadata.yaml").write_text(text.replace("log.mcap", "part"))
    assert "part: is not an ordinary file" in refused(bag)


def test_metadata_that_would_take_for_ever(tmp_path):
    bag = write_bag(tmp_path / "log", SHORT, "mcap")
    sound = (bag / "metadata.yaml").read_text()
    bombs = "\n".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 30))
    (bag / "metadata.yaml").write_text(f"a0: &a0 [x]\n{bombs}\n{sound}")
    assert "aliases (*name) are not known" in refused(bag)
    (bag / "metadata.yaml").write_text(sound + "# " + "x" * _bag_bounds.METADATA_BYTES)
    assert "metadata.yaml: is larger than 2 MB" in refused(bag)
    (bag / "metadata.yaml").write_text(sound.replace("- log.mcap", "- log.mcap\n  - log_1.mcap"))
    assert "log_1.mcap" in (said := refused(bag)) and "missing" in said and "`ros2 bag reindex`" in said


def mcap_of(compression: str, packed: bytes, size: int) -> bytes:
    """An MCAP file without a summary, of one chunk that states `size`."""

    def record(kind: int, content: bytes) -> bytes:
        return bytes([kind]) + struct.pack("<Q", len(content)) + content

    def text(value: str) -> bytes:
        return struct.pack("<I", len(value)) + value.encode()

    chunk = struct.pack("<QQQI", 0, 1, size, 0) + text(compression) + struct.pack("<Q", len(packed)) + packed
    magic = b"\x89MCAP0\r\n"
    head, foot = record(1, text("ros2") + text("")), record(2, struct.pack("<QQI", 0, 0, 0))
    return magic + head + record(6, chunk) + foot + magic


def packed_by(name: str) -> Callable[[bytes], bytes]:
    need_module("rosbags")
    modules = {"zstd": _bag_bounds.zstd(), "lz4": import_module("lz4.frame"), "bz2": bz2}
    return modules[name].compress


@pytest.mark.parametrize("name", ["zstd", "lz4"])
def test_chunks_are_bounded_before_they_are_unpacked(name, tmp_path):
    """By the size that they state, and by the size that they have."""
    bomb = packed_by(name)(bytes(50_000))
    path = tmp_path / "log.mcap"
    path.write_bytes(mcap_of(name, bomb, MANY))
    assert "has a part that unpacks to more than 200 MB" in refused(path)
    path.write_bytes(mcap_of(name, bomb, 100))
    assert "Chunk size mismatch: expected 100 bytes, got 101" in refused(path)
    path.write_bytes(mcap_of(name, bomb[:-8], 50_000))
    assert "cannot be read" in refused(path)
    path.write_bytes(mcap_of("", b"x", 2**62))
    assert "cannot be read" in refused(path)


@pytest.mark.parametrize("name", ["BZ2", "LZ4"])
def test_chunks_of_ros1_bags_are_bounded(name, tmp_path, monkeypatch):
    bag = write_bag(tmp_path / "log.bag", SHORT, "ros1", packed=name)
    assert np.array_equal(read_session(bag, Mapping()).force.value, SHORT.force)
    monkeypatch.setattr(_bag_bounds, "MAX_BYTES", 1000)
    assert "has a part that unpacks to more than" in refused(bag)


@pytest.mark.parametrize("mode", ["MESSAGE", "FILE"])
@pytest.mark.parametrize("kind", ["mcap", "sqlite3"])
def test_packed_bags_are_read_and_bounded(mode, kind, tmp_path, monkeypatch):
    bag = write_bag(tmp_path / "log", SHORT, kind, packed=mode)
    assert np.array_equal(read_session(bag, Mapping()).force.value, SHORT.force)
    monkeypatch.setattr(_bag_bounds, "MAX_BYTES", 50)
    monkeypatch.setattr(_bag_bounds, "SWELL", 1)
    assert "that unpacks to more than" in refused(bag)


def test_many_chunks_of_one_time_are_bounded(tmp_path, monkeypatch):
    bag = write_bag(tmp_path / "log", SHORT, "mcap")
    monkeypatch.setattr(_bag_bounds, "AT_ONCE", 10_000)
    assert "has chunks of one time that unpack to" in refused(bag)


def test_a_database_that_computes_is_refused(tmp_path):
    """A view without end, and a column that is a gigabyte in every row."""
    bag = write_bag(tmp_path / "log", SHORT, "sqlite3")
    changes = (
        "CREATE TABLE kept AS SELECT * FROM message_definitions; DROP TABLE message_definitions;"
        "CREATE VIEW message_definitions AS WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x FROM c) "
        "SELECT * FROM c",
        "ALTER TABLE messages ADD COLUMN more BLOB GENERATED ALWAYS AS (zeroblob(1000000000))",
    )
    sound = (bag / "log.db3").read_bytes()
    for change in changes:
        (bag / "log.db3").write_bytes(sound)
        with sqlite3.connect(bag / "log.db3") as database:
            database.executescript(change)
        database.close()
        assert "computes its tables, which no recorder does" in refused(bag)
        assert "computes its tables" in refused(bag / "log.db3")


def test_a_ros1_bag_whose_first_line_does_not_end(tmp_path):
    need_module("rosbags")
    path = tmp_path / "log.bag"
    with path.open("wb") as file:
        file.truncate(10**11)  # of holes
    assert "is no whole ROS 1 bag" in refused(path)
    with pytest.raises(InputError, match="is no whole ROS 1 bag"):
        open_recording(path)


def test_an_archive_of_thousands_of_arrays(tmp_path: Path) -> None:
    """Its list would be read again for each of them."""
    path = tmp_path / "a.npz"
    np.savez(path, **{f"time{i}": np.arange(3.0) for i in range(1001)})
    with pytest.raises(InputError, match=r"holds 1,001 arrays; keep those that are needed"):
        open_recording(path)


def test_the_time_is_looked_for_in_a_bounded_number_of_columns() -> None:
    """Each is read once, and none where there are too many."""
    read: list[Clock] = []

    def first(clock: Clock) -> Stamps:
        read.append(clock)
        time = np.arange(5) if clock == ("time 7",) else np.zeros(5, np.int64)
        return time, np.ones(5, bool)

    names = [f"time {i}" for i in range(100)]
    assert find_clocks(names, {}, first) == [("time 7",)]
    assert sorted(read) == sorted((name,) for name in names)
    read.clear()
    assert len(find_clocks([f"time {i}" for i in range(300)], {}, first)) == 300 and not read
