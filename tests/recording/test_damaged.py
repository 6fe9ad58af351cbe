"""Whatever a recording holds, reading it ends in signals or in an `InputError`."""

import sqlite3

import numpy as np
import pytest
from needs import need_module
from sessions import FEW, made, write_bag

from acf_jax.errors import InputError
from acf_jax.recording import Mapping, read_session

SHORT = FEW[:1]


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    """A small bag of each kind, as the bytes of its one file."""
    folder = tmp_path_factory.mktemp("bags")
    session = made(1, SHORT, rate=500.0)
    mcap = write_bag(folder / "a", session, "mcap") / "a.mcap"
    db3 = write_bag(folder / "b", session, "sqlite3") / "b.db3"
    bag = write_bag(folder / "c.bag", session, "ros1")
    return {path.suffix: path.read_bytes() for path in (mcap, db3, bag)}


def read(path) -> str:
    """What an import of `path` says, empty where it can be read."""
    try:
        session = read_session(path, Mapping())
    except InputError as error:
        for fault in error.faults:
            assert len(fault) < 3000 and "Traceback" not in fault
        return str(error)
    assert np.isfinite(session.force.value).all() and (np.diff(session.force.time) > 0).all()
    return ""


@pytest.mark.parametrize(
    "suffix, remedy", [(".mcap", "mcap recover"), (".bag", "rosbag reindex"), (".db3", "reindex")]
)
def test_a_recorder_that_was_killed(bags, tmp_path, suffix, remedy):
    path = tmp_path / f"log{suffix}"
    path.write_bytes(bags[suffix])
    assert read(path) == ""
    for share in (0.0, 0.001, 0.5, 0.98):
        path.write_bytes(bags[suffix][: int(share * len(bags[suffix]))])
        assert remedy in read(path), share


def test_a_bag_without_messages(tmp_path):
    from dataclasses import replace

    empty = np.zeros(0, np.int64)
    session = replace(made(1, SHORT, rate=500.0), time=empty, beats=empty)
    assert "offers" in read(write_bag(tmp_path / "log", session, "mcap"))
    with pytest.raises(InputError, match="holds no messages"):
        read_session(tmp_path / "log", Mapping(force="/ft/wrench", velocity=0.1, pretension=60))


def test_a_folder_without_metadata(bags, tmp_path):
    (tmp_path / "log").mkdir()
    (tmp_path / "log/log_0.mcap").write_bytes(bags[".mcap"])
    assert read(tmp_path / "log") == ""
    (tmp_path / "log/log_1.mcap").write_bytes(bags[".mcap"])
    assert "has no metadata.yaml; name one of 'log_0.mcap', 'log_1.mcap'" in read(tmp_path / "log")


def test_messages_of_unknown_types(bags, tmp_path):
    """One with its definition in the bag can be named by its field; one without cannot."""
    rosbag2 = need_module("rosbags.rosbag2")
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg("float64 preset\nfloat32[3] force", "acf_msgs/msg/State"))
    state = store.types["acf_msgs/msg/State"]
    with rosbag2.Writer(tmp_path / "log", version=9, storage_plugin=rosbag2.StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection("/acf", "acf_msgs/msg/State", typestore=store)
        for i in range(100):
            value = state(preset=60.0, force=np.array([0, 0, i], np.float32))
            writer.write(connection, 10**15 + 10**6 * i, store.serialize_cdr(value, "acf_msgs/msg/State"))
    mapping = Mapping(force="/acf:force[2]", velocity=0.1, pretension="/acf:preset")
    session = read_session(tmp_path / "log", mapping)
    assert session.force.value.tolist() == list(range(100)) and session.pretension.value[0] == 60.0
    with sqlite3.connect(tmp_path / "log/log.db3") as database:
        database.execute("DELETE FROM message_definitions")
    database.close()
    with pytest.raises(
        InputError, match="'acf_msgs/msg/State' is not one of ROS and the bag does not define it"
    ):
        read_session(tmp_path / "log", mapping)


TEXTS = {
    "": "is empty",
    "1,2,3\n4,5,6\n": "first line must name the columns",
    "# a logger\ntime_s,force_n,velocity\n0.1,1,1\n\n0.2,x,1\n": "row 5: force_n is 'x', not a number",
    "time_s,force_n,velocity\n0.1,1\n0.2,1,1,1\n": "row 2: has 2 cells, not 3",
    "time_s,force_n,velocity\n": "holds no samples",
    "time_s,force_n,force_n\n": "'force_n (1)', 'force_n (2)' may all be the force",
    "zett,force_n,velocity\n1,1,1\n": "no column is called a time",
    'time_s,force_n,velocity\n"0.1,1,1\n': "row 2: its quotation marks do not go in pairs",
    "time_s,force_n,velocity\n1e300,1,1\n": "beyond a century",
    "time_s,force_n,velocity\n,1,1\n": "a time is missing",
}


@pytest.mark.parametrize("text", TEXTS, ids=range(len(TEXTS)))
def test_tables_that_are_none(tmp_path, text):
    path = tmp_path / "log.csv"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_session(path, Mapping(pretension=60))
    assert TEXTS[text] in str(caught.value)


def test_arrays_that_are_none(tmp_path):
    mapping = Mapping(force="f", velocity=0.1, pretension=60, time="t")
    path = tmp_path / "log.npz"

    def said() -> str:
        with pytest.raises(InputError) as caught:
            read_session(path, mapping)
        return str(caught.value)

    np.savez(path, t=np.arange(5), f=np.array([{}] * 5, object))
    assert "allow_pickle=False" in said()
    np.savez(path, t=np.arange(5), f=np.zeros(4))
    assert "must be of one dimension and length" in said()
    np.savez(path, t=np.arange(5), f=np.array(list("abcde")))
    assert "holds no numbers" in said()
    path.write_bytes(path.read_bytes()[:100])
    assert "cannot be read" in said()
    path = tmp_path / "log.npy"
    np.save(path, np.zeros((5, 2)))
    assert "without names" in said()
    path = tmp_path / "log.parquet"
    path.write_bytes(b"PAR1 and nothing more")
    need_module("pyarrow")
    assert "cannot be read" in said()
    path = tmp_path / "log.xyz"
    assert "no such file" in said()
    path.write_bytes(b"")
    assert "is no recording known here" in said()
