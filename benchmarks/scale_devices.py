"""Training steps over the number of devices and processes, all of them on this one machine.

    python -m benchmarks.scale_devices --csv docs/figures/scale_devices.csv

The devices are forced, threads on the same cores: the curve shows what sharing a step costs, not what devices gain.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from benchmarks.machine import describe, load
from benchmarks.scale import write_csv

SHAPES = ((1, 1), (1, 2), (1, 4), (1, 8), (2, 1), (2, 4))  # processes, devices of each
STEPS, PORT = 1000, 29731


class Speed(NamedTuple):
    """One training run."""

    processes: int
    devices: int  # of each
    batch: int
    steps_per_s: float  # the start of training included
    loss: float


def measure(processes: int, devices: int, batch: int, config: Path) -> Speed:
    """Train on so many processes, started together."""
    with tempfile.TemporaryDirectory() as folder:
        changes = {
            "output": folder, "compare": "[]", "table1": "null", "samples.train": 2**18, "samples.held_out": 1024,
            "samples.test": 1024, "optimiser.steps": STEPS, "optimiser.warm_up_steps": 10, "optimiser.batch": batch,
        }  # fmt: skip
        if processes > 1:
            changes |= {"processes.coordinator": f"127.0.0.1:{PORT}", "processes.count": processes}
        arguments = [sys.executable, "-m", "train.fit", "--config", str(config)]
        for key, value in changes.items():
            arguments += ["--set", f"{key}={value}"]
        environment = os.environ | {"XLA_FLAGS": f"--xla_force_host_platform_device_count={devices}"}
        started = [
            subprocess.Popen(
                arguments + (["--set", f"processes.id={k}"] if processes > 1 else []),
                env=environment,
                stdout=subprocess.DEVNULL,
            )
            for k in range(processes)
        ]
        if any([process.wait() for process in started]):
            raise RuntimeError(f"{processes} processes of {devices} devices failed")
        timings = json.loads((Path(folder) / "timings.json").read_text("utf-8"))
        metrics = json.loads((Path(folder) / "metrics.json").read_text("utf-8"))
    return Speed(processes, devices, batch, STEPS / timings["train_fold_s"], metrics["losses"]["fold"][-1])


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.scale_devices", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--batches", type=int, nargs="+", default=[1024, 65536])
    parser.add_argument("--config", type=Path, default=Path("configs/wide_box.yaml"))
    parser.add_argument("--csv", type=Path, help="write the figures to this file, too")
    options = parser.parse_args(arguments)
    speeds = [measure(*shape, batch, options.config) for batch in options.batches for shape in SHAPES]
    print(f"`fold`, 262,144 samples, {STEPS} steps; {describe()}; {load()}\n")
    print("| processes | devices of each | batch | steps a second | samples a second | loss |")
    print("|--:|--:|--:|--:|--:|--:|")
    for s in speeds:
        per_second = s.steps_per_s * s.batch
        print(
            f"| {s.processes} | {s.devices} | {s.batch:,} | {s.steps_per_s:,.0f} | {per_second:,.0f} | {s.loss:.4e} |"
        )
    write_csv(options.csv, speeds)


if __name__ == "__main__":
    main()
