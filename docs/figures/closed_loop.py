"""Draw docs/figures/closed_loop.svg: peak force over speed and allowed speed, by every model of examples/rig.

python -m docs.figures.closed_loop
"""

import runpy
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

HERE = Path(__file__).parent
EXAMPLE = HERE.parents[1] / "docs/examples/closed_loop.py"
INK = "#1f2937"
COLOURS = {
    "paper's model": "#9ca3af",
    "recalibrated": "#f08c00",
    "corrected": "#2563eb",
    "surrogate": "#0d9488",
    "truth": INK,
}


def main() -> None:
    plt.style.use(HERE / "style.mplstyle")
    sys.argv = [str(EXAMPLE)]
    known = runpy.run_path(str(EXAMPLE))
    models, speeds, limits, (low, high) = (known[k] for k in ("models", "speeds", "LIMITS", "RANGE"))
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(10, 4.1), width_ratios=(1.25, 1), layout="constrained"
    )

    v = np.linspace(low, high, 25)
    true = np.array([models["truth"](x) for x in v])
    for name in ("paper's model", "recalibrated", "corrected", "surrogate"):
        error = 100 * (np.array([models[name](x) for x in v]) / true - 1)
        style = {"linestyle": (0, (1, 1.2))} if name == "surrogate" else {}
        left.plot(v, error, color=COLOURS[name], linewidth=2.2, label=name, **style)
    left.axhline(0, color=INK, linewidth=1)
    left.text(high, 0.2, "the rig itself", ha="right", va="bottom", fontsize=9.5, color=INK)
    left.set(xlabel="contact velocity, m/s", ylabel="error of the peak contact force, %", xlim=(low, high))
    left.set_title(
        f"Each model against the rig, {known['F_P']:g} N of pretension", loc="left", fontsize=11, color=INK
    )
    left.plot([], [], color=COLOURS["truth"], linewidth=6, label="truth")
    left.legend(frameon=False, fontsize=9.5, loc=(0.62, 0.3))

    height = 0.16
    for k, (name, colour) in enumerate(COLOURS.items()):
        y = np.arange(len(limits)) + (k - 2) * height
        right.barh(y, speeds[name], height * 0.9, color=colour)
        for at, speed in zip(y, speeds[name], strict=True):
            right.text(speed + 0.004, at, f"{speed:.3f}", va="center", fontsize=8.5, color=INK)
    right.set(
        yticks=range(len(limits)), yticklabels=[f"{limit:g} N" for limit in limits], xlabel="speed, m/s"
    )
    right.set(xlim=(0, 1.15 * max(max(row) for row in speeds.values())))
    right.invert_yaxis()
    right.set_title("Speed at which a limit is reached", loc="left", fontsize=11, color=INK)
    figure.savefig(HERE / "closed_loop.svg", metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    main()
