"""`python -m acf_jax run`: from a recording to allowed speeds, on one page."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._origin import OVERWRITE, foreign_files, origin
from acf_jax.cli._progress import counted, counts, stages
from acf_jax.cli._signals import signal_options
from acf_jax.cli._stale import foreign, of_import
from acf_jax.cli._stop import OPTIONS, ending_options, make_ending
from acf_jax.errors import InputError, TooLittleData, collected
from acf_jax.provenance import FILE

if TYPE_CHECKING:
    from acf_jax.contact.ending import Ending
    from acf_jax.report.run_page import Outcome
    from acf_jax.safety.limits import BodyArea, Limits

EXAMPLES = """
\b
Examples:
  python -m acf_jax run session.mcap --rig rig.yaml --limit 140 --out result
  python -m acf_jax run session.mcap --rig rig.yaml --limit 140 --out result --area palm --stop-after 0.05
"""
DATA, PAGE = "data", "index.html"  # as in acf_jax.pipeline, which is slow to import


@click.command(epilog=EXAMPLES)
@click.argument("recording", type=click.Path(path_type=Path))
@click.option(
    "--rig", required=True, type=click.Path(path_type=Path), help="YAML file: what is known of the rig."
)
@click.option("--limit", required=True, type=float, help="Highest peak contact force, N.")
@click.option(
    "--out", required=True, type=click.Path(path_type=Path), help="Folder for page, data, diagnosis."
)
@signal_options
@click.option(
    "--area", help="Number or name of a body area: may it be clamped at the fastest speed that was tried?"
)
@ending_options
@OVERWRITE
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    recording: Path,
    rig: Path,
    limit: float,
    out: Path,
    area: str | None,
    overwrite: bool,
    as_json: bool,
    **given: Any,
) -> None:
    """From RECORDING to the highest allowed speeds: `import`, `diagnose` and `speed` in one go, with their defaults.

    Asks for the speed at each pretension that was tried, four at most. Writes OUT/index.html, which leads with the
    verdict, and what each command writes: OUT/data and OUT/diagnosis. With --area it adds the `check` of a clamped
    contact (quasi_static); how the contact ends counts there alone.

    Ends with exit code 1 where no data set comes of the recording, where the diagnosis has too little data, where no
    velocity keeps the limit at any pretension, and where the contact is not allowed.
    """
    told = {name: given.pop(name) for name in OPTIONS}
    other, mapping = given.pop("other"), given.pop("mapping")
    faults = _of_folder(out, overwrite)
    limits, areas, ending = _asked(faults, limit, area, told)

    from acf_jax.recording import read_mapping, read_session
    from acf_jax.recording.rig import read_rig_file

    known = collected(faults, lambda: read_rig_file(rig))
    chosen = collected(faults, lambda: read_mapping(mapping, given))
    if faults or known is None or chosen is None:
        raise InputError(faults)
    with counts() as count:
        session = read_session(recording, chosen, partial(count, "reading"), other)

    from acf_jax.start import start_jax

    start_jax()
    from acf_jax import pipeline
    from acf_jax.folders import whole_folder

    question = pipeline.Question(limit, limits, areas, ending)
    made = origin(session.digests())
    with whole_folder(out, pipeline.written(of_import(out / DATA))) as folder:
        outcome = pipeline.run(folder, out, question, session, chosen, known, made, stages, counted)
    if as_json:
        echo_json(_document(outcome, out))
    else:
        click.echo(_text(outcome, out))
    if outcome.stopped:
        raise TooLittleData(outcome.stopped)
    if not outcome.is_allowed:
        raise click.exceptions.Exit(1)


def _of_folder(out: Path, overwrite: bool) -> list[str]:
    """What is wrong with the folder of the results."""
    from acf_jax.folders import recover

    if out.exists() and not out.is_dir():
        return [f"--out {out}: is a file; name a folder"]
    recover(out)
    results = [
        out / PAGE,
        *(out / "diagnosis" / name for name in ("diagnosis.json", "model.json", "report.html", FILE)),
    ]
    return [*foreign(out / DATA, out, overwrite), *foreign_files(results, overwrite)]


def _asked(
    faults: list[str], limit: float, area: str | None, told: dict[str, float | None]
) -> "tuple[Limits, tuple[BodyArea, ...], Ending]":
    """The limits of body areas, the areas that are asked about, and how the contact ends; adds to `faults`."""
    from acf_jax.dataset.units import value_fault
    from acf_jax.safety.limits import read_limits

    faults += filter(None, [value_fault("limit", limit, "--limit")])
    ending, wrong = make_ending(**told)
    faults += wrong
    if area is None:
        alone = [OPTIONS[name] for name, value in told.items() if value is not None]
        faults += [f"{name} belongs to --area; name the area, or remove it" for name in alone]
    limits = read_limits()
    try:
        return limits, limits.find(area) if area is not None else (), ending
    except InputError as error:
        faults += [fault.replace("body area", "--area", 1) for fault in error.faults]
        return limits, (), ending


def _text(run: "Outcome", out: Path) -> str:
    from acf_jax.report import told
    from acf_jax.report.run_page import contact_lines
    from acf_jax.report.speed_text import lines_of

    lines = [*run.found, *(told(run.diagnosis).splitlines() if run.diagnosis else [])]
    lines = list(dict.fromkeys(lines))  # the import and the diagnosis say the same of sound data
    if run.speeds:
        lines += [f"Highest velocity within {run.limit:g} N at the pretensions that were tried:"]
        lines += lines_of("pretension", [(f_p, speeds.found[0]) for f_p, speeds in run.speeds])
        lines += [f"note: {note}" for note in run.notes]
    return "\n".join([*lines, *contact_lines(run), f"{out / PAGE}: open it in a browser"])


def _document(run: "Outcome", out: Path) -> dict[str, Any]:
    from acf_jax.report import check_text, speed_text, words

    d = run.diagnosis
    return {
        "page": str(out / PAGE),
        "recording": run.recording,
        "limit_n": run.limit,
        "stopped": list(run.stopped),
        "verdict": d.verdict if d else None,
        "sentence": words.sentence(d) if d else None,
        "advice": words.advice(d) if d else None,
        "speeds": [{"pretension_n": f_p} | speed_text.document(x.found[0]) for f_p, x in run.speeds],
        "notes": list(run.notes),
        "check": check_text.document(*run.check, alone=True) if run.check else None,
    }
