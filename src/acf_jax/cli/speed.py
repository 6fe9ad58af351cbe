"""`python -m acf_jax speed`: the highest contact velocity for a force limit, the paper's inverse."""

import math
from pathlib import Path
from typing import Any

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._model import HELP, ModelFile
from acf_jax.cli._progress import counted
from acf_jax.errors import InputError

EXAMPLES = """
\b
Examples:
  python -m acf_jax speed --model configs/table1_rig.yaml --f-p 100 --limit 150 --limit 250
  python -m acf_jax speed --model result/model.json --f-p 80 --limit 140 --probability 0.99
"""


@click.command(epilog=EXAMPLES)
@click.option("--model", "model_file", required=True, type=click.Path(path_type=Path), help=HELP)
@click.option("--f-p", required=True, type=float, help="Pretension F_P, N.")
@click.option(
    "--limit",
    required=True,
    type=float,
    multiple=True,
    help="Highest peak contact force, N; may be repeated.",
)
@click.option("--probability", default=0.95, show_default=True, type=float, help="That the limit holds.")
@click.option("--up-to", default=2.0, show_default=True, type=float, help="Highest velocity looked at, m/s.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    model_file: Path, f_p: float, limit: tuple[float, ...], probability: float, up_to: float, as_json: bool
) -> None:
    """Highest contact velocity for a limit of the peak contact force, exact, under the parameters' uncertainty."""
    faults = []
    if not 0 <= f_p < float("inf"):
        faults.append(f"--f-p must be a number, finite and zero or positive, in N, but is {f_p!r}")
    faults += [f"--limit must be positive, in N, but is {x!r}" for x in limit if not 0 < x < float("inf")]
    if not 0.5 <= probability <= 0.9999:
        faults.append(f"--probability must lie between 0.5 and 0.9999, but is {probability!r}")
    if not 0 < up_to <= 100:
        faults.append(f"--up-to must lie between 0 and 100 m/s, but is {up_to!r}")
    file = None
    try:
        file = ModelFile(model_file)
    except InputError as error:
        faults += error.faults
    if faults or file is None:
        raise InputError(faults)

    from acf_jax.start import start_jax

    start_jax()
    from acf_jax.contact.read import learnt_range
    from acf_jax.design.remedy import Infeasible
    from acf_jax.design.solve import Design, design
    from acf_jax.design.task import make_task

    model = file.load()
    slowest, fastest = learnt_range(model, "v_e") or (0.0, up_to)
    least, most = learnt_range(model, "f_p") or (f_p, f_p)
    if not least <= f_p <= most:
        raise InputError(f"--f-p must lie in the surrogate's {least:g} to {most:g} N, but is {f_p:g}")
    up_to = min(up_to, fastest)
    if slowest >= up_to:
        raise InputError(f"--up-to must be above the surrogate's {slowest:g} m/s, but is {up_to:g}")
    rows: list[dict[str, Any]] = []
    notes: list[str] = []
    for force in counted(limit, "limits"):
        task = make_task(model, {"v_e": (slowest, up_to)}, {"f_p": f_p}, "fastest", force, probability)
        found = design(task)
        row: dict[str, Any] = {"limit_n": force, "v_e": None, "expected_force_n": None, "v_e_per_n": None}
        if isinstance(found, Design):
            row |= {
                "v_e": float(found.z[-2]),
                "expected_force_n": found.force,
                "v_e_per_n": found.goal_per_newton,
                "limit_reached": found.at_limit,
            }
            notes += found.notes
        else:
            assert isinstance(found, Infeasible)
            row["force_at_rest_n"] = found.upper
        rows.append(row)
    if as_json:
        content = {
            "model": model.source,
            "f_p": f_p,
            "probability": probability,
            "speeds": rows,
            "notes": notes,
        }
        echo_json(content)
        return
    click.echo("       limit    highest velocity    expected force    one newton more")
    for row in rows:
        click.echo(f"{row['limit_n']:10.4g} N   {_words(row, slowest)}")
    for note in dict.fromkeys(notes):
        click.echo(f"note: {note}")


def _words(row: dict[str, Any], slowest: float) -> str:
    if row["v_e"] is None:
        least = row["force_at_rest_n"]
        how = "pressing without speed" if slowest == 0 else f"the surrogate's lowest speed, {slowest:g} m/s,"
        return f"none: {how} takes {least:.4g} N already; lower the pretension"
    if not row["limit_reached"]:
        why = "the search's end, or where the force has no first peak beyond"
        return f"{row['v_e']:12.4f} m/s {row['expected_force_n']:15.2f} N     limit not reached: {why}"
    speed = math.floor(row["v_e"] * 1e4) / 1e4  # not rounded up: what is shown is allowed
    price = f"{row['v_e_per_n']:12.5f} m/s" if row["v_e_per_n"] is not None else ""
    return f"{speed:12.4f} m/s {row['expected_force_n']:15.2f} N {price}"
