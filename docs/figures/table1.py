"""Draw docs/figures/table1.svg: the paper's impacts, their exact peaks, and the gap to the measurement.

python docs/figures/table1.py
"""

from pathlib import Path

import jax
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
import yaml

from acf_jax.identify import Peaks, ideal_peak, identify, relative_error
from acf_jax.model import Impact, Rig, contact_force, find_peaks

HERE = Path(__file__).parent
CONFIGS = HERE.parents[1] / "configs"
INK, MODEL, REFIT = "#1f2937", "#2563eb", "#d9480f"


def main() -> None:
    jax.config.update("jax_enable_x64", True)
    plt.style.use(HERE / "style.mplstyle")
    v_e, f_p, measured, published = np.genfromtxt(
        CONFIGS / "table1.csv", delimiter=",", skip_header=1, usecols=(1, 2, 3, 4)
    ).T
    rig = Rig(**yaml.safe_load((CONFIGS / "table1_rig.yaml").read_text())["rig"])
    figure, (traces, gap) = plt.subplots(
        1, 2, figsize=(10, 4.1), width_ratios=(1.15, 1), layout="constrained"
    )

    rigs = jax.tree.map(lambda x: jnp.broadcast_to(x, v_e.shape), rig)
    peak = find_peaks(rigs, Impact(v_e=v_e, f_p=f_p))
    t = np.linspace(0, 0.0125, 400)
    for i, v in enumerate(v_e):
        impact = Impact(v_e=v, f_p=f_p[i])
        trace = np.asarray(jax.vmap(lambda s, impact=impact: contact_force(rig, impact, s))(t))
        traces.plot(1e3 * t, trace, color=MODEL, alpha=0.35 + 1.6 * v, linewidth=1.6)
        traces.plot(1e3 * peak.t_max[i], peak.f_max[i], "o", color=MODEL, markersize=5, zorder=3)
        traces.plot(1e3 * peak.t_max[i], measured[i], "x", color=INK, ms=6, mew=1.6, zorder=3)
        label = traces.text(
            8.7, trace[278], f"{v:g} m/s", fontsize=8.5, color=MODEL, ha="center", va="center"
        )
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 1.5})
    traces.set(xlim=(0, 12.5), ylim=(0, 350), xlabel="time since contact, ms", ylabel="contact force, N")
    traces.set_title("Every impact, and its exact first peak", loc="left", fontsize=11, color=INK)

    fit = identify(Peaks(v_e, f_p, measured))
    before, after = 100 * relative_error(published, measured), 100 * fit.error
    v, product = np.linspace(0.02, 0.37, 100), float(jnp.sqrt(rig.k_c * rig.m))
    gap.plot(v, ideal_peak(product, v, f_p[0]), color=MODEL, linewidth=1.8)
    gap.plot(v, ideal_peak(fit.sqrt_k_c_m, v, f_p[0]), color=REFIT, linewidth=1.8)
    gap.plot(v_e, measured, "x", color=INK, ms=7, mew=1.8)
    gap.text(0.165, 150, f"paper's model: {before:.2f} % off (RMS)", color=MODEL, fontsize=9.5)
    number = f"$\\sqrt{{k_C m}}$ = {fit.sqrt_k_c_m:.0f} N s/m"
    gap.text(0.02, 262, f"recalibrated, {number}:\n{after:.2f} % off", color=REFIT, fontsize=9.5)
    gap.text(0.187, 206, "measured", ha="right", color=INK, fontsize=9.5)
    gap.set(xlim=(0, 0.38), ylim=(90, 350), xlabel="contact velocity, m/s", ylabel="peak contact force, N")
    gap.set_title("The gap to the measurement", loc="left", fontsize=11, color=INK)
    figure.savefig(HERE / "table1.svg", metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    main()
