"""What `diagnose` costs over the number of traces: time and peak memory, each size in a process of its own.

python -m benchmarks.diagnose_cost --csv docs/figures/diagnose_cost.csv && python docs/figures/diagnose_cost.py
"""

import argparse
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from benchmarks.child import run_python
from benchmarks.machine import describe

SIZES = (20, 50, 100, 300, 1000)


class Cost(NamedTuple):
    """One diagnosis, compiled before."""

    trials: int
    seconds: float
    megabytes: float


def diagnose_compiled(trials: int) -> float:
    """Seconds of diagnosing a drawn set, in a process that has diagnosed one: all sizes share programs."""
    from acf_jax.start import start_jax

    start_jax()
    from acf_jax.diagnosis import diagnose
    from benchmarks.drawn_set import draw_set

    diagnose(draw_set(SIZES[0]))
    dataset = draw_set(trials)
    begin = time.perf_counter()
    diagnose(dataset)
    return time.perf_counter() - begin


def measure(trials: int, cache: str) -> Cost:
    """The same in a new process."""
    arguments = ["-m", "benchmarks.diagnose_cost", "--child", str(trials)]
    spent = run_python(arguments, {"XDG_CACHE_HOME": cache})
    return Cost(trials, float(spent.output.split()[-1]), spent.megabytes)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.diagnose_cost", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES, help="numbers of traces")
    parser.add_argument("--csv", type=Path, help="write the figures to this file, too")
    parser.add_argument("--child", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.child:
        print(diagnose_compiled(options.child))
        return
    with tempfile.TemporaryDirectory() as cache:
        costs = [measure(trials, cache) for trials in options.sizes]
    print(f"One rig, ten conditions, more and more repeats; {describe()}\n")
    print("| traces | s | ms a trace | peak memory, MB |\n|--:|--:|--:|--:|")
    for c in costs:
        print(f"| {c.trials:,} | {c.seconds:.1f} | {1e3 * c.seconds / c.trials:.0f} | {c.megabytes:,.0f} |")
    if options.csv:
        rows = [",".join(Cost._fields), *(f"{c.trials},{c.seconds:.3f},{c.megabytes:.0f}" for c in costs)]
        options.csv.write_text("\n".join(rows) + "\n", "utf-8")


if __name__ == "__main__":
    main()
