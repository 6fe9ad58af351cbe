"""Writes examples/session.mcap, the recording of the documentation: `python -m examples.make_recording`.

Sixteen impacts of the rig of examples/rig, one after the other: the force at 8 kHz, the robot's twist at 125 Hz by a
clock of its own, the pretension at 10 Hz. Contact falls anywhere between two samples.
"""

import shutil
import tempfile
from pathlib import Path

import numpy as np
import yaml
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from validation.worlds import make_case
from validation.worlds.case import find_world
from validation.worlds.interface import Impact
from validation.worlds.writing import RIG_KEYS

HERE = Path(__file__).parent
APART = 0.2  # s, from contact to contact
LATE = 0.15  # s, from the first sample to the first contact
CLOCK = 37.25  # s, by which the robot's clock is ahead of the force sensor's
BEGIN = 1_760_000_000_000_000_000  # ns
ROBOT, SETPOINT = 0.008, 0.1  # s, sampling intervals

store = get_typestore(Stores.ROS2_HUMBLE)


def message(name, **fields):
    return store.types[name](**fields)


def header(nanoseconds, frame):
    stamp = message("builtin_interfaces/msg/Time", sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
    return message("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def vector(z):
    return message("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=float(z))


def impacts(case, rng):
    """Force over the whole session, and (contact, velocity, pretension) of each impact."""
    setup, world = case.setup, find_world(case.world)
    force, contacts = np.zeros(round((16 * APART + LATE) / setup.interval)), []
    for i, label in enumerate(c for c in setup.conditions for _ in range(setup.repeats)):
        true = Impact(*((label.v_e, label.f_p) * (1.0 + setup.spread * rng.standard_normal(2))))
        begin = LATE + APART * i + 0.02 * rng.uniform()
        first = int(np.ceil(begin / setup.interval))
        time = setup.interval * np.arange(first, first + 480) - begin
        sensed = world.respond(setup.rig, list(case.causes.values()), true, time).sensed
        force[first : first + sensed.size] = sensed
        contacts.append((begin, true.v_e, label.f_p))
    force += setup.noise.draw(rng, force.size)
    return setup.interval * np.arange(force.size), np.round(force / setup.quantum) * setup.quantum, contacts


def robot(time, contacts):
    """Its speed: steady until 40 ms after contact, then back."""
    speed = np.zeros(time.size)
    for begin, v_e, _ in contacts:
        speed[(time > begin - 0.1) & (time < begin + 0.04)] = v_e
        speed[(time > begin + 0.05) & (time < begin + 0.12)] = -v_e
    return speed


def main():
    rng = np.random.default_rng(1)
    case = make_case(6, ["end_stop"], size=0.1321629720564765, coloured=False)
    time, force, contacts = impacts(case, rng)
    beats = np.arange(0.0, time[-1], ROBOT)
    speed = robot(beats, contacts) + rng.normal(0.0, 2e-4, beats.size)
    setpoints = np.arange(0.0, time[-1], SETPOINT)
    steps = np.searchsorted([c[0] - 0.13 for c in contacts], setpoints) - 1

    wrench = [
        (t, header(t, "flange"), message("geometry_msgs/msg/Wrench", force=vector(f), torque=vector(0.0)))
        for t, f in zip((BEGIN + np.rint(1e9 * time).astype(int)).tolist(), force, strict=True)
    ]
    twist = [
        (
            t,
            header(t + int(1e9 * CLOCK), "tool"),
            message("geometry_msgs/msg/Twist", linear=vector(v), angular=vector(0.0)),
        )
        for t, v in zip((BEGIN + np.rint(1e9 * beats).astype(int)).tolist(), speed, strict=True)
    ]
    with tempfile.TemporaryDirectory() as name:
        writer = Writer(Path(name) / "session", version=9, storage_plugin=StoragePlugin.MCAP)
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        with writer:
            rows = []
            for topic, kind, key, samples in (
                ("/flange/wrench", "geometry_msgs/msg/WrenchStamped", "wrench", wrench),
                ("/robot/tool_twist", "geometry_msgs/msg/TwistStamped", "twist", twist),
            ):
                connection = writer.add_connection(topic, kind, typestore=store)
                received = [sample[0] for sample in samples] + 100_000 * rng.integers(2, 9, len(samples))
                rows += [
                    (t, connection, kind, message(kind, header=head, **{key: value}))
                    for t, (_, head, value) in zip(
                        np.maximum.accumulate(received).tolist(), samples, strict=True
                    )
                ]
            connection = writer.add_connection("/flange/pretension", "std_msgs/msg/Float64", typestore=store)
            rows += [
                (
                    BEGIN + int(1e9 * t),
                    connection,
                    "std_msgs/msg/Float64",
                    message("std_msgs/msg/Float64", data=contacts[max(i, 0)][2]),
                )
                for t, i in zip(setpoints, steps.tolist(), strict=True)
            ]
            for received, connection, kind, value in sorted(rows, key=lambda row: row[0]):
                writer.write(connection, received, store.serialize_cdr(value, kind))
        shutil.copyfile(Path(name) / "session/session.mcap", HERE / "session.mcap")
    rig = {key: {"value": v, "std": s} for key, (v, s) in zip(RIG_KEYS, case.setup.prior, strict=True)}
    (HERE / "session_rig.yaml").write_text(yaml.safe_dump({"rig": rig}, sort_keys=False))


if __name__ == "__main__":
    main()
