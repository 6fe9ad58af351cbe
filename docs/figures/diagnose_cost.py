"""Draw docs/figures/diagnose_cost.svg: time and memory of a diagnosis over the number of traces.

python docs/figures/diagnose_cost.py

reads docs/figures/diagnose_cost.csv, which `python -m benchmarks.diagnose_cost --csv FILE` writes.
"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

HERE = Path(__file__).parent
INK, MEASURED = "#1f2937", "#2563eb"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--csv", type=Path, default=HERE / "diagnose_cost.csv")
    parser.add_argument("--out", type=Path, default=HERE / "diagnose_cost.svg")
    options = parser.parse_args()
    trials, seconds, megabytes = np.loadtxt(options.csv, delimiter=",", skiprows=1, ndmin=2).T
    power, constant = np.polyfit(np.log(trials), np.log(seconds), 1)
    print(f"Seconds grow as traces^{power:.2f} (least squares of the logarithms).")

    plt.style.use(HERE / "style.mplstyle")
    figure, (time, memory) = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
    line = np.geomspace(trials[0] / 1.3, trials[-1] * 1.3, 2)
    proportional = seconds[0] * line / trials[0]
    time.plot(line, proportional, color="#9ca3af", linewidth=1.2, linestyle=(0, (4, 2)))
    time.plot(line, np.exp(constant) * line**power, color=MEASURED, linewidth=1.4)
    time.plot(trials, seconds, "o", color=MEASURED, markersize=6)
    time.set(xscale="log", yscale="log", xlabel="traces", ylabel="time of a diagnosis, s")
    time.set_title("Time", loc="left", fontsize=11, color=INK)
    key = {"transform": time.transAxes, "fontsize": 9.5}
    time.text(0.04, 0.92, f"measured, and its fit: traces$^{{{power:.2f}}}$", color=MEASURED, **key)
    time.text(0.04, 0.84, "in proportion to the smallest set", color="#6b7280", **key)
    memory.axhline(2048, color="#9ca3af", linewidth=1.2, linestyle=(0, (4, 2)))
    memory.plot(trials, megabytes, "o-", color=MEASURED, markersize=6, linewidth=1.4)
    memory.text(trials[0], 2048, "2 GB", color="#6b7280", fontsize=9.5, va="bottom")
    memory.set(xscale="log", xlabel="traces", ylabel="peak memory, MB")
    memory.set_ylim(0, 1.12 * max(2048, megabytes.max()))
    memory.set_title("Memory of the whole process", loc="left", fontsize=11, color=INK)
    for axes in (time, memory):
        axes.set_xticks(trials, [f"{n:,.0f}" for n in trials])
        axes.minorticks_off()
    figure.savefig(options.out, metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    main()
