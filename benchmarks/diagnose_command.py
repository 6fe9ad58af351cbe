"""The command `diagnose` on a drawn set of 20 traces, report included: time and peak memory, cold and warm.

python -m benchmarks.diagnose_command
"""

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks.child import Spent, run_python
from benchmarks.machine import describe
from benchmarks.timing import summarise
from validation.worlds import make_case, write_case

SEED = 21  # draws ten conditions, two trials of each, none of them faulty


def run(dataset: Path, out: Path, cache: Path) -> Spent:
    """One run in a new process whose cache, made as for a user, lies in `cache`."""
    command = ["-m", "acf_jax", "diagnose", str(dataset), "--out", str(out)]
    return run_python(command, {"XDG_CACHE_HOME": str(cache)})


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.diagnose_command", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--cause", default="coulomb_friction", help="the hidden cause of the drawn set")
    parser.add_argument("--repeats", type=int, default=3, help="runs of each kind (default: 3)")
    options = parser.parse_args(arguments)
    spent: dict[str, list[Spent]] = {"cold": [], "warm": []}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        case = make_case(SEED, [options.cause], target=40.0, coloured=False)
        write_case(case, folder / "set")
        for i in range(options.repeats):
            for kind, runs in spent.items():  # the cold run fills the cache of the warm one
                runs.append(run(folder / "set", folder / f"{kind}{i}", folder / f"cache{i}"))
    print(f"{len(case.trials)} traces, {options.repeats} runs of each; {describe()}\n")
    print("| | s, median | min … max | peak memory, MB |\n|---|--:|--:|--:|")
    for kind, meaning in (("cold", "no compilation cache"), ("warm", "compilation cache filled")):
        t = summarise([s.seconds for s in spent[kind]])
        largest = max(s.megabytes for s in spent[kind])
        print(f"| {kind}: {meaning} | {t.median:.1f} | {t.low:.1f} … {t.high:.1f} | {largest:,.0f} |")


if __name__ == "__main__":
    main()
