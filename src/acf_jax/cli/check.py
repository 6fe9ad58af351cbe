"""`python -m acf_jax check`: whether a contact with a person stays within the limits of ISO/TS 15066."""

from pathlib import Path

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._origin import OVERWRITE, foreign_files
from acf_jax.cli._progress import counted
from acf_jax.cli._stop import OPTIONS, ending_options, make_ending
from acf_jax.contact.model_file import HELP, ModelFile
from acf_jax.errors import InputError, collected

EXAMPLES = """
\b
Examples:
  python -m acf_jax check --model rig.yaml --body-area palm --contact transient --v-e 0.2 --f-p 60
  python -m acf_jax check --model result/model.json --situations situations.csv --out verdicts.csv
"""
NEEDED = ("--body-area", "--contact", "--v-e", "--f-p")


@click.command(epilog=EXAMPLES)
@click.option("--model", "--rig", "model_file", required=True, type=click.Path(path_type=Path), help=HELP)
@click.option(
    "--situations", type=click.Path(path_type=Path), help="CSV: a table of situations instead of one."
)
@click.option("--out", type=click.Path(path_type=Path), help="CSV file for the table's verdicts.")
@click.option(
    "--body-area",
    help="Number or name of an area of the limits file, or of a region: every area of it is checked.",
)
@click.option(
    "--contact", type=click.Choice(["transient", "quasi_static"]), help="Free to recoil, or clamped."
)
@click.option("--v-e", type=float, help="Contact velocity, m/s.")
@click.option("--f-p", type=float, help="Pretension F_P, N.")
@ending_options
@click.option(
    "--contact-area-cm2", type=float, help="Decides the pressure; without it the pressure is not decided."
)
@click.option(
    "--robot-mass-kg", type=float, help="M, the robot's moving parts: for the standard's own formula."
)
@click.option("--payload-kg", type=float, help="m_L, for the standard's own formula.")
@click.option(
    "--limits",
    "limits_file",
    type=click.Path(path_type=Path),
    help="Own limits, CSV; ISO/TS 15066 by default.",
)
@click.option(
    "--confidence",
    default=0.975,
    show_default=True,
    type=float,
    help="With which an allowed force is not exceeded.",
)
@click.option("--exact", is_flag=True, help="Never ask the surrogate.")
@OVERWRITE
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    model_file: Path,
    situations: Path | None,
    out: Path | None,
    body_area: str | None,
    contact: str | None,
    v_e: float | None,
    f_p: float | None,
    stop_after: float | None,
    travel: float | None,
    reaction: float | None,
    deceleration: float | None,
    contact_area_cm2: float | None,
    robot_mass_kg: float | None,
    payload_kg: float | None,
    limits_file: Path | None,
    confidence: float,
    exact: bool,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Check one contact, or a table of them, against the limits of body areas.

    Ends with exit code 0 where everything is allowed, 1 otherwise. A calculation replaces neither a measurement
    nor a risk assessment. The documentation's page on safety explains the answer.
    """
    from acf_jax.safety.limits import read_limits
    from acf_jax.safety.situation import CONFIDENCE, Contact, Situation, read_situations

    faults = foreign_files([out], overwrite)
    if not CONFIDENCE[0] <= confidence <= CONFIDENCE[1]:
        faults.append(
            f"--confidence must lie between {CONFIDENCE[0]} and {CONFIDENCE[1]}, but is {confidence!r}"
        )
    asked: tuple[Situation, ...] = ()
    file = collected(faults, lambda: ModelFile(model_file))
    limits = collected(faults, lambda: read_limits(limits_file))
    one = dict(zip(NEEDED, (body_area, contact, v_e, f_p), strict=True))
    told = {"stop_after": stop_after, "travel": travel, "reaction": reaction, "deceleration": deceleration}
    if situations is not None:
        faults += [
            f"{name} belongs to a single check; remove it or --situations"
            for name, x in (one | {OPTIONS[name]: x for name, x in told.items()}).items()
            if x is not None
        ]
        if out is None and not as_json:
            faults.append("--out is missing; name a CSV file for the verdicts, or give --json")
        if limits is not None:
            asked = collected(faults, lambda: read_situations(situations, limits)) or ()
    else:
        faults += [
            f"{name} is missing; give it, or a table by --situations" for name, x in one.items() if x is None
        ]
        faults += _number_faults(v_e, f_p, contact_area_cm2, robot_mass_kg, payload_kg)
        ending, wrong = make_ending(**told)
        faults += wrong
        if out is not None:
            faults.append("--out belongs to --situations; remove it, or use --json")
        if limits is not None and body_area is not None:
            try:
                areas = limits.find(body_area)
                masses = (contact_area_cm2, robot_mass_kg, payload_kg)
                kind: Contact = "transient" if contact == "transient" else "quasi_static"
                asked = (Situation("", areas, kind, v_e or 0.0, f_p or 0.0, *masses, ending=ending),)
            except InputError as error:
                faults += [f"--{fault.replace('body area', 'body-area', 1)}" for fault in error.faults]
    if faults or file is None or limits is None:
        raise InputError(faults)

    from acf_jax.start import start_jax

    start_jax()
    from acf_jax.report import check_text as words
    from acf_jax.safety.check import Checker
    from acf_jax.surrogate import load_surrogate

    model, trained = file.load_exact()
    checker = Checker(model, None if exact else trained or load_surrogate(), confidence)
    answers = [checker(situation) for situation in counted(asked, "situations")]
    if out is not None and situations is not None:
        from acf_jax.files import write_text

        write_text(out, words.table(situations, answers))
    if as_json:
        documents = [words.document(a, checker, limits, alone=situations is None) for a in answers]
        echo_json(documents[0] if situations is None else {"situations": documents})
    elif out is not None:
        click.echo(words.summary(out, answers, checker, limits))
    else:
        click.echo(words.text(answers[0], checker, limits))
    if any(a.verdict != "allowed" for a in answers):
        raise click.exceptions.Exit(1)


def _number_faults(
    v_e: float | None, f_p: float | None, area: float | None, mass: float | None, payload: float | None
) -> list[str]:
    from acf_jax.safety.situation import LIMITS, quantity_fault

    names = ("--v-e", "--f-p", "--contact-area-cm2", "--robot-mass-kg", "--payload-kg")
    given = zip(names, LIMITS, (v_e, f_p, area, mass, payload), strict=True)
    found = [
        f"{name} {fault}" for name, quantity, value in given if (fault := quantity_fault(quantity, value))
    ]
    if (mass is None) != (payload is None):
        found.append("--robot-mass-kg and --payload-kg belong together; give both or neither")
    return found
