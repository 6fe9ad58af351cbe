"""`python -m acf_jax predict`: forces of a diagnosed rig at conditions that were not tried."""

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._origin import OVERWRITE, foreign_files
from acf_jax.cli._progress import stages
from acf_jax.cli._stale import traces_of, unknown

if TYPE_CHECKING:
    from acf_jax.predict import Prediction

EXAMPLES = """
\b
Examples:
  python -m acf_jax predict result --conditions conditions.csv --out predictions
  python -m acf_jax predict result --conditions conditions.csv --out nominal --model nominal --sample-rate 8000
"""
SHOWN = 20  # impacts of which the terminal shows the peaks
COLUMNS = (
    "trial",
    "contact_velocity_m_per_s",
    "pretension_n",
    "peak_force_n",
    "peak_force_std_n",
    "peak_time_s",
    "contact_peak_force_n",
    "contact_peak_force_std_n",
)


@click.command(epilog=EXAMPLES)
@click.argument("diagnosis", type=click.Path(path_type=Path))
@click.option(
    "--conditions",
    required=True,
    type=click.Path(path_type=Path),
    help="CSV: trial, contact_velocity_m_per_s, pretension_n.",
)
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder for the predictions.")
@click.option(
    "--model",
    "which",
    type=click.Choice(["nominal", "recalibrated", "corrected"]),
    help="The paper's model at its prior values, refitted, or with the effects found; by default the last, unless it"
    " is no better than the refitted one on conditions that the fit did not see.",
)
@click.option("--sample-rate", type=float, help="Of the traces, Hz; the data set's by default.")
@OVERWRITE
@click.option("--json", "as_json", is_flag=True, help="Print JSON: the rows of predictions.csv.")
def command(
    diagnosis: Path,
    conditions: Path,
    out: Path,
    which: str | None,
    sample_rate: float | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Predict impacts with the model that `diagnose` left in DIAGNOSIS, its folder or its model.json.

    Writes OUT/predictions.csv and OUT/traces/<trial>.csv.
    """
    from acf_jax.dataset import read_conditions
    from acf_jax.errors import InputError, collected

    faults = []
    if sample_rate is not None and not 100 <= sample_rate <= 1e6:
        faults.append(f"--sample-rate {sample_rate:g}: must lie between 100 and 1000000 Hz")
    if out.exists() and not out.is_dir():
        faults.append(f"--out {out}: is a file; name a folder")
    elif (out / "trials.csv").exists():
        faults.append(f"--out {out}: holds a data set, whose traces have these names; name another folder")
    faults += foreign_files([out / "predictions.csv"], overwrite)
    trials = collected(faults, lambda: read_conditions(conditions))
    if trials is not None and not overwrite:
        known = traces_of(out / "predictions.csv", COLUMNS[-1])
        faults += unknown((out / "traces" / f"{t.name}.csv" for t in trials), out, known)
    if faults or trials is None:
        raise InputError(faults)

    from acf_jax.start import start_jax

    start_jax()
    import numpy as np

    from acf_jax.contact.model_file import model_path
    from acf_jax.files import write_text
    from acf_jax.folders import whole_folder
    from acf_jax.gap_model import read_model
    from acf_jax.predict import notes, predict

    model = read_model(model_path(diagnosis))
    asked, which = which, which or model.preferred
    v_e = np.array([t.contact_velocity for t in trials])
    f_p = np.array([t.pretension for t in trials])
    with stages() as progress:
        progress(f"simulating {len(trials)} impacts")
        predictions = predict(model, v_e, f_p, which, sample_rate)  # type: ignore[arg-type]
    rows = [
        (
            t.name,
            t.contact_velocity,
            t.pretension,
            *map(
                _number,
                (p.peak_force, p.peak_force_std, p.peak_time, p.contact_peak_force, p.contact_peak_force_std),
            ),
        )
        for t, p in zip(trials, predictions, strict=True)
    ]
    with whole_folder(out, traces_of(out / "predictions.csv", COLUMNS[-1])) as folder:
        write_text(folder / "predictions.csv", _table(COLUMNS, rows))
        for trial, p in zip(trials, predictions, strict=True):
            samples = [
                (f"{t:.7f}", f"{f:.4f}", f"{c:.4f}")
                for t, f, c in zip(p.time, p.force, p.contact_force, strict=True)
            ]
            write_text(
                folder / "traces" / f"{trial.name}.csv",
                _table(("time_s", "force_n", "contact_force_n"), samples),
            )
    if as_json:
        echo_json({"model": which, "predictions": [_numbers(row) for row in rows]})
    else:
        click.echo(_peaks([(t.name, p) for t, p in zip(trials, predictions, strict=True)]))
        click.echo(f"{out / 'predictions.csv'}: {len(trials)} impacts by the {which} model")
    for note in notes(model, v_e, f_p, asked):  # type: ignore[arg-type]
        click.echo(f"note: {note}", err=True)
    if diverging := [t.name for t, p in zip(trials, predictions, strict=True) if p.diverges]:
        click.echo(
            f"note: the correction diverges at {', '.join(diverging[:5])}{' and others' * (len(diverging) > 5)}, too"
            " far from the trials: what is written of these impacts is the recalibrated model's",
            err=True,
        )


def _peaks(rows: "list[tuple[str, Prediction]]") -> str:
    """Peak forces with one standard deviation, an impact a line; of many the first, all are in the file."""
    shown = rows[:SHOWN]
    width = max(len("impact"), *(len(name) for name, _ in shown))
    lines = [f"{'impact':{width}}  peak at the contact, N   peak sensed, N"]
    for name, p in shown:
        contact = _with_std(p.contact_peak_force, p.contact_peak_force_std)
        lines.append(f"{name:{width}}  {contact:>22}  {_with_std(p.peak_force, p.peak_force_std):>15}")
    if len(rows) > SHOWN:
        lines.append(f"and {len(rows) - SHOWN:,} more")
    return "\n".join(lines)


def _with_std(value: float, std: float) -> str:
    return f"{value:.2f} ± {std:.2f}"


def _numbers(row: tuple) -> dict[str, str | float]:  # type: ignore[type-arg]
    name, *values = row
    return {COLUMNS[0]: name} | {key: float(x) for key, x in zip(COLUMNS[1:], values, strict=True)}


def _number(value: float) -> str:
    return f"{value:.6g}"


def _table(columns: tuple[str, ...], rows: list[tuple]) -> str:  # type: ignore[type-arg]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue()
