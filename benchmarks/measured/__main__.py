"""The commands `build` and `score` of the benchmark of measured causes."""

import argparse
import sys
from pathlib import Path

from acf_jax.errors import InputError
from benchmarks.measured.answers import read_answers
from benchmarks.measured.recorded import write_set
from benchmarks.measured.rigs import RIGS
from benchmarks.measured.score import score


def build(copies: Path, out: Path) -> None:
    """Write the sets of every rig of whose repository `copies` holds a copy."""
    found = [rig for rig in RIGS if (copies / rig.folder).is_dir()]
    if not found:
        names = ", ".join(dict.fromkeys(rig.folder for rig in RIGS))
        raise InputError(
            [f"{copies} holds none of the repositories {names}; copy at least one of them there"]
        )
    known = read_answers()
    for rig in found:
        for measured in rig.build(copies / rig.folder):
            if measured.name not in known:
                raise InputError([f"{measured.name} has no answer; a set without one cannot be scored"])
            write_set(measured, out / rig.name / measured.name)
            print(f"{rig.name}/{measured.name}: {len(measured.trials)} trials")


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.measured", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser(
        "build", help="write gap data sets from local copies of the public repositories"
    )
    one.add_argument("--from", dest="copies", type=Path, required=True, help="folder with the copies")
    one.add_argument("--out", type=Path, required=True, help="where a folder a rig is written")
    two = commands.add_parser(
        "score", help="diagnose the sets one after the other, and compare with the answers"
    )
    two.add_argument("--sets", type=Path, required=True, help="what `build` wrote")
    two.add_argument("--out", type=Path, help="folder of the diagnoses and the table; default: SETS/results")
    two.add_argument("--only", nargs="*", help="names of rigs or sets; default: all that were built")
    two.add_argument(
        "--told", action="store_true", help="tell the diagnosis what a rig does not have (--without)"
    )
    given = parser.parse_args(arguments)
    try:
        if given.command == "build":
            build(given.copies, given.out)
        else:
            score(given.sets, given.out or given.sets / "results", given.only, given.told)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
