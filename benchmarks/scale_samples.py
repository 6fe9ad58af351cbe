"""What a training run costs over the number of samples: drawing and labelling, a step, peak memory.

python -m benchmarks.scale_samples --csv docs/figures/scale_samples.csv
"""

import argparse
import json
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from benchmarks.child import run_python
from benchmarks.machine import describe, load
from benchmarks.scale import write_csv

SIZES = tuple(2**k for k in (14, 16, 18, 20, 22, 24))
STEPS = 1000


class Cost(NamedTuple):
    """One training run in a process of its own."""

    samples: int
    data_s: float  # drawing and labelling the samples of training, and 2 x 1024 others
    step_ms: float  # the start of training included
    megabytes: float


def measure(samples: int, config: Path, folder: str) -> Cost:
    """Train on so many samples."""
    changes = {
        "output": folder, "compare": "[]", "table1": "null", "samples.train": samples, "samples.held_out": 1024,
        "samples.test": 1024, "optimiser.steps": STEPS, "optimiser.warm_up_steps": 10,
    }  # fmt: skip
    arguments = ["-m", "train.fit", "--config", str(config)]
    for key, value in changes.items():
        arguments += ["--set", f"{key}={value}"]
    spent = run_python(arguments, {})
    timings = json.loads((Path(folder) / "timings.json").read_text("utf-8"))
    return Cost(samples, timings["data_s"], 1e3 * timings["train_fold_s"] / STEPS, spent.megabytes)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.scale_samples", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES, help="numbers of samples")
    parser.add_argument("--config", type=Path, default=Path("configs/wide_box.yaml"))
    parser.add_argument("--csv", type=Path, help="write the figures to this file, too")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        costs = [measure(size, options.config, folder) for size in options.sizes]
    print(f"`fold`, batch 1024, {STEPS} steps; {describe()}; {load()}\n")
    print("| samples | drawing and labelling, s | a step, ms | peak memory, MB |\n|--:|--:|--:|--:|")
    for c in costs:
        print(f"| {c.samples:,} | {c.data_s:.1f} | {c.step_ms:.2f} | {c.megabytes:,.0f} |")
    write_csv(options.csv, costs)


if __name__ == "__main__":
    main()
