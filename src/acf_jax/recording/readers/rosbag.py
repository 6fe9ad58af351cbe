"""ROS 1 bags and ROS 2 bags (MCAP, sqlite3), through rosbags."""

import re
import sqlite3
import struct
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from acf_jax.errors import InputError, shown, suggestion
from acf_jax.recording.mapping import Mapping as Stated
from acf_jax.recording.mapping import Source
from acf_jax.recording.readers import _bag_bounds
from acf_jax.recording.readers._fields import getter, numbers
from acf_jax.recording.readers._guard import Faults, border, need, some, within
from acf_jax.recording.readers._parts import CHILD, FRAME, JOINT, Wanted
from acf_jax.recording.series import Channel, Growing, Progress, Series

KIND = "a ROS 2 bag (folder, .mcap, .db3) or ROS 1 bag (.bag)"
SUFFIXES = (".mcap", ".db3", ".bag")

# Where a message type keeps the quantity; an axis is added to it.
FORCE = {"geometry_msgs/msg/WrenchStamped": "wrench.force", "geometry_msgs/msg/Wrench": "force"}
VELOCITY = {
    "geometry_msgs/msg/TwistStamped": "twist.linear",
    "geometry_msgs/msg/Twist": "linear",
    "geometry_msgs/msg/TwistWithCovarianceStamped": "twist.twist.linear",
    "nav_msgs/msg/Odometry": "twist.twist.linear",
    "sensor_msgs/msg/JointState": "velocity",
}
POSITION = {
    "geometry_msgs/msg/PoseStamped": "pose.position",
    "geometry_msgs/msg/Pose": "position",
    "geometry_msgs/msg/PoseWithCovarianceStamped": "pose.pose.position",
    "geometry_msgs/msg/PointStamped": "point",
    "geometry_msgs/msg/TransformStamped": "transform.translation",
}
NUMBER = {f"std_msgs/msg/{name}": "data" for name in ("Float64", "Float32", "Int32", "Int64", "UInt16")}
PLACES = FORCE | VELOCITY | POSITION | NUMBER
PRETENSION_NAMES = ("pretension", "preload")
JOINTS = "sensor_msgs/msg/JointState"
TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")

_LINE = 100  # bytes of the first line of a ROS 1 bag, which has 13
_REMEDY = {
    ".mcap": "if it was not closed, `mcap recover` repairs it",
    ".bag": "if it was not closed, `rosbag reindex` repairs it",
}
_REINDEX = "if it was not closed, `ros2 bag reindex` repairs it"


def recognises(path: Path) -> bool:
    """A folder of a ROS 2 bag, or a file of one of the suffixes."""
    if path.is_dir():
        return any(any(path.glob(pattern)) for pattern in ("metadata.yaml", "*.mcap", "*.db3"))
    return path.is_file() and path.suffix.lower() in SUFFIXES


def open_recording(path: Path, stated: Stated) -> "Bag":
    """The bag; messages bring their own times, so what is stated of those of a table is a fault."""
    if named := [key for key in ("time", "time_scale", "sample_rate_hz") if getattr(stated, key) is not None]:
        raise InputError(f"{path}: is a bag, whose messages bring their times; leave {', '.join(named)} out")
    return Bag(path)


class Bag:
    """A bag. Standard message types are those of ROS; any other is taken from its definition in the bag."""

    def __init__(self, path: Path):
        need("rosbags", "ros", f"{path}: reading a bag")
        from rosbags.rosbag1 import Reader as Reader1
        from rosbags.rosbag2 import Reader as Reader2
        from rosbags.typesys import Stores, get_typestore

        self.faults = _faults()
        with border(path, self.faults, _REINDEX):
            self.path = _storage(path)
        self.is_ros1 = self.path.suffix.lower() == ".bag"
        self.store = get_typestore(Stores.ROS1_NOETIC if self.is_ros1 else Stores.ROS2_HUMBLE)
        self.remedy = _REMEDY.get(self.path.suffix.lower(), _REINDEX)
        _bag_bounds.bound_rosbags()
        with border(self.path, self.faults, self.remedy):
            _check_files(self.path)
            self.reader = (Reader1 if self.is_ros1 else Reader2)(self.path)
            self.reader.open()
        try:
            with border(self.path, self.faults, self.remedy):
                self.packed = self._takes_over_unpacking()
                # names and counts are as a metadata.yaml has them, which may be anything
                self.topics = {str(c.topic): str(c.msgtype) for c in self.reader.connections}
                self.counts = {str(name): int(info.msgcount) for name, info in self.reader.topics.items()}
        except InputError:
            self.close()
            raise

    def _takes_over_unpacking(self) -> bool:
        """Refuse chunks that unpack to too much; tell whether messages are packed singly, which rosbags then leaves."""
        if self.is_ros1:
            return False
        storage: Any = self.reader.storage  # type: ignore[union-attr]
        for part in getattr(storage, "storages", [storage]):
            _bag_bounds.check_chunks(getattr(part, "chunks", ()))
        packed = storage.metadata.compression_mode == "message"
        storage.metadata = storage.metadata._replace(compression_mode=None)
        return bool(packed)

    def close(self) -> None:
        """Let go of the file."""
        self.reader.close()

    def channels(self) -> list[Channel]:
        """Its topics."""
        return [Channel(name, type_, self.counts.get(name)) for name, type_ in sorted(self.topics.items())]

    def numbers(self, name: str) -> list[str]:
        """Those of the topic's first message; none of a topic whose messages cannot be read."""
        try:
            self._learn(name)
            first = next(self._messages({name}), None)
        except InputError:
            return []
        return [] if first is None else list(numbers(first[3]))

    def obstacles(self) -> list[str]:
        """Nothing: messages bring their times."""
        return []

    def candidates(self, role: str) -> list[Source]:
        """Topics whose type fits the role; a pretension also has to be called so."""
        kinds: dict[str, str] = {"force": FORCE, "velocity": VELOCITY | POSITION, "pretension": NUMBER}[role]
        found = [
            name for name, type_ in sorted(self.topics.items()) if type_ in kinds and self.counts.get(name)
        ]
        if role == "pretension":
            found = [name for name in found if any(word in name.lower() for word in PRETENSION_NAMES)]
        return [Source(name=name) for name in found]

    def is_position(self, source: Source) -> bool:
        """Whether a topic is a pose, or a field of it a position."""
        words = re.split(r"\W", self._place(source))
        return self.topics.get(source.name) in (*POSITION, *TRANSFORMS) or "position" in words

    def unit(self, source: Source) -> str:
        """None is stated: messages are in SI units."""
        return ""

    def described(self, source: Source) -> str:
        """Topic and field."""
        frame, _ = _frame_and_field(source)
        return f"{source.name}:{'' if frame is None else f'frame_id[{frame}].'}{self._place(source)}"

    def read(self, sources: Mapping[str, Source], progress: Progress) -> dict[str, Series]:
        """The signals in one pass over the messages of their topics."""
        faults = [fault for source in sources.values() if (fault := self._missing(source))]
        if faults:
            raise InputError(faults)
        wanted: dict[str, list[Wanted]] = {}
        for key, source in sources.items():
            wanted.setdefault(source.name, []).append(self._wanted(key, source))
        for topic in wanted:
            self._learn(topic)
        self._check_fields(wanted)
        grown = {key: Growing() for key in sources}
        total = sum(self.counts.get(topic, 0) for topic in wanted)
        for done, (topic, sender, received, message) in enumerate(self._messages(set(wanted))):
            for signal in wanted[topic]:
                for part in signal.parts(message, sender):
                    stamp, samples = _stamp(part), grown[signal.key]
                    samples.value.append(signal.get(part))
                    samples.time.append(received if stamp is None else stamp)
                    if stamp is not None:
                        samples.received.append(received)
            if done % 10_000 == 0:
                progress(done, total)
        for topic, signals in wanted.items():
            faults += [f"{self.path} topic {topic}: {why}" for s in signals if (why := s.fault(topic))]
        if faults:
            raise InputError(list(dict.fromkeys(faults)))
        return {key: self._noted(samples.done(), sources[key]) for key, samples in grown.items()}

    def _check_fields(self, wanted: Mapping[str, list[Wanted]]) -> None:
        """Refuse fields that the first message of their topic lacks, all at once."""
        faults: list[str] = []
        for topic, signals in wanted.items():
            _, sender, _, message = next(self._messages({topic}), (topic, 0, 0, None))
            for signal in signals if message is not None else ():
                try:
                    for part in replace(signal, seen=set(), senders=Counter()).parts(message, sender):
                        signal.get(part)
                except InputError as error:
                    faults += error.faults
        if faults:
            raise InputError(faults)

    def _noted(self, series: Series, source: Source) -> Series:
        """With a word on joints, whose unit depends on their kind."""
        if self.topics[source.name] != JOINTS or "effort" in self._place(source):
            return series
        note = f"{self.described(source)}: a joint's, taken as m or m/s; of a joint that turns it is rad or rad/s"
        return replace(series, notes=(*series.notes, note))

    def _messages(self, topics: set[str]) -> Iterator[tuple[str, int, int, Any]]:
        """Topic, connection, the recorder's time (ns) and message, in the order of that time."""
        connections = [c for c in self.reader.connections if c.topic in topics]
        deserialize = self.store.deserialize_ros1 if self.is_ros1 else self.store.deserialize_cdr
        unpack = _bag_bounds.unpack_message if self.packed else bytes
        raw = self.reader.messages(connections=connections)
        read = (
            (c.topic, int(c.id), int(time), deserialize(unpack(data), c.msgtype)) for c, time, data in raw
        )
        yield from within(read, self.path, self.faults, self.remedy)

    def _learn(self, topic: str) -> None:
        """Add the topic's message type from the bag unless it is one of ROS."""
        name = self.topics[topic]
        if name in self.store.fielddefs:
            return
        from rosbags.interfaces import MessageDefinitionFormat as Format
        from rosbags.typesys import get_types_from_idl, get_types_from_msg

        definition = next(c.msgdef for c in self.reader.connections if c.topic == topic)
        remedy = "record the topic with its message definition, or republish the value as a std_msgs/Float64"
        where = f"{self.path} topic {topic}: message type {shown(name)}"
        if definition.format == Format.NONE:
            raise InputError(f"{where} is not one of ROS and the bag does not define it; {remedy}")
        with border(self.path, self.faults, f"the definition of {shown(name)} is damaged: {remedy}"):
            if definition.format == Format.MSG:
                types = get_types_from_msg(definition.data, name)
            else:
                types = get_types_from_idl(definition.data)
            self.store.register(
                {key: value for key, value in types.items() if key not in self.store.fielddefs}
            )

    def _place(self, source: Source) -> str:
        """The path of the value within the topic's messages."""
        usual = PLACES.get(self.topics.get(source.name, ""), "data")
        _, field = _frame_and_field(source)
        if field in ("x", "y", "z"):
            return f"{usual}.{field}"
        if field is not None:
            return field
        return usual if usual == "data" or self.topics.get(source.name) == JOINTS else f"{usual}.z"

    def _wanted(self, key: str, source: Source) -> Wanted:
        """Which parts of the topic's messages the signal is in, and how it is taken out of one."""
        kind, name, place = "", "", self._place(source)
        if self.topics[source.name] == JOINTS:
            kind, found = "joint", JOINT.fullmatch(place)
            name = found[1] if found else ""
        elif self.topics[source.name] in TRANSFORMS:
            kind, found = "child frame", CHILD.fullmatch(place)
            if found is None:
                raise InputError(
                    f"{self.path} topic {source.name}: holds transforms of many frames; name one by its child frame, as"
                    f" in {source.name}:transforms[tool0].transform.translation.z"
                )
            name, place = found[1], found[2] or "transform.translation.z"
        get = getter(place, f"{self.path} topic {source.name}")
        return Wanted(key, kind, name, _frame_and_field(source)[0], place, get)

    def _missing(self, source: Source) -> str | None:
        if source.time is not None:
            return f"{self.path} topic {source.name}: a topic has no time column; remove 'time'"
        if source.name not in self.topics:
            hint = suggestion(source.name, list(self.topics)) or f"; it has {some(sorted(self.topics))}"
            return f"{self.path}: has no topic {shown(source.name)}{hint}"
        if not self.counts.get(source.name):
            return f"{self.path} topic {source.name}: holds no messages; name another topic, or record again"
        return None


def _storage(path: Path) -> Path:
    """The folder, or its only file where the metadata are missing."""
    if not path.is_dir():
        return path
    _bag_bounds.check_folder(path)
    if (path / "metadata.yaml").exists():
        return path
    files = [file for file in sorted(path.iterdir()) if file.suffix in (".mcap", ".db3")]
    if len(files) > 1:
        raise InputError(f"{path}: has no metadata.yaml; name one of {some(f.name for f in files)}")
    return files[0]


def _check_files(path: Path) -> None:
    """Refuse a bag whose files cannot be opened with bounded memory."""
    for file in path.glob("*.db3") if path.is_dir() else [path]:
        if file.suffix.lower() == ".db3":
            _bag_bounds.check_database(file)
    if path.suffix.lower() == ".bag":
        with path.open("rb") as opened:
            is_cut = not opened.readline(_LINE).endswith(b"\n")  # rosbags reads on until a line ends
        if is_cut:
            raise InputError(f"{path}: is no whole ROS 1 bag; {_REMEDY['.bag']}")


def _frame_and_field(source: Source) -> tuple[str | None, str | None]:
    """The frame whose messages are meant, if it is named, and the rest of the field."""
    found = FRAME.fullmatch(source.field or "")
    return (found[1], found[2]) if found else (None, source.field)


def _stamp(message: Any) -> int | None:
    header = getattr(message, "header", None)
    return None if header is None else int(header.stamp.sec * 10**9 + header.stamp.nanosec)


def _faults() -> Faults:
    """What rosbags, and what it reads with, raise on a file that is not sound."""
    import apsw
    from rosbags.rosbag1 import ReaderError as ReaderError1
    from rosbags.rosbag2 import ReaderError as ReaderError2
    from rosbags.serde import SerdeError
    from rosbags.typesys import TypesysError

    own = (ReaderError1, ReaderError2, SerdeError, TypesysError, apsw.Error, sqlite3.Error)
    packed = (_bag_bounds.zstd().ZstdError, struct.error)
    # Sizes, offsets and names in a damaged file are used before they are checked.
    unchecked = (OSError, EOFError, AssertionError, LookupError, TypeError, ValueError, AttributeError)
    return (*own, *packed, *unchecked, ArithmeticError, RuntimeError, MemoryError)
