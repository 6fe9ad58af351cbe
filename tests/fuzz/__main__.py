"""Go on damaging and building files where the tests stop: `python -m tests.fuzz --minutes 10`.

Prints a table of what was tried, and every file that a reader did not understand and did not refuse either.
"""

import argparse
import sys
import time
import traceback
import warnings
from dataclasses import dataclass, field

import hypothesis
import jax
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from tests.fuzz.attempt import Hang, attempt
from tests.fuzz.hostile import built
from tests.fuzz.mutate import mutated
from tests.fuzz.readers import READERS, USERS, Reader

ROUND = 20  # files of one reader before the next has its turn


@dataclass
class Tally:
    """What came of one reader's files."""

    understood: int = 0
    refused: int = 0
    longest: float = 0.0  # s
    most: int = 0  # bytes
    failures: list[str] = field(default_factory=list)


def _ends(content: bytes) -> str:
    """The content, or its ends, as Python writes it."""
    whole = repr(content)
    return whole if len(whole) < 20_000 else f"{whole[:2000]} ... {whole[-500:]}"


def one_round(reader: Reader, seed: int, tally: Tally) -> None:
    """`ROUND` files of a reader; a failure ends the round."""
    files = reader.files()

    @hypothesis.seed(seed)
    @settings(
        max_examples=ROUND, deadline=None, database=None, suppress_health_check=list(HealthCheck),
        phases=(Phase.generate,), report_multiple_bugs=False,
    )  # fmt: skip
    @given(data=st.data())
    def tried(data: st.DataObject) -> None:
        wrong = data.draw(st.sampled_from(reader.wrong))
        make = data.draw(st.sampled_from((mutated, built)))
        content = data.draw(make(wrong, files[wrong]))
        changed = {**files, wrong: content}
        try:
            try:
                faults, seconds, memory = attempt(reader, changed)
            except Hang:  # as when JAX compiles what no other file needed; that is kept
                faults, seconds, memory = attempt(reader, changed)
        except BaseException:
            tally.failures.append(
                f"{reader.name}, {wrong}, {len(content):,} bytes: {_ends(content)}\n{traceback.format_exc(limit=-6)}"
            )
            raise
        tally.refused += bool(faults)
        tally.understood += not faults
        tally.longest, tally.most = max(tally.longest, seconds), max(tally.most, memory)

    try:
        tried()
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        print(f"{reader.name}: {error!r}"[:200], file=sys.stderr)


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=10)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    jax.config.update("jax_enable_x64", True)
    end, seed = time.monotonic() + 60 * options.minutes, options.seed
    tallies = {reader: Tally() for reader in (*READERS, *USERS)}
    for reader in tallies:
        attempt(reader, reader.files(), longest=600)  # compiles
    warnings.simplefilter("error")  # as in the tests
    while time.monotonic() < end:
        for reader, tally in tallies.items():
            if time.monotonic() < end:
                one_round(reader, seed, tally)
        seed += 1

    print("| reader | files | understood | refused | longest, s | memory, MB | failures |")
    print("|---|--:|--:|--:|--:|--:|--:|")
    for reader, t in tallies.items():
        tried = t.understood + t.refused + len(t.failures)
        print(
            f"| {reader.name} | {tried} | {t.understood} | {t.refused} | {t.longest:.2f} | {t.most / 1e6:.0f} "
            f"| {len(t.failures)} |"
        )
    failures = [failure for tally in tallies.values() for failure in tally.failures]
    print("\n\n".join(failures), file=sys.stderr)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
