"""Draw docs/figures/eq10.svg: where Eq. (10), as the paper prints it, is off.

python docs/figures/eq10.py
"""

from pathlib import Path

import jax
import matplotlib.pyplot as plt
import numpy as np

from acf_jax.model import Impact, Rig, contact_force, find_peak, find_peaks
from acf_jax.model.printed_eq10 import find_peak_by_printed_eq10

HERE = Path(__file__).parent
INK, FULL, PRINTED = "#1f2937", "#2563eb", "#d9480f"


def draw_box(size: int) -> tuple[Rig, Impact]:
    """Underdamped samples of the wide box."""
    random = np.random.default_rng(0)
    m, k_c, v = (
        np.exp(random.uniform(np.log(low), np.log(high), size))
        for low, high in ((0.5, 10), (1e4, 1e6), (0.01, 1))
    )
    k_f, zeta, f_p = (random.uniform(low, high, size) for low, high in ((0, 1e4), (0, 1.5), (0, 500)))
    rig = Rig(m, 2 * zeta * np.sqrt(m * (k_f + k_c)), k_f, k_c)
    chosen = zeta < 1
    return jax.tree.map(lambda x: x[chosen], (rig, Impact(v, f_p)))


def main() -> None:
    jax.config.update("jax_enable_x64", True)
    plt.style.use(HERE / "style.mplstyle")
    figure, (trace, errors) = plt.subplots(1, 2, figsize=(10, 4.1), layout="constrained")

    rig, impact = Rig(4.0, 340.0, 9000.0, 4e4), Impact(0.4, 60.0)
    full, printed = find_peak(rig, impact), find_peak_by_printed_eq10(rig, impact)
    t = np.linspace(0, 0.045, 400)
    force = jax.vmap(lambda s: contact_force(rig, impact, s))(t)
    trace.plot(1e3 * t, force, color=INK, linewidth=1.6)
    for peak, color, label in ((full, FULL, "full equation"), (printed, PRINTED, "Eq. (10) as printed")):
        trace.plot(1e3 * peak.t_max, peak.f_max, "o", color=color, label=label)
        trace.axvline(1e3 * peak.t_max, color=color, linewidth=0.8)
    trace.legend(frameon=False, loc="lower right")
    trace.set(xlabel="time since contact, ms", ylabel="contact force, N", xlim=(0, 45))
    trace.set_title(
        f"zeta = {float(rig.zeta):.2f}, k_F/K = {float(rig.k_f / rig.k):.2f}", loc="left", fontsize=11
    )

    box = draw_box(100_000)
    exact, approximate = find_peaks(*box), jax.jit(jax.vmap(find_peak_by_printed_eq10))(*box)
    both = np.asarray(exact.has_peak & approximate.has_peak)
    error = np.abs(np.asarray(approximate.f_max / exact.f_max - 1))[both]
    late = np.abs(np.asarray(approximate.t_max / exact.t_max - 1))[both]
    false = int((approximate.has_peak & ~exact.has_peak).sum())
    print(f"{both.size} underdamped samples, {both.sum()} with a peak in both equations")
    print(f"force error: median {np.median(error):.1e}, largest {100 * error.max():.2f} %")
    print(f"time error: largest {100 * late.max():.0f} %; peaks found where there is none: {false}")

    some = slice(0, 6000)
    zeta, epsilon = np.asarray(box[0].zeta)[both], np.asarray(box[0].k_f / box[0].k)[both]
    dots = errors.scatter(
        zeta[some], np.maximum(100 * error[some], 1e-10), c=epsilon[some], s=5, cmap="viridis", linewidths=0,
        rasterized=True,
    )  # fmt: skip
    errors.set(
        yscale="log", ylim=(1e-9, 5), xlim=(0, 1), xlabel="damping ratio zeta", ylabel="error of F_max, %"
    )
    errors.set_title("Over the wide box", loc="left", fontsize=11)
    figure.colorbar(dots, label="k_F/K")
    figure.savefig(HERE / "eq10.svg", metadata={"Date": None}, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main()
