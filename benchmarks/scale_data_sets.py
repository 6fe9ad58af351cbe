"""What a fleet costs over the number of data sets: time on one and two processes, memory; and Dask's own share.

python -m benchmarks.scale_data_sets --csv docs/figures/scale_data_sets.csv
"""

import argparse
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from benchmarks.child import run_python
from benchmarks.machine import describe, load
from benchmarks.scale import write_csv

SHAPES = ((1, 4), (2, 4), (2, 8), (2, 16))  # processes, data sets
SEEDS = 4  # different data sets; more are copies under other names
PIECES = 10_000


class Cost(NamedTuple):
    """One fleet, its processes started and its programs loaded from a filled cache."""

    workers: int
    data_sets: int
    seconds: float
    megabytes: float  # of the largest of its processes


def draw(folder: Path, count: int) -> None:
    """So many data sets of rigs with dry friction."""
    from validation.worlds import make_case, write_data

    cases = [
        make_case(seed, ["coulomb_friction"], size=0.5, coloured=False) for seed in range(min(SEEDS, count))
    ]
    for i in range(count):
        write_data(cases[i % SEEDS], folder / f"rig-{i:04d}")


def hand_out(pieces: int) -> float:
    """Seconds that Dask takes for a piece of work that is nothing, on two processes."""
    from acf_jax.workers import Where, run_all

    outcomes = run_all(abs, ((i, -i) for i in range(pieces)), Where(workers=2))
    next(outcomes)
    begin = time.perf_counter()
    assert sum(1 for _ in outcomes) == pieces - 1
    return (time.perf_counter() - begin) / (pieces - 1)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.scale_data_sets", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--csv", type=Path, help="write the figures to this file, too")
    parser.add_argument("--child", choices=["draw", "hand_out"], help=argparse.SUPPRESS)
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--count", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.child == "draw":
        draw(options.folder, options.count)
        return
    if options.child == "hand_out":
        print(hand_out(options.count))
        return

    me = ["-m", "benchmarks.scale_data_sets", "--child"]
    with tempfile.TemporaryDirectory() as scratch:
        environment = {"XDG_CACHE_HOME": f"{scratch}/cache"}

        def measure(workers: int, count: int, name: str) -> Cost:
            rigs = f"{scratch}/rigs-{count}"
            if not Path(rigs).exists():
                run_python([*me, "draw", "--folder", rigs, "--count", str(count)], environment)
            command = [
                "-m",
                "acf_jax",
                "fleet",
                rigs,
                "--out",
                f"{scratch}/{name}",
                "--workers",
                str(workers),
            ]
            spent = run_python(command, environment)
            return Cost(workers, count, spent.seconds, spent.megabytes)

        measure(2, SEEDS, "compiled")  # fills the cache of compiled programs
        costs = [measure(*shape, f"out-{shape}") for shape in SHAPES]
        empty = run_python([*me, "hand_out", "--count", str(PIECES)], environment)
    print(f"`fleet` on rigs with dry friction, 20 traces each; {describe()}; {load()}\n")
    print("| processes | data sets | s | s a data set | largest process, MB |")
    print("|--:|--:|--:|--:|--:|")
    for c in costs:
        print(
            f"| {c.workers} | {c.data_sets} | {c.seconds:.0f} | {c.seconds / c.data_sets:.1f} | {c.megabytes:,.0f} |"
        )
    per_piece = 1e3 * float(empty.output.split()[-1])
    print(
        f"\n{PIECES:,} pieces of work that are nothing: {per_piece:.1f} ms each, {empty.megabytes:,.0f} MB."
    )
    write_csv(options.csv, costs)


if __name__ == "__main__":
    main()
