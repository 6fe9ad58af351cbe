"""`python -m acf_jax peak`: peak force and its time, for one rig and one or several contact velocities."""

from pathlib import Path
from typing import Any

import click

from acf_jax.cli._json import echo_json
from acf_jax.cli._rig import collect_rig, option, sign_fault
from acf_jax.errors import InputError

EXAMPLES = """
\b
Examples:
  python -m acf_jax peak --m 4 --d 0 --k-f 0 --k-c 175561 --v-e 0.2 --f-p 100
  python -m acf_jax peak --rig configs/table1_rig.yaml --f-p 100 --v-e 0.05 --v-e 0.1 --v-e 0.2
  python -m acf_jax peak --rig configs/table1_rig.yaml --f-p 100 --v-e 0.2 --v-e 0.3 --plot force.html
"""


@click.command(epilog=EXAMPLES)
@click.option("--rig", "rig_file", type=click.Path(path_type=Path), help="YAML file: rig: {m, d, k_f, k_c}.")
@click.option("--m", type=float, help="Moving mass, kg.")
@click.option("--d", type=float, help="Damping, N s/m.")
@click.option("--k-f", type=float, help="Stiffness of the actuator, N/m.")
@click.option("--k-c", type=float, help="Stiffness of the contact, N/m.")
@click.option("--v-e", type=float, multiple=True, help="Contact velocity, m/s; may be given several times.")
@click.option("--f-p", type=float, help="Pretension F_P, N.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("--plot", type=click.Path(path_type=Path), help="Write the force over time to this HTML file.")
def command(
    rig_file: Path | None,
    v_e: tuple[float, ...],
    f_p: float | None,
    as_json: bool,
    plot: Path | None,
    **rig_options: float | None,
) -> None:
    """Peak contact force of the paper's model, when it occurs, and whether it exists."""
    rig_values, faults = collect_rig(rig_file, rig_options)
    faults += [fault for v in v_e if (fault := sign_fault("v_e", v, option("v_e")))]
    if not v_e:
        faults.append("--v-e is missing; give one contact velocity or more, in m/s")
    if f_p is None:
        faults.append("--f-p is missing; give the pretension, in N")
    elif fault := sign_fault("f_p", f_p, option("f_p")):
        faults.append(fault)
    if plot is not None and plot.suffix.lower() not in (".html", ".htm"):
        faults.append(f"--plot {plot}: must end in .html; name an HTML file")
    if faults:
        raise InputError(faults)

    rows = _peaks(rig_values, v_e, float(f_p or 0))
    if plot is not None:
        from acf_jax.cli._peak_plot import write_force_plot

        write_force_plot(plot, rig_values, rows, float(f_p or 0))
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
