"""`python -m acf_jax run`: from a recording to allowed speeds, on one page."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._progress import counted, counts, stages
from acf_jax.cli._signals import signal_options
from acf_jax.cli._stale import CUTS, REFUSED, foreign, traces_of
from acf_jax.cli._stop import OPTIONS, ending_options, make_ending
from acf_jax.errors import InputError, TooLittleData, collected

if TYPE_CHECKING:
    from acf_jax.contact.ending import Ending
    from acf_jax.contact.model import ContactModel
    from acf_jax.dataset import GapDataset
    from acf_jax.designs.speed import Speeds
    from acf_jax.inference.observations import Observations
    from acf_jax.recording import Impacts, Mapping, Session
    from acf_jax.recording.rig import RigFile
    from acf_jax.report.run_page import Outcome
    from acf_jax.safety.check import Answer, Checker
    from acf_jax.safety.limits import BodyArea, Limits

EXAMPLES = """
\b
Examples:
  python -m acf_jax run session.mcap --rig rig.yaml --limit 140 --out result
  python -m acf_jax run session.mcap --rig rig.yaml --limit 140 --out result --area palm --stop-after 0.05
"""
DATA, DIAGNOSIS, PAGE = "data", "diagnosis", "index.html"  # in the run's folder
LEVELS = 4  # pretensions that are asked for at most


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
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    recording: Path,
    rig: Path,
    limit: float,
    out: Path,
    area: str | None,
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
    asked, known, chosen = _asked(out, rig, limit, area, told, mapping, given)

    from acf_jax.recording import read_session

    with counts() as count:
        session = read_session(recording, chosen, partial(count, "reading"), other)

    from acf_jax.start import start_jax

    start_jax()
    from acf_jax.files import write_text
    from acf_jax.folders import whole_folder
    from acf_jax.report.run_page import run_page

    with whole_folder(out, _earlier(out)) as folder:
        run = _follow(folder, out, asked, session, chosen, known)
        write_text(folder / PAGE, run_page(run))
    if as_json:
        echo_json(_document(run, out))
    else:
        click.echo(_text(run, out))
    if run.stopped:
        raise TooLittleData(run.stopped)
    if not run.is_allowed:
        raise click.exceptions.Exit(1)


class _Asked(NamedTuple):
    """The question, looked at."""

    limit: float  # N
    limits: "Limits"
    areas: "tuple[BodyArea, ...]"  # none: no check is asked for
    ending: "Ending"


def _asked(
    out: Path,
    rig: Path,
    limit: float,
    area: str | None,
    told: dict[str, float | None],
    mapping: Path | None,
    signals: dict[str, Any],
) -> "tuple[_Asked, RigFile, Mapping]":
    """Question, rig and signals; `InputError` with the faults of all of them."""
    from acf_jax.dataset.units import value_fault
    from acf_jax.folders import recover
    from acf_jax.recording import read_mapping
    from acf_jax.recording.rig import read_rig_file
    from acf_jax.safety.limits import read_limits

    recover(out)
    faults = list(filter(None, [value_fault("limit", limit, "--limit")]))
    if out.exists() and not out.is_dir():
        faults.append(f"--out {out}: is a file; name a folder")
    faults += foreign(out / DATA, out)
    ending, wrong = make_ending(**told)
    faults += wrong
    if area is None:
        alone = [OPTIONS[name] for name, value in told.items() if value is not None]
        faults += [f"{name} belongs to --area; name the area, or remove it" for name in alone]
    limits = read_limits()
    areas: tuple[BodyArea, ...] = ()
    try:
        areas = limits.find(area) if area is not None else ()
    except InputError as error:
        faults += [fault.replace("body area", "--area", 1) for fault in error.faults]
    known = collected(faults, lambda: read_rig_file(rig))
    chosen = collected(faults, lambda: read_mapping(mapping, signals))
    if faults or known is None or chosen is None:
        raise InputError(faults)
    return _Asked(limit, limits, areas, ending), known, chosen


def _follow(
    folder: Path, out: Path, asked: _Asked, session: "Session", chosen: "Mapping", known: "RigFile"
) -> "Outcome":
    """One step after the other, as far as they lead; their files in `folder`, which will be `out`."""
    from acf_jax.contact.read import of_diagnosis
    from acf_jax.diagnosis import diagnose
    from acf_jax.diagnosis.results import gap_model
    from acf_jax.recording.words import found
    from acf_jax.report import save_diagnosis
    from acf_jax.report.run_page import Outcome

    impacts, data = _import(folder / DATA, out / DATA, session, chosen, known)
    run = Outcome(session.path.name, asked.limit, found(impacts), impacts.faults)
    if data is None:
        return run
    with stages() as progress:
        try:
            diagnosis = diagnose(data, progress=progress)
        except InputError as error:  # too few trials that can be used
            return run._replace(stopped=error.faults)
        progress("writing the report")
        save_diagnosis(folder / DIAGNOSIS, diagnosis)
    run = run._replace(diagnosis=diagnosis)
    model = of_diagnosis(gap_model(diagnosis), source=str(out / DIAGNOSIS / "model.json"))
    try:
        model.check_carried()
    except TooLittleData as refusal:
        return run._replace(stopped=refusal.faults)
    run = run._replace(speeds=_speeds(model, asked, diagnosis.observations))
    return run._replace(check=_check(model, asked, diagnosis.observations)) if asked.areas else run


def _import(
    folder: Path, name: Path, session: "Session", chosen: "Mapping", known: "RigFile"
) -> "tuple[Impacts, GapDataset | None]":
    """The impacts, and the data set that came of them; `name`: what its page calls its folder."""
    from acf_jax.files import write_text
    from acf_jax.folders import whole_folder
    from acf_jax.recording import Refused, find_impacts
    from acf_jax.recording.page import import_page
    from acf_jax.recording.write import write_impacts

    try:
        impacts = find_impacts(session, chosen.contacts, known.prior)
        with whole_folder(folder) as scratch:
            data = write_impacts(scratch, impacts, known)
            write_text(scratch / CUTS, import_page(impacts, None, str(name)))
    except Refused as refusal:
        write_text(folder / CUTS, import_page(refusal.impacts, None, str(name)))
        return refusal.impacts, None
    assert data is not None  # a rig was given
    return impacts, replace(data, folder=name)


def _speeds(
    model: "ContactModel", asked: _Asked, tried: "Observations"
) -> "tuple[tuple[float, Speeds], ...]":
    """The answers at pretensions that were tried: all, or four from the lowest to the highest."""
    import numpy as np

    from acf_jax.designs.asked import Asked
    from acf_jax.designs.speed import find_speeds

    levels = np.unique(tried.f_p)
    if levels.size > LEVELS:
        levels = levels[np.linspace(0, levels.size - 1, LEVELS).round().astype(int)]
    return tuple(
        (f_p, find_speeds(model, Asked(f_p, (asked.limit,)))) for f_p in counted(levels.tolist(), "speeds")
    )


def _check(model: "ContactModel", asked: _Asked, tried: "Observations") -> "tuple[Answer, Checker, Limits]":
    """The clamped contact at the fastest speed that was tried, with the highest pretension that was tried with it."""
    from acf_jax.safety.check import Checker
    from acf_jax.safety.situation import Situation

    v_e, f_p = max(zip(tried.v_e.tolist(), tried.f_p.tolist(), strict=True))
    checker = Checker(model, None)
    return (
        checker(Situation("", asked.areas, "quasi_static", v_e, f_p, ending=asked.ending)),
        checker,
        asked.limits,
    )


def _earlier(out: Path) -> list[str]:
    """The files of an earlier run."""
    data = ["dataset.yaml", "trials.csv", CUTS, REFUSED, *traces_of(out / DATA / "trials.csv", "contact_s")]
    found = ("diagnosis.json", "model.json", "report.html")
    return [PAGE, *(f"{DATA}/{name}" for name in data), *(f"{DIAGNOSIS}/{name}" for name in found)]


def _text(run: "Outcome", out: Path) -> str:
    from acf_jax.report import told
    from acf_jax.report.run_page import contact_lines
    from acf_jax.report.speed_text import lines_of

    lines = list(run.found)
    if run.diagnosis is not None:
        lines.append(told(run.diagnosis))
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
