"""`python -m acf_jax diagnose`: where the gap to measured impacts lies, why, and how far it shrinks."""

from pathlib import Path

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._origin import OVERWRITE, foreign_files, origin
from acf_jax.cli._progress import stages
from acf_jax.cli._seed import SEED
from acf_jax.progress_lines import tell_known, wants_lines
from acf_jax.provenance import FILE

FIRST = "(the first one compiles for this machine)"

EXAMPLES = """
\b
Examples:
  python -m acf_jax diagnose my_rig --out result
  python -m acf_jax diagnose my_rig --out result --json | python -m json.tool
  python -m acf_jax diagnose my_rig --out result --low-pass 200
  python -m acf_jax diagnose drop_tower --out result --without robot --without end_stop
"""


@click.command(epilog=EXAMPLES)
@click.argument("dataset", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder for the results.")
@click.option(
    "--without",
    multiple=True,
    metavar="EFFECT|COMPONENT",
    help="An effect that cannot be the cause on this rig, or a component that it does not have (actuator, contact,"
    " robot, sensor); several times for several.",
)
@click.option("--seed", default=0, show_default=True, type=SEED, help="Of the bootstrap intervals.")
@click.option(
    "--low-pass",
    type=click.FloatRange(0.0, min_open=True),
    metavar="HZ",
    help="Cutoff of a low-pass for data and model alike, to leave out what is faster, as a ring.",
)
@OVERWRITE
@click.option("--json", "as_json", is_flag=True, help="Print JSON: diagnosis.json.")
def command(
    dataset: Path,
    out: Path,
    without: tuple[str, ...],
    seed: int,
    low_pass: float | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Diagnose the sim-to-real gap of the data set in the folder DATASET.

    Writes OUT/diagnosis.json, OUT/report.html, OUT/model.json and OUT/provenance.json.
    `import` makes a data set of a recording. A diagnosis that was interrupted, by Ctrl-C or in whatever way, goes on
    with the fits that it has made: the same command takes them from .OUT.unfinished beside OUT.
    """
    from acf_jax.dataset import LowPass, read_dataset
    from acf_jax.dataset.low_pass import APPLIED_ORDER
    from acf_jax.errors import InputError, collected

    faults = [f"--out {out}: is a file; name a folder"] if out.exists() and not out.is_dir() else []
    faults += foreign_files(
        (out / name for name in ("diagnosis.json", "model.json", "report.html", FILE)), overwrite
    )
    data = collected(faults, lambda: read_dataset(dataset))  # told before anything slow is loaded
    if faults or data is None:
        raise InputError(faults)
    band = LowPass(low_pass, APPLIED_ORDER) if low_pass else None
    if without:
        from acf_jax.effects import remaining

        try:
            remaining(without)
        except ValueError as error:
            raise InputError(f"--without: {error}") from None

    from acf_jax.start import start_jax

    start_jax()
    from acf_jax.diagnosis import diagnose
    from acf_jax.inference.forward import MADE_OF
    from acf_jax.inference.unfinished import beside, kept_in
    from acf_jax.kept import is_first
    from acf_jax.report import save_diagnosis, told

    watch = tell_known if wants_lines() else None
    with kept_in(beside(out)) as left:
        if left:
            click.echo(f"note: goes on with {left} fits of a diagnosis that was interrupted", err=True)
        with stages(FIRST if is_first(MADE_OF) else "") as progress:
            diagnosis = diagnose(data, seed, progress, without, low_pass=band, watch=watch)
            progress("writing the report")
            content = save_diagnosis(out, diagnosis, origin({str(dataset): data.digest}))
    if as_json:
        echo_json(content)
    else:
        click.echo(told(diagnosis))
        click.echo(f"{out / 'report.html'}: open it in a browser")
