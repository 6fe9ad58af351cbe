"""`python -m acf_jax identify`: what a table of measured peak forces says about the rig."""

import math
from pathlib import Path
from typing import Any

import click

from acf_jax.cli._json import echo_json
from acf_jax.errors import InputError

EXAMPLES = """
\b
Examples:
  python -m acf_jax identify peaks.csv
  python -m acf_jax identify peaks.csv --rig rig.yaml --json
"""

COLUMNS = ("contact_velocity_m_per_s", "pretension_n", "peak_force_n")
PUBLISHED = "paper_model_peak_force_n"


@click.command(epilog=EXAMPLES)
@click.argument("table", type=click.Path(path_type=Path))
@click.option(
    "--rig",
    "rig_file",
    type=click.Path(path_type=Path),
    help="YAML file of the rig assumed so far, rig: {m, d, k_f, k_c}: its error is the one before.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(table: Path, rig_file: Path | None, as_json: bool) -> None:
    """Identify sqrt(k_C m) from measured peaks, and say what peaks cannot identify.

    TABLE is a CSV file with the columns contact_velocity_m_per_s, pretension_n and peak_force_n; a column
    paper_model_peak_force_n is compared if it is there.
    """
    columns, rows, faults = _read(table)
    rig_values: dict[str, float] = {}
    if rig_file is not None:
        from acf_jax.dataset.rig_file import read_rig

        rig_values, rig_faults = read_rig(rig_file)
        faults += rig_faults
    if faults:
        raise InputError(faults)

    from acf_jax.start import start_jax

    start_jax()
    import numpy as np

    from acf_jax import identify as library
    from acf_jax.model import Impact, Rig, find_peaks

    v_e, f_p, f_max = (np.array(columns[name]) for name in COLUMNS)
    peaks = library.Peaks(v_e, f_p, f_max, rows)
    try:
        found = library.identify(peaks)
    except InputError as error:
        raise InputError([f"{table}: {fault}" for fault in error.faults]) from None
    information = library.information(peaks, found)
    before = {}
    if PUBLISHED in columns:
        before["published model"] = library.relative_error(np.array(columns[PUBLISHED]), f_max)
    if rig_values:
        rig = Rig(**{name: np.full_like(v_e, value) for name, value in rig_values.items()})
        predicted = find_peaks(rig, Impact(v_e, f_p))
        if not np.asarray(predicted.has_peak).all():
            raise InputError(f"{rig_file}: this rig has no peak in some of the trials; correct the rig")
        before[str(rig_file)] = library.relative_error(np.asarray(predicted.f_max), f_max)

    if as_json:
        echo_json(_document(found, information, before))
    else:
        click.echo(_text(found, information, before))


def _read(path: Path) -> tuple[dict[str, list[float]], tuple[str, ...], list[str]]:
    from acf_jax.dataset import units
    from acf_jax.dataset.table import read_table

    limits = {
        "contact_velocity_m_per_s": units.VELOCITY,
        "pretension_n": units.PRETENSION,
        "peak_force_n": units.PEAK_FORCE,
        PUBLISHED: units.PEAK_FORCE,
    }
    table = read_table(path, COLUMNS)
    wanted = [name for name in (*COLUMNS, PUBLISHED) if name in table.columns]
    columns: dict[str, list[float]] = {name: [] for name in wanted}
    for row in table.rows:
        for name in wanted:
            value = table.number(row, name)
            at_rest = value == 0 and name == "contact_velocity_m_per_s"
            if value is not None and not at_rest and (fault := limits[name].fault(value)):
                table.fault(f"row {row.number}", f"{name} {fault}")
            columns[name].append(value if value is not None else math.nan)
    if fault := units.pretension_column_fault(columns.get("pretension_n", [])):
        table.fault("", fault)
    if not table.rows and not table.faults:
        table.fault("", "holds no trials; add one row a trial below the first line")
    return columns, tuple(f"row {row.number}" for row in table.rows), table.shown_faults()


def _document(found: Any, information: Any, before: dict[str, float]) -> dict[str, Any]:
    return {
        "sqrt_k_c_m_n_s_per_m": found.sqrt_k_c_m,
        "interval_95_percent": list(found.interval),
        "rms_relative_error": {
            "before": before,
            "after": found.error,
            "left_out": found.error_left_out,
        },
        "peak_force_n": found.f_max.tolist(),
        "information": {
            "relative_scatter_of_a_peak": information.scatter,
            "std_with_all_else_known": information.std_alone,
            "std_with_nothing_else_known": information.std_together,
            "combinations_known_within_10_percent": information.rank,
        },
    }


def _percent(value: float | None) -> str:
    return "not known" if value is None or not math.isfinite(value) else f"{100 * value:.2f} %"


def _known(std: float) -> str:
    """A standard deviation; not known where a single peak leaves the scatter open, infinite where peaks say nothing."""
    return f"{std:.2g}" if math.isfinite(std) else "not at all" if math.isinf(std) else "not known"


def _text(found: Any, information: Any, before: dict[str, float]) -> str:
    low, high = found.interval
    lines = [f"sqrt(k_C m) = {found.sqrt_k_c_m:.1f} N s/m"]
    if math.isfinite(low):
        lines[0] += f"   (95 %: {low:.1f} to {high:.1f})"
    lines += ["", "root-mean-square error of the peak force, relative to the measurement"]
    lines += [f"  before, {name:24} {_percent(error):>9}" for name, error in before.items()]
    lines += [f"  after, with this product         {_percent(found.error):>9}"]
    lines += [f"  each trial left out in turn      {_percent(found.error_left_out):>9}"]
    lines += ["", "what these peaks know (standard deviation; relative for m, k_C and their product)"]
    lines += ["                  all else known   nothing else known"]
    for name, label in (
        ("sqrt_k_c_m", "sqrt(k_C m)"),
        ("m", "m"),
        ("k_c", "k_C"),
        ("zeta", "zeta"),
        ("epsilon", "k_F/K"),
    ):
        alone, together = information.std_alone[name], information.std_together[name]
        lines.append(f"  {label:14}{_known(alone):>14}   {_known(together):>16}")
    lines += [
        "",
        f"{information.rank} combination(s) of the four parameters are known within 10 %.",
        "Peaks never tell m from k_C: only their product enters. Damping and k_F trade against that product,",
        "as the right column shows; force traces tell them apart.",
    ]
    return "\n".join(lines)
