"""Write gap data sets with hidden causes: `python benchmarks/make_cases.py --out DIR --seed 1 --cases 200`.

The same arguments write the same files. A run that was stopped goes on where it was.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # matrices are tiny: threads would only wait for each other

import argparse
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from acf_jax.worlds import find_world, make_case, write_case
from acf_jax.worlds.plan import Order, draw_plan


def write_order(out: Path, answers: Path | None, world: str, numbered: tuple[int, Order]) -> str:
    """Make one case and write it, unless it is there; returns a line that says what was done."""
    number, order = numbered
    folder = out / f"case-{number:03d}"
    answer = answers / f"{folder.name}.yaml" if answers else None
    if (folder / "dataset.yaml").is_file() and (answer or folder / "answer.yaml").is_file():
        return f"{folder}: already there"
    write_case(
        make_case(order.seed, order.effects, None, order.target, world, order.coloured), folder, answer
    )
    return f"{folder}: written"


def main() -> None:
    """Read the arguments, draw the plan and write the cases in parallel."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder for the data sets")
    parser.add_argument("--answers", type=Path, help="folder for the answers, apart from the data sets")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--world", default="scipy")
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    plan = draw_plan(arguments.seed, arguments.cases, find_world(arguments.world))
    write = partial(write_order, arguments.out, arguments.answers, arguments.world)
    with ProcessPoolExecutor(arguments.workers) as pool:
        for line in pool.map(write, enumerate(plan)):
            print(line, flush=True)


if __name__ == "__main__":
    main()
