"""`python -m acf_jax fleet`: diagnose many rigs, and say what changed since last time."""

from collections import Counter
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from acf_jax.cli._ending import resumable
from acf_jax.cli._json import echo_json
from acf_jax.cli._origin import OVERWRITE, foreign_files, origin
from acf_jax.cli._progress import counts
from acf_jax.cli._seed import SEED
from acf_jax.cli._workers import SCHEDULER, WORKERS, say

if TYPE_CHECKING:
    from acf_jax.fleet.record import Fleet

LINES = 20  # changes that are printed

EXAMPLES = """
\b
Examples:
  python -m acf_jax fleet rigs_in_june --out june
  python -m acf_jax fleet rigs_in_july --out july --since june
  python -m acf_jax fleet rigs_in_july --out july --scheduler tcp://host:8786
"""


@click.command(epilog=EXAMPLES)
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder for the results.")
@click.option(
    "--since",
    multiple=True,
    type=click.Path(path_type=Path),
    help="The results of an earlier run, to compare with; several times for several runs, oldest first.",
)
@click.option("--seed", default=0, show_default=True, type=SEED, help="Of the bootstrap intervals.")
@WORKERS
@SCHEDULER
@OVERWRITE
@click.option("--json", "as_json", is_flag=True, help="Print JSON: fleet.json.")
def command(
    folder: Path,
    out: Path,
    since: tuple[Path, ...],
    seed: int,
    workers: int,
    scheduler: str | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Diagnose every data set in the folders of FOLDER, a rig each.

    Writes OUT/RIG/ as `diagnose` does, OUT/fleet.json and OUT/index.html. A run that was stopped goes on where it was;
    a rig whose data are unchanged is not diagnosed again. Ends with exit code 2 where a rig could not be diagnosed.
    """
    from acf_jax.errors import InputError, merged
    from acf_jax.fleet.record import FILE, read_fleets
    from acf_jax.fleet.results import PAGE, write_fleet
    from acf_jax.fleet.run import WRITTEN, run_fleet
    from acf_jax.provenance import FILE as ORIGIN
    from acf_jax.workers import Where

    if out.exists() and not out.is_dir():
        raise InputError(f"--out {out}: is a file; name a folder")
    if any(earlier.resolve() == out.resolve() for earlier in since):
        raise InputError(f"--since {out}: is the folder of --out; name another one for the new results")
    of_rigs = (path for name in WRITTEN for path in sorted(out.glob(f"*/{name}")))
    if faults := foreign_files((out / FILE, out / PAGE, out / ORIGIN, *of_rigs), overwrite):
        raise InputError(faults)
    earlier = read_fleets(since)  # faults are told before anything slow begins

    with resumable("the same command goes on where it was"), counts() as report:
        where = Where(scheduler, workers, say)
        fleet = run_fleet(folder, out, seed, where, partial(report, "diagnosing"))
    made = origin({str(folder / rig.rig): rig.data for rig in fleet.rigs if rig.data})
    fleet = write_fleet(out, fleet, earlier, made)
    if as_json:
        echo_json(fleet.model_dump(mode="json", by_alias=True))
    else:
        click.echo(_in_words(fleet))
        click.echo(f"{out / PAGE}: open it in a browser")
    if faults := merged((str(folder / rig.rig), rig.fault.splitlines()) for rig in fleet.rigs):
        raise InputError(faults)


def _in_words(fleet: "Fleet") -> str:
    """How many rigs have which verdict, what changed, and which rigs are gone."""
    from acf_jax.report.words import listed

    counts = Counter(rig.verdict or "without a diagnosis" for rig in fleet.rigs)
    lines = [", ".join(f"{n} {verdict}" for verdict, n in counts.most_common())]
    for change in fleet.changes[:LINES]:
        sigmas = "" if change.sigmas is None else f"  ({change.sigmas:+.1f} standard deviations)"
        lines.append(f"{change.rig}: {change.what}: {change.before} -> {change.after}{sigmas}")
    if len(fleet.changes) > LINES:
        lines.append(f"and {len(fleet.changes) - LINES} further changes")
    if fleet.since and not fleet.changes:
        lines.append(f"no change beyond what chance explains, compared with {listed(fleet.since)}")
    if fleet.missing:
        lines.append(f"in {fleet.since[-1]}, but not among these data sets: {', '.join(fleet.missing)}")
    return "\n".join(lines)
