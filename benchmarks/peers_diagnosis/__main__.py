"""Compare our diagnosis with other methods on scored blind runs.

    python -m benchmarks.peers_diagnosis compare RUN [RUN ...] [--measured SETS RESULTS] [--train FILE]
    python -m benchmarks.peers_diagnosis draw FILE --rigs 3000

`RUN` is what `python -m acf_jax blind --out RUN` left; SETS what `python -m benchmarks.measured build --out SETS`
wrote, and RESULTS what its `score` did. The classifier takes part where FILE holds its training sets, which `draw`
writes. Needs `pip install ".[peers]"`.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from acf_jax.errors import InputError
from benchmarks.peers_diagnosis.cases import Case, Named, read_measured, read_run

Method = Callable[[Case], Named]
PEERS = ("AICc", "BIC", "SINDy", "classifier")


def main(arguments: Sequence[str] | None = None) -> int:
    """Read the command, and do it; the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.peers_diagnosis",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser("compare", help="score every method on the same data sets")
    one.add_argument("runs", nargs="*", type=Path, metavar="RUN")
    one.add_argument("--measured", nargs=2, type=Path, metavar=("SETS", "RESULTS"))
    one.add_argument("--train", type=Path, help="training sets of the classifier")
    one.add_argument("--only", nargs="+", choices=PEERS, default=PEERS, help="default: all")
    two = commands.add_parser("draw", help="draw training sets of the classifier")
    two.add_argument("file", type=Path, help="ends with .npz")
    two.add_argument("--rigs", type=int, default=3000, help="up to ten sets each")
    two.add_argument("--seed", type=int, default=47000)
    given = parser.parse_args(arguments)
    try:
        from acf_jax.start import start_jax

        start_jax()
        if given.command == "draw":
            from benchmarks.peers_diagnosis.training_sets import keep

            print(f"{keep(given.file, given.seed, given.rigs)} sets")
        else:
            compare(given.runs, given.measured, given.train, given.only)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except ModuleNotFoundError as error:
        print(f'error: {error.name} is missing; run `pip install ".[peers]"`', file=sys.stderr)
        return 2
    return 0


def compare(
    runs: Sequence[Path], measured: Sequence[Path] | None, train: Path | None, only: Sequence[str]
) -> None:
    """Print one line a data set, then the table."""
    from benchmarks.peers_diagnosis.judge import judge
    from benchmarks.peers_diagnosis.table import OURS, lines, table

    cases = [case for run in runs for case in read_run(run)]
    if measured:
        sets, results = measured
        cases += read_measured(sets, results)
    if not cases:
        raise InputError("nothing to compare: name a RUN, or --measured SETS RESULTS")
    methods: dict[str, Method] = {OURS: lambda case: case.ours, **_peers(train, only)}
    said = {}
    for name, method in methods.items():
        said[name] = [method(case) for case in cases]
        print(f"{name}: {len(cases)} sets", file=sys.stderr, flush=True)
    outcomes = {
        name: [judge(case, one) for case, one in zip(cases, found, strict=True)]
        for name, found in said.items()
    }
    words = {
        name: [f"{'+'.join(n.scored[0][0]) or 'none'} {n.scored[0][1]:.2f}" for n in found]
        for name, found in said.items()
    }
    print(lines(cases, outcomes, words))
    print(table(cases, outcomes))


def _peers(train: Path | None, only: Sequence[str]) -> dict[str, Method]:
    peers: dict[str, Method] = {}
    if "AICc" in only or "BIC" in only:
        from benchmarks.peers_diagnosis.criteria import CRITERIA, select

        peers |= {name: partial(select, name=name) for name in CRITERIA if name in only}
    if "SINDy" in only:
        from benchmarks.peers_diagnosis.sindy import identify

        peers["SINDy"] = identify
    if "classifier" in only and not train:
        print("no classifier: name its training sets by --train", file=sys.stderr)
    elif "classifier" in only and train:
        from benchmarks.peers_diagnosis import classifier

        trained = classifier.train(*classifier.load(train))
        peers["classifier"] = partial(classifier.classify, trained=trained)
    return peers


if __name__ == "__main__":
    sys.exit(main())
