"""Importing long recordings: time and peak memory over size, for a bag with a camera, a bag of force alone and a CSV.

python -m benchmarks.import_memory
"""

import argparse
import struct
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from benchmarks.child import run_python
from benchmarks.machine import describe

BEGIN = 1_700_000_000  # s
RATE, PERIOD, ROBOT = 8000, 4, 125  # Hz of the force, s from contact to contact, Hz of the robot
FRAME = 640 * 480 * 3  # bytes of an image
STORE = get_typestore(Stores.ROS2_HUMBLE)
WRENCH, TWIST, IMAGE = (
    "geometry_msgs/msg/WrenchStamped",
    "geometry_msgs/msg/TwistStamped",
    "sensor_msgs/msg/Image",
)


def one_period() -> np.ndarray:
    """Force over the time from one contact to the next: approach, half a sine, nothing."""
    time = np.arange(PERIOD * RATE) / RATE - 2.0
    pulse = np.where((time >= 0.0) & (time < 0.012), 60.0 + 140.0 * np.sin(np.pi * time / 0.012), 0.0)
    return pulse + np.random.default_rng(0).normal(0.0, 1.0, time.size)


def message(type_: str, /, **fields: Any) -> Any:
    """A message of a type."""
    return STORE.types[type_](**fields)


def serialized(type_: str, **fields: Any) -> bytearray:
    """A stamped message whose stamp is at bytes 4 to 12."""
    stamp = message("builtin_interfaces/msg/Time", sec=0, nanosec=0)
    header = message("std_msgs/msg/Header", stamp=stamp, frame_id="tool")
    return bytearray(STORE.serialize_cdr(message(type_, header=header, **fields), type_))


def write_bag(path: Path, gigabytes: float, camera: bool) -> None:
    """A bag of about that size: contacts every few seconds, and images in between if there is a camera."""

    def vector(z: float = 0.0) -> Any:
        return message("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=z)

    def both(name: str, first: str, second: str) -> Any:
        return message(f"geometry_msgs/msg/{name}", **{first: vector(0.2), second: vector()})

    wrench = serialized(WRENCH, wrench=both("Wrench", "force", "torque"))
    twist = serialized(TWIST, twist=both("Twist", "linear", "angular"))
    pixels = np.random.default_rng(1).integers(0, 255, FRAME, np.uint8)
    size = {"height": 480, "width": 640, "encoding": "rgb8", "is_bigendian": 0, "step": 1920, "data": pixels}
    image = serialized(IMAGE, **size) if camera else bytearray()
    place = wrench.index(struct.pack("<d", 0.2))
    force = one_period()
    second = RATE * (len(wrench) + 31) + ROBOT * (len(twist) + 31)
    frames = 0 if not camera else 30
    seconds = int(gigabytes * 1e9 / (second + frames * (len(image) + 31)))
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics = {
            name: writer.add_connection(f"/{name}", type_, typestore=STORE)
            for name, type_ in (("wrench", WRENCH), ("twist", TWIST), ("image", IMAGE))
        }
        for i in range(max(seconds, 4 * PERIOD) * RATE):
            sec, nano = BEGIN + i // RATE, (i % RATE) * (10**9 // RATE)
            now = sec * 10**9 + nano
            struct.pack_into("<iI", wrench, 4, sec, nano)
            struct.pack_into("<d", wrench, place, force[i % force.size])
            writer.write(topics["wrench"], now, bytes(wrench))
            if i % (RATE // ROBOT) == 0:
                struct.pack_into("<iI", twist, 4, sec, nano)
                writer.write(topics["twist"], now, bytes(twist))
            if frames and i % (RATE // frames) == 0:
                writer.write(topics["image"], now, bytes(image))


def write_csv(path: Path, gigabytes: float) -> None:
    """A table of about that size."""
    lines = [f"{f:.4f},0.2" for f in one_period().tolist()]
    count = int(gigabytes * 1e9 / 25)
    with path.open("w") as file:
        file.write("time_s,force_n,velocity\n")
        for first in range(0, count, len(lines)):
            file.writelines(f"{(first + i) / RATE:.6f},{line}\n" for i, line in enumerate(lines))


def cases(folder: Path, gigabytes: Sequence[float]) -> Iterator[tuple[str, Path]]:
    """Name and recording of each case, written when it is its turn."""
    for size in gigabytes:
        path = folder / f"camera_{size:g}"
        write_bag(path, size, camera=True)
        yield "bag, force at 8 kHz and a camera", path
    for size in gigabytes:
        path = folder / f"force_{size:g}"
        write_bag(path, size / 8, camera=False)
        yield "bag, force at 8 kHz alone", path
    for size in gigabytes:
        path = folder / f"table_{size:g}.csv"
        write_csv(path, size / 8)
        yield "CSV, force and speed at 8 kHz", path


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.import_memory", description=__doc__.splitlines()[0]
    )
    parser.add_argument(
        "--gigabytes", type=float, nargs="+", default=[0.2, 2.0], help="sizes of the bag with a camera"
    )
    options = parser.parse_args(arguments)
    print(f"{describe()}\n")
    print("| | GB | minutes recorded | force samples, 1e6 | contacts | s | peak memory, MB |")
    print("|---|--:|--:|--:|--:|--:|--:|")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for kind, path in cases(folder, options.gigabytes):
            files = sorted(path.iterdir()) if path.is_dir() else [path]
            size = sum(file.stat().st_size for file in files) / 1e9
            command = [
                "-m",
                "acf_jax",
                "import",
                str(path),
                "--out",
                str(folder / "out"),
                "--pretension",
                "60",
            ]
            spent = run_python(command, {})
            contacts, seconds = spent.output.split()[0], float(spent.output.split()[3])
            print(
                f"| {kind} | {size:.2f} | {seconds / 60:.1f} | {seconds * RATE / 1e6:.2f} | {contacts} |"
                f" {spent.seconds:.0f} | {spent.megabytes:,.0f} |",
                flush=True,
            )
            for file in files:
                file.unlink()


if __name__ == "__main__":
    main()
