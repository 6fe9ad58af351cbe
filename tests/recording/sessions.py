"""Made-up recordings of known impacts, and the same as bags and tables."""

import gzip
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np
from scipy.io import savemat

from acf_jax.recording.series import Series
from tests.dataset.impacts import contact_force
from tests.needs import need_module

RATE, ROBOT, APART = 8000.0, 125.0, 0.4  # Hz, Hz, s
CONDITIONS = tuple((v, p) for p in (60.0, 100.0) for v in (0.05, 0.2, 0.35) for _ in range(2))
FEW = tuple((v, p) for p in (60.0, 100.0) for v in (0.05, 0.2) for _ in range(2))
BEGIN = 1_700_000_000_123_456_789  # ns
RIG = """\
rig:
  moving_mass_kg:             {value: 2.10, std: 0.04}
  damping_n_s_per_m:          {value: 60.0, std: 18.0}
  actuator_stiffness_n_per_m: {value: 800.0, std: 500.0}
  contact_stiffness_n_per_m:  {value: 3.4e5, std: 4.0e4}
"""


@dataclass
class Made:
    """A session: force and robot, each by its own times, ns since BEGIN, and the truth."""

    time: np.ndarray
    force: np.ndarray
    beats: np.ndarray
    velocity: np.ndarray
    position: np.ndarray
    pretension: np.ndarray  # at `beats`
    contacts: list[int]  # ns
    first: list[int]  # index of the first sample in contact
    impacts: list[tuple[float, float]]  # m/s, N
    seconds: np.ndarray = field(init=False)

    def __post_init__(self):
        self.seconds = self.time * 1e-9


@cache
def made(seed=0, conditions=CONDITIONS, std=1.0, offset=0.0, drift=0.0, rate=RATE, bounce=True) -> Made:
    """Approach, impact, contact lost, a bounce, half a tenth of a second of pressing, retreat; again and again.

    `offset`, `drift`: N and N/s of the sensor. Noise of the velocity 0.5 mm/s, of the position 30 um.
    """
    rng = np.random.default_rng(seed)
    time = np.rint(1e9 * np.arange(round((len(conditions) * APART + 0.3) * rate)) / rate).astype(np.int64)
    s = 1e-9 * time
    beats = np.rint(1e9 * np.arange(0.0, s[-1], 1 / ROBOT)).astype(np.int64) + 1_234_567
    b = 1e-9 * beats
    force, velocity = np.zeros(s.size), np.zeros(b.size)
    pretension = np.full(b.size, conditions[0][1])
    contacts, impacts = [], []
    for i, (v, f_p) in enumerate(conditions):
        v_true = v * (1.0 + 0.004 * rng.normal())
        begin = 0.3 + APART * i + rng.uniform(0.0, 0.02)
        force += contact_force(s - begin, v_true, f_p) * (s < begin + 0.02)
        if bounce:
            force += 0.4 * contact_force(s - begin - 0.025, 0.3 * v, 0.0) * (s < begin + 0.04)
        force += f_p * ((s > begin + 0.04) & (s < begin + 0.1))
        velocity[(b > begin - 0.15) & (b < begin + 0.03)] = v_true
        velocity[(b > begin + 0.1) & (b < begin + 0.16)] = -v_true
        pretension[b > begin - 0.2] = f_p
        contacts.append(round(1e9 * begin))
        impacts.append((v_true, f_p))
    force += rng.normal(0.0, std, force.size) + offset + drift * s
    position = np.cumsum(velocity) / ROBOT + rng.normal(0.0, 3e-5, b.size)
    first = [int(np.searchsorted(time, c)) for c in contacts]
    velocity = velocity + rng.normal(0.0, 5e-4, b.size)
    return Made(time, force, beats, velocity, position, pretension, contacts, first, impacts)


def write_csv(
    path: Path, session: Made, separator=",", names=("time_s", "force_n", "velocity_m_per_s", "pretension_n")
):
    """One row a time of either signal, blank where the other is."""
    rows = [(int(t), (repr(float(f)), "", "")) for t, f in zip(session.time, session.force, strict=True)]
    rows += [
        (int(t), ("", repr(float(v)), repr(float(p))))
        for t, v, p in zip(session.beats, session.velocity, session.pretension, strict=True)
    ]
    lines = [separator.join(names)]
    lines += [separator.join((f"{t // 10**9}.{t % 10**9:09d}", *cells)) for t, cells in sorted(rows)]
    if separator == ";":
        lines = [line.replace(".", ",") for line in lines]
    path.write_text("\n".join(lines) + "\n")
    return path


def columns(session: Made) -> dict[str, np.ndarray]:
    """The robot's signals held on the times of the force, as a logger of one rate writes them."""
    held = np.maximum(np.searchsorted(session.beats, session.time, "right") - 1, 0)
    return {
        "time_s": session.seconds,
        "force_n": session.force,
        "velocity_m_per_s": session.velocity[held],
        "pretension_n": session.pretension[held],
    }


def write_bag(
    path: Path,
    session: Made,
    kind: str = "mcap",
    speed: str = "twist",
    robot_clock: float = 0.0,
    robot_drift: float = 0.0,
    stamped: bool = True,
    axis: str = "z",
    frames: Sequence[str] = ("tool",),
    clock: Callable[[int], int] = int,
    packed: str = "",
) -> Path:
    """The session as a bag of `kind` mcap, sqlite3 or ros1; the robot's stamps run `robot_clock` s ahead.

    `frames`: of the messages in turn. `clock`: what the machine's clock shows, ns, so many ns after the beginning.
    `packed`: by zstd, as a whole FILE or each MESSAGE; chunks of ROS 1 by BZ2 or LZ4.
    """
    need_module("rosbags", "pip install 'acf-jax[ros]'")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if kind == "ros1" else Stores.ROS2_HUMBLE)

    def message(type_, /, **fields):
        return store.types[type_](**fields)

    def header(t, i=0):
        sec, nanosec = divmod(t if stamped else 0, 10**9)
        more = {"seq": 0} if kind == "ros1" else {}
        stamp = message("builtin_interfaces/msg/Time", sec=int(sec), nanosec=int(nanosec))
        return message("std_msgs/msg/Header", stamp=stamp, frame_id=frames[i % len(frames)], **more)

    def vector(value, name="Vector3", along="z"):
        parts = dict.fromkeys("xyz", 0.0) | {along: float(value)}
        return message(f"geometry_msgs/msg/{name}", **parts)

    def wrench(t, i):
        w = message(
            "geometry_msgs/msg/Wrench", force=vector(session.force[i], along=axis), torque=vector(0.0)
        )
        return message("geometry_msgs/msg/WrenchStamped", header=header(t, i), wrench=w)

    def twist(t, i):
        both = message("geometry_msgs/msg/Twist", linear=vector(session.velocity[i]), angular=vector(0.0))
        return message("geometry_msgs/msg/TwistStamped", header=header(t), twist=both)

    def pose(t, i):
        still = message("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
        both = message(
            "geometry_msgs/msg/Pose", position=vector(session.position[i], "Point"), orientation=still
        )
        return message("geometry_msgs/msg/PoseStamped", header=header(t), pose=both)

    def joints(t, i):
        both = {
            "velocity": np.array([0.5, session.velocity[i]]),
            "position": np.zeros(2),
            "effort": np.zeros(0),
        }
        return message("sensor_msgs/msg/JointState", header=header(t), name=["turn", "lift"], **both)

    def arm_or_gripper(t, i):
        if i % 3:
            return joints(t, i)
        of_one = {name: np.full(1, 9.0) for name in ("velocity", "position", "effort")}
        return message("sensor_msgs/msg/JointState", header=header(t), name=["gripper"], **of_one)

    def transforms(t, i):
        def of(frame, value):
            still = message("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
            moved = message("geometry_msgs/msg/Transform", translation=vector(value), rotation=still)
            names = {"header": header(t), "child_frame_id": frame}
            return message("geometry_msgs/msg/TransformStamped", **names, transform=moved)

        both = [of("base", 1.0), of("tool0", session.position[i])]
        return message("tf2_msgs/msg/TFMessage", transforms=both if i % 2 else both[::-1])

    def number(t, i):
        return message("std_msgs/msg/Float64", data=float(session.pretension[i]))

    robots = {
        "twist": ("geometry_msgs/msg/TwistStamped", twist),
        "pose": ("geometry_msgs/msg/PoseStamped", pose),
        "joints": ("sensor_msgs/msg/JointState", joints),
        "two_publishers": ("sensor_msgs/msg/JointState", arm_or_gripper),
        "transforms": ("tf2_msgs/msg/TFMessage", transforms),
    }
    name, speak = robots[speed]
    offset = np.rint(1e9 * (robot_clock + robot_drift * 1e-9 * session.beats)).astype(np.int64)
    delay = np.random.default_rng(9).integers(100_000, 120_000, max(session.time.size, session.beats.size))
    topics = [
        ("/ft/wrench", "geometry_msgs/msg/WrenchStamped", wrench, session.time, 0 * session.time),
        ("/robot/state", name, speak, session.beats, offset),
        ("/flange/pretension", "std_msgs/msg/Float64", number, session.beats, 0 * session.beats),
    ]
    serialize = store.serialize_ros1 if kind == "ros1" else store.serialize_cdr
    with _writer(path, kind, packed) as writer:
        rows = []
        for topic, type_, speak, times, ahead in topics:
            connection = writer.add_connection(topic, type_, typestore=store)
            for i, (t, late) in enumerate(zip(times.tolist(), ahead.tolist(), strict=True)):
                now = BEGIN + clock(t)
                rows.append((now + int(delay[i]), connection, type_, speak(now + late, i)))
        for received, connection, type_, value in sorted(rows, key=lambda row: row[0]):
            writer.write(connection, received, serialize(value, type_))
    return path


def _writer(path: Path, kind: str, packed: str):
    if kind == "ros1":
        from rosbags.rosbag1 import Writer as Writer1

        writer1 = Writer1(path)
        if packed:
            writer1.set_compression(Writer1.CompressionFormat[packed])
        return writer1
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.rosbag2.enums import CompressionFormat, CompressionMode

    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    writer = Writer(path, version=9, storage_plugin=plugin)
    if packed:
        writer.set_compression(CompressionMode[packed], CompressionFormat.ZSTD)
    return writer


def as_series(session: Made) -> tuple[Series, Series, Series]:
    """Force, velocity and pretension as a reader gives them."""
    beats = session.beats
    return (
        Series(session.time, session.force),
        Series(beats, session.velocity),
        Series(beats, session.pretension),
    )


@cache
def small(kind: str) -> dict[str, bytes]:
    """The files of a sound recording of one contact."""
    session, table = made(1, FEW[:1], rate=500.0), columns(made(1, FEW[:1], rate=500.0))
    with tempfile.TemporaryDirectory() as name:
        path = Path(name, f"log.{kind}")
        if kind in ("mcap", "db3"):
            path = write_bag(Path(name, "log"), session, "mcap" if kind == "mcap" else "sqlite3")
        elif kind == "bag":
            write_bag(path, session, "ros1", speed="pose")
        elif kind == "csv":
            write_csv(path, session)
        elif kind == "npz":
            np.savez(path, **table)
        elif kind == "npy":
            np.save(path, structured(table))
        elif kind == "csv.gz":
            path.write_bytes(gzip.compress(write_csv(path, session).read_bytes(), mtime=0))
        elif kind == "lvm":
            write_lvm(path, table)
        elif kind == "mat":
            savemat(path, table)
        elif kind == "h5":
            with need_module("h5py", "pip install 'acf-jax[hdf5]'").File(path, "w") as file:
                for name, values in table.items():
                    file.create_dataset(name, data=values, chunks=(64,), compression="gzip")
        elif kind == "tdms":
            write_tdms(path, table)
        elif kind == "xlsx":
            write_xlsx(path, table)
        else:
            arrow = need_module("pyarrow", "pip install 'acf-jax[parquet]'")
            need_module("pyarrow.parquet").write_table(arrow.table(table), path)
        files = path.iterdir() if path.is_dir() else [path]
        return {file.name: file.read_bytes() for file in files}


def write_lvm(path: Path, table: dict[str, np.ndarray]) -> None:
    """Columns as LabVIEW writes them, the first as X_Value."""
    names = ["X_Value", *list(table)[1:], "Comment"]
    ends = "***End_of_Header***\t"
    head = [
        "LabVIEW Measurement\t",
        "Separator\tTab",
        "X_Columns\tOne",
        ends,
        "",
        f"Channels\t{len(table) - 1}",
        ends,
    ]
    lines = [
        "\t".join(map(repr, row)) for row in zip(*(column.tolist() for column in table.values()), strict=True)
    ]
    path.write_text("\n".join([*head, "\t".join(names), *lines]) + "\n")


def write_tdms(path: Path, table: dict[str, np.ndarray]) -> None:
    """Columns as channels of one group."""
    nptdms = need_module("nptdms", "pip install 'acf-jax[tdms]'")
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([nptdms.ChannelObject("log", name, values) for name, values in table.items()])


def write_xlsx(path: Path, table: dict[str, np.ndarray]) -> None:
    """Columns of one sheet."""
    book = need_module("openpyxl", "pip install 'acf-jax[excel]'").Workbook()
    book.active.append(list(table))
    for row in zip(*(column.tolist() for column in table.values()), strict=True):
        book.active.append(row)
    book.save(path)


def structured(table: dict[str, np.ndarray]) -> np.ndarray:
    """Columns as one array of named fields."""
    array = np.empty(len(table["time_s"]), [(name, float) for name in table])
    for name, values in table.items():
        array[name] = values
    return array
