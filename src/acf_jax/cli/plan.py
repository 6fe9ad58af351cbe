"""`python -m acf_jax plan`: which effects a proposed set of trials could detect and tell apart."""

from pathlib import Path

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._progress import stages

EXAMPLES = """
\b
Examples:
  python -m acf_jax plan dataset.yaml --conditions trials.csv
  python -m acf_jax plan dataset.yaml --conditions trials.csv --sample-rate 4000 --noise 0.5 --json
"""


@click.command(epilog=EXAMPLES)
@click.argument("description", type=click.Path(path_type=Path))
@click.option(
    "--conditions",
    required=True,
    type=click.Path(path_type=Path),
    help="CSV, one row a trial: trial, contact_velocity_m_per_s, pretension_n.",
)
@click.option("--sample-rate", default=8000.0, show_default=True, help="Of the force, Hz.")
@click.option("--noise", type=float, help="Of one sample of force, N; by default as in DESCRIPTION, else 1.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    description: Path, conditions: Path, sample_rate: float, noise: float | None, as_json: bool
) -> None:
    """Tell what trials would show, before any is made.

    DESCRIPTION is a rig's file or a dataset.yaml: the rig as known beforehand, and how force will be measured.
    """
    from acf_jax.dataset import Trial, read_conditions
    from acf_jax.dataset.description import check_rig
    from acf_jax.dataset.units import low_pass_fault
    from acf_jax.errors import InputError
    from acf_jax.files import read_yaml_mapping

    faults: list[str] = []
    if not 100 <= sample_rate <= 1e6:
        faults.append(f"--sample-rate {sample_rate:g}: must lie between 100 and 1000000 Hz")
    if noise is not None and not 0 < noise < 1e4:
        faults.append(f"--noise {noise:g}: must be positive, in N")
    trials: tuple[Trial, ...] = ()
    rig, measurement = None, None
    for read in ("conditions", "description"):
        try:
            if read == "conditions":
                trials = read_conditions(conditions)
            else:
                _, rig, measurement = check_rig(description, read_yaml_mapping(description))
        except InputError as error:
            faults += error.faults
    if rig and measurement and measurement.low_pass:
        fault = low_pass_fault(measurement.low_pass, rig.impact_time, trials)
        faults += [f"{description}: measurement.low_pass: {fault}"] if fault else []
    if not faults and len(trials) < 3:
        faults.append(f"{conditions}: has {len(trials)} trials; a diagnosis needs at least three")
    if faults or rig is None or measurement is None:
        raise InputError(faults)

    from acf_jax.start import start_jax

    start_jax()
    from acf_jax.diagnosis import plan
    from acf_jax.effects import library

    noise_std = noise or measurement.force_noise_std_n or 1.0
    with stages() as progress:
        progress("fitting every effect to trials without it")
        rows = plan(rig, measurement, trials, sample_rate, noise_std)
    if as_json:
        content = [
            {
                "effect": r.effect,
                "smallest_detectable": r.smallest,
                "unit": r.unit,
                "distance_at_typical_size": r.distance_at_typical,
                "confused_with": list(r.confused_with),
            }
            for r in rows
        ]
        echo_json({"sample_rate_hz": sample_rate, "noise_n": noise_std, "effects": content})
        return
    click.echo(
        f"{len(trials)} trials, {sample_rate:g} Hz, noise {noise_std:g} N: smallest size that would be detected"
    )
    for r in rows:
        first = library()[r.effect].parameters()[0]
        size = "not at all" if r.smallest is None else f"{r.smallest:10.3g} {r.unit}"
        twins = f"   not told apart from {', '.join(r.confused_with)}" if r.confused_with else ""
        click.echo(f"  {r.effect:20s} {first.name:24s} {size}{twins}")
