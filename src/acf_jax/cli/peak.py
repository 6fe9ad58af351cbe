"""`python -m acf_jax peak`: peak force and its time, for one rig and one or several contact velocities."""

import math
from pathlib import Path
from typing import Any

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._origin import OVERWRITE, foreign_files
from acf_jax.cli._rig import collect_rig, option
from acf_jax.contact.model_file import ModelFile
from acf_jax.errors import InputError, collected

EXAMPLES = """
\b
Examples:
  python -m acf_jax peak --m 4 --d 0 --k-f 0 --k-c 175561 --v-e 0.2 --f-p 100
  python -m acf_jax peak --rig rig.yaml --f-p 100 --v-e 0.05 --v-e 0.1 --v-e 0.2
  python -m acf_jax peak --rig rig.yaml --f-p 100 --v-e 0.2 --v-e 0.3 --plot force.html
  python -m acf_jax peak --model diagnosis --f-p 60 --v-e 0.2
"""


@click.command(epilog=EXAMPLES)
@click.option("--rig", "rig_file", type=click.Path(path_type=Path), help="YAML file: rig: {m, d, k_f, k_c}.")
@click.option(
    "--model",
    "model_file",
    type=click.Path(path_type=Path),
    help="In place of a rig: a diagnosis' model.json, or a model.eqx that was trained on one.",
)
@click.option("--m", type=float, help="Moving mass, kg.")
@click.option("--d", type=float, help="Damping, N s/m.")
@click.option("--k-f", type=float, help="Stiffness of the actuator, N/m.")
@click.option("--k-c", type=float, help="Stiffness of the contact, N/m.")
@click.option("--v-e", type=float, multiple=True, help="Contact velocity, m/s; may be given several times.")
@click.option("--f-p", type=float, help="Pretension F_P, N.")
@OVERWRITE
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("--plot", type=click.Path(path_type=Path), help="Write the force over time to this HTML file.")
def command(
    rig_file: Path | None,
    model_file: Path | None,
    v_e: tuple[float, ...],
    f_p: float | None,
    overwrite: bool,
    as_json: bool,
    plot: Path | None,
    **rig_options: float | None,
) -> None:
    """Peak contact force of the paper's model, or of a corrected one, when it occurs, and whether it exists."""
    file = None
    if model_file is None:
        rig_values, faults = collect_rig(rig_file, rig_options)
    else:
        rig_values, faults = (
            {},
            [
                f"{option(name)} belongs to the paper's model; remove it or --model"
                for name, value in {"rig": rig_file, **rig_options}.items()
                if value is not None
            ],
        )
        file = collected(faults, lambda: ModelFile(model_file))
        if file and not file.is_diagnosis:
            faults.append(f"--model {model_file}: is a rig; give it by --rig")
    from acf_jax.dataset.units import value_fault

    faults += [fault for v in v_e if (fault := value_fault("v_e", v, option("v_e")))]
    if not v_e:
        faults.append("--v-e is missing; give one contact velocity or more, in m/s")
    if f_p is None:
        faults.append("--f-p is missing; give the pretension, in N")
    elif fault := value_fault("f_p", f_p, option("f_p")):
        faults.append(fault)
    if plot is not None and plot.suffix.lower() not in (".html", ".htm"):
        faults.append(f"--plot {plot}: must end in .html; name an HTML file")
    faults += foreign_files([plot], overwrite)
    if faults:
        raise InputError(faults)

    if file is not None:
        _corrected(file, v_e, float(f_p or 0), plot, as_json)
        return
    rows = _peaks(rig_values, v_e, float(f_p or 0))
    if plot is not None:
        from acf_jax.report.peak_plot import rig_curves, write_force_plot

        write_force_plot(plot, rig_curves(rig_values, rows, float(f_p or 0)), rows)
    if as_json:
        echo_json({"rig": rig_values, "f_p": f_p, "peaks": rows})
        return
    click.echo("contact velocity    peak force       after")
    for row in rows:
        result = "no peak: the force keeps rising, as actuator and damping hold the mass back"
        if row["has_peak"]:
            result = f"{row['f_max']:9.2f} N  {1e3 * row['t_max']:7.3f} ms"
        click.echo(f"{row['v_e']:12.4g} m/s   {result}")


def _peaks(rig_values: dict[str, float], v_e: tuple[float, ...], f_p: float) -> list[dict[str, Any]]:
    from acf_jax.start import start_jax

    start_jax()
    import numpy as np

    from acf_jax.model import Impact, Rig, find_peaks

    # A fixed size, so that the compiled code is found again whatever the number of velocities.
    size = -(-len(v_e) // 16) * 16
    velocities = np.resize(np.array(v_e), size)
    rig = Rig(**{name: np.full(size, float(value)) for name, value in rig_values.items()})
    peaks = find_peaks(rig, Impact(velocities, np.full(size, f_p)))
    columns = (np.asarray(peaks.f_max), np.asarray(peaks.t_max), np.asarray(peaks.has_peak))
    rows = []
    for v, f_max, t_max, has_peak in zip(v_e, *columns, strict=False):
        found = {"f_max": float(f_max), "t_max": float(t_max)} if has_peak else {"f_max": None, "t_max": None}
        rows.append({"v_e": v, **found, "has_peak": bool(has_peak)})
    return rows


def _corrected(file: ModelFile, v_e: tuple[float, ...], f_p: float, plot: Path | None, as_json: bool) -> None:
    """Peaks of a diagnosis' model: simulated, or by the surrogate that was trained on it."""
    from acf_jax.start import start_jax

    start_jax()
    import jax
    import jax.numpy as jnp
    import numpy as np

    from acf_jax.contact.body import WALL
    from acf_jax.contact.learnt import ask
    from acf_jax.contact.peak import Simulated, Trained

    model = file.load()
    law = model.main.peak
    z = np.array([model.at(v, f_p) for v in v_e])
    rows: list[dict[str, Any]] = []
    if isinstance(law, Trained):
        found, faults = ask(law, z)
        for v, fault, force, time, bound, is_inside in zip(v_e, faults, *found, strict=True):
            row = {"v_e": v, "f_max": float(force), "t_max": float(time), "error_bound": float(bound)}
            if fault:
                row = dict.fromkeys(row) | {"v_e": v, "fault": fault}
            rows.append(row | {"has_peak": bool(is_inside)})
    else:
        assert isinstance(law, Simulated)
        peaks = jax.jit(jax.vmap(lambda z: law.largest(z, WALL)))(jnp.asarray(z))
        for v, force, time, exists in zip(v_e, *map(np.asarray, peaks), strict=True):
            values = (
                {"f_max": float(force), "t_max": float(time)} if exists else {"f_max": None, "t_max": None}
            )
            rows.append({"v_e": v, **values, "has_peak": bool(exists)})
    if plot is not None:
        from acf_jax.report.peak_plot import model_curves, write_force_plot

        gap, _ = file.load_gap()
        assert gap is not None  # the file is a diagnosis'
        write_force_plot(plot, model_curves(gap, v_e, f_p), rows)
    notes = model.notes(*(model.at(row["v_e"], f_p) for row in rows if row["has_peak"]))
    if as_json:
        echo_json({"model": str(file.path), "f_p": f_p, "peaks": rows, "notes": notes})
        return
    click.echo("contact velocity    peak force       after" + "      wrong by less than" * file.is_trained)
    for row in rows:
        result = row.get("fault", "no peak: the force still rises after 60 ms")
        if row["has_peak"]:
            result = f"{row['f_max']:9.2f} N  {1e3 * row['t_max']:7.3f} ms"
            if file.is_trained:
                result += f"  {math.ceil(100 * row['error_bound']) / 100:16.2f} N"
        click.echo(f"{row['v_e']:12.4g} m/s   {result}")
    for note in notes:
        click.echo(f"note: {note}")
