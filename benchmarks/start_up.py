"""From `python -m acf_jax peak` to its answer: a new process each time, with and without a compilation cache.

python -m benchmarks.start_up
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.machine import describe
from benchmarks.timing import summarise

# The command as the README shows it.
COMMAND = (
    "peak",
    "--m",
    "2.0",
    "--d",
    "40",
    "--k-f",
    "2000",
    "--k-c",
    "350000",
    "--v-e",
    "0.2",
    "--f-p",
    "100",
)


def run(cache: Path) -> float:
    """Seconds of one run in a new process whose caches all lie in `cache`."""
    # Whatever cache the command uses lies in one of these.
    environment = os.environ | {"XDG_CACHE_HOME": str(cache), "JAX_COMPILATION_CACHE_DIR": str(cache / "jax")}
    start = time.perf_counter()
    subprocess.run(
        [sys.executable, "-m", "acf_jax", *COMMAND], check=True, env=environment, capture_output=True
    )
    return time.perf_counter() - start


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.start_up", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--repeats", type=int, default=9, help="runs of each kind (default: 9)")
    parser.add_argument("--json", type=Path, help="write the seconds to this file, too")
    options = parser.parse_args(arguments)
    seconds: dict[str, list[float]] = {"cold": [], "warm": []}
    with tempfile.TemporaryDirectory() as folder:
        run(Path(folder) / "warm")  # Python's own byte code is there in both kinds
        for i in range(options.repeats):
            seconds["cold"].append(run(Path(folder) / f"cold{i}"))
            seconds["warm"].append(run(Path(folder) / "warm"))
    print(f"`python -m acf_jax {' '.join(COMMAND)}`, {options.repeats} runs of each; {describe()}\n")
    print("| | s, median | min … max |\n|---|--:|--:|")
    for kind, meaning in (("cold", "no compilation cache"), ("warm", "compilation cache filled")):
        t = summarise(seconds[kind])
        print(f"| {kind}: {meaning} | {t.median:.2f} | {t.low:.2f} … {t.high:.2f} |")
    if options.json:
        options.json.write_text(json.dumps(seconds, indent=1))


if __name__ == "__main__":
    main()
