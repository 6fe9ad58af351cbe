"""From a command to its answer: help, a peak, and a speed by the model of a diagnosis; against an import of JAX.

A new process each time.

python -m benchmarks.start_up
"""

import argparse
import json
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks.child import Spent, run_python
from benchmarks.machine import describe
from benchmarks.timing import median_ratio, summarise

# The command as the README shows it.
COMMAND = (
    "-m",
    "acf_jax",
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
# By the shipped model of a diagnosis: one explanation.
SPEED = (
    "-m",
    "acf_jax",
    "speed",
    "--model",
    str(Path(__file__).parents[1] / "examples" / "rig_model.json"),
    "--f-p",
    "60",
    "--limit",
    "140",
)
# What they are, their arguments, and whether the cache of compiled code is filled.
KINDS: dict[str, tuple[tuple[str, ...], bool]] = {
    "`import jax`, nothing else": (("-c", "import jax"), True),
    "`--help`": (("-m", "acf_jax", "--help"), True),
    "`peak`, cold: no compilation cache": (COMMAND, False),
    "`peak`, warm: compilation cache filled": (COMMAND, True),
    "`speed` by a diagnosis, cold": (SPEED, False),
    "`speed` by a diagnosis, warm": (SPEED, True),
}


def run(arguments: Sequence[str], cache: Path) -> Spent:
    """One run in a new process, whose compiled code the command keeps in `cache`, as it does by default."""
    return run_python(arguments, {"XDG_CACHE_HOME": str(cache)})


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.start_up", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--repeats", type=int, default=9, help="runs of each kind (default: 9)")
    parser.add_argument("--json", type=Path, help="write the seconds to this file, too")
    options = parser.parse_args(arguments)
    spent: dict[str, list[Spent]] = {name: [] for name in KINDS}
    with tempfile.TemporaryDirectory() as folder:
        for warmed in (COMMAND, SPEED):  # Python's own byte code is there in every kind
            run(warmed, Path(folder) / "warm")
        for i in range(options.repeats):
            for name, (command, is_warm) in KINDS.items():
                spent[name].append(run(command, Path(folder) / ("warm" if is_warm else f"cold{i}")))
    print(f"`python {' '.join(COMMAND)}`, {options.repeats} runs of each, in turn; {describe()}\n")
    print("| | s, median | min … max | s of the cores | × `import jax` |\n|---|--:|--:|--:|--:|")
    (alone, *_) = computing = {name: [one.computing for one in runs] for name, runs in spent.items()}
    for name, runs in spent.items():
        t, own = summarise([one.seconds for one in runs]), computing[name]
        print(
            f"| {name} | {t.median:.2f} | {t.low:.2f} … {t.high:.2f} | {summarise(own).median:.2f} "
            f"| {median_ratio(own, computing[alone]):.2g} |"
        )
    if options.json:
        seconds = {name: [one.seconds for one in runs] for name, runs in spent.items()}
        options.json.write_text(json.dumps(seconds, indent=1))


if __name__ == "__main__":
    main()
