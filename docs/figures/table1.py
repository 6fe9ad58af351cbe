"""Draw docs/figures/table1.svg: the paper's impacts, their exact peaks, and the gap to the measurement.

python docs/figures/table1.py
"""

from pathlib import Path

import jax
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
import yaml
from scipy.optimize import least_squares

from acf_jax.model import Impact, Rig, contact_force, find_peaks

HERE = Path(__file__).parent
F_P = 100.0  # N
V_E = np.array([0.05, 0.1, 0.2, 0.3, 0.35])  # m/s
MEASURED = np.array([110.0, 137.0, 198.0, 282.0, 320.0])  # N
INK, MODEL, REFIT = "#1f2937", "#2563eb", "#d9480f"


def peaks(rig: Rig, v_e: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """F_max, N, and t_max, s, of the rig at each velocity."""
    batch = jax.tree.map(lambda x: jnp.broadcast_to(x, v_e.shape), rig)
    peak = find_peaks(batch, Impact(v_e=v_e, f_p=np.full_like(v_e, F_P)))
    return np.asarray(peak.f_max), np.asarray(peak.t_max)


def scaled(rig: Rig, product: float) -> Rig:
    """The rig with another sqrt(k_c m), the one thing that peaks identify."""
    ratio = product / jnp.sqrt(rig.k_c * rig.m)
    return Rig(m=rig.m * ratio, d=rig.d * ratio, k_f=rig.k_f * ratio, k_c=rig.k_c * ratio)


def rms(rig: Rig) -> float:
    """RMS relative error of the peaks, %."""
    return float(100 * np.sqrt(np.mean((peaks(rig, V_E)[0] / MEASURED - 1) ** 2)))


def main() -> None:
    jax.config.update("jax_enable_x64", True)
    plt.rcParams |= {
        "font.family": "DejaVu Sans",
        "font.size": 10,
        "svg.fonttype": "path",
        "svg.hashsalt": "acf-jax",
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.edgecolor": "#6b7280",
        "axes.labelcolor": INK,
        "xtick.color": "#4b5563",
        "ytick.color": "#4b5563",
    }
    rig = Rig(**yaml.safe_load((HERE.parents[1] / "configs/table1_rig.yaml").read_text())["rig"])
    fit = least_squares(lambda s: peaks(scaled(rig, s[0]), V_E)[0] / MEASURED - 1, [838.0], x_scale=100.0)
    refit = scaled(rig, float(fit.x[0]))

    figure, (traces, gap) = plt.subplots(
        1, 2, figsize=(10, 4.1), width_ratios=(1.15, 1), layout="constrained"
    )
    t = np.linspace(0, 0.0125, 400)
    f_max, t_max = peaks(rig, V_E)
    for v_e, force, time, measured in zip(V_E, f_max, t_max, MEASURED, strict=True):
        impact = Impact(v_e=v_e, f_p=F_P)
        trace = jax.vmap(lambda s, impact=impact: contact_force(rig, impact, s))(t)
        traces.plot(1e3 * t, trace, color=MODEL, alpha=0.35 + 1.6 * v_e, linewidth=1.6)
        traces.plot(1e3 * time, force, "o", color=MODEL, markersize=5, zorder=3)
        traces.plot(1e3 * time, measured, "x", color=INK, markersize=6, markeredgewidth=1.6, zorder=3)
        label = traces.text(
            8.7, float(trace[278]), f"{v_e:g} m/s", fontsize=8.5, color=MODEL, ha="center", va="center"
        )
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 1.5})
    traces.set(xlim=(0, 12.5), ylim=(0, 350), xlabel="time since contact, ms", ylabel="contact force, N")
    traces.set_title("Every impact, and its exact first peak", loc="left", fontsize=11, color=INK)

    v = np.linspace(0.02, 0.37, 100)
    gap.plot(v, peaks(rig, v)[0], color=MODEL, linewidth=1.8)
    gap.plot(v, peaks(refit, v)[0], color=REFIT, linewidth=1.8)
    gap.plot(V_E, MEASURED, "x", color=INK, markersize=7, markeredgewidth=1.8)
    gap.text(0.17, 150, f"paper's model: {rms(rig):.2f} % off (RMS)", color=MODEL, fontsize=9.5)
    product = f"{float(fit.x[0]):.0f} N s/m"
    gap.text(0.02, 262, f"recalibrated, $\\sqrt{{k_C m}}$ = {product}:\n{rms(refit):.2f} % off",
             color=REFIT, fontsize=9.5)  # fmt: skip
    gap.text(0.187, 206, "measured", ha="right", color=INK, fontsize=9.5)
    gap.set(xlim=(0, 0.38), ylim=(90, 350), xlabel="contact velocity, m/s", ylabel="peak contact force, N")
    gap.set_title("The gap to the measurement", loc="left", fontsize=11, color=INK)
    figure.savefig(HERE / "table1.svg", metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    main()
