"""Draw docs/figures/scale.svg: what grows how, with samples, devices and data sets.

python docs/figures/scale.py

reads the csv files beside it, which `python -m benchmarks.scale_samples`, `scale_devices` and `scale_data_sets` write
with `--csv FILE`. Traces have a figure of their own: `diagnose_cost.py`.
"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

HERE = Path(__file__).parent
INK, MEASURED, OTHER = "#1f2937", "#2563eb", "#c2410c"


def table(name: str) -> np.ndarray:
    """The columns of a csv file by their names."""
    return np.genfromtxt(HERE / f"{name}.csv", delimiter=",", names=True)


def samples(time: Axes, memory: Axes) -> None:
    """Seconds and megabytes of a training run."""
    data = table("scale_samples")
    millions = data["samples"] / 1e6
    time.plot(millions, data["data_s"], "o-", color=MEASURED, label="drawing and labelling, s")
    time.plot(millions, data["step_ms"], "s-", color=OTHER, label="a training step, ms")
    time.legend(frameon=False, fontsize=9, loc="lower right")
    memory.plot(millions, data["megabytes"], "o-", color=MEASURED)
    for axes, unit, title in ((time, "s, ms", "time"), (memory, "peak memory, MB", "memory of the process")):
        axes.set(xlabel="millions of samples", ylabel=unit, xlim=(0, None), ylim=(0, None))
        axes.set_title(f"Samples: {title}", loc="left", fontsize=11, color=INK)


def devices(axes: Axes) -> None:
    """Samples a second over the number of devices, all of them threads of one machine."""
    data = table("scale_devices")
    for batch, colour in zip(np.unique(data["batch"]), (MEASURED, OTHER), strict=False):
        for processes, style in ((1, "o-"), (2, "s--")):
            own = data[(data["batch"] == batch) & (data["processes"] == processes)]
            speed = own["steps_per_s"] * own["batch"]
            label = f"batch {batch:,.0f}" + (", two processes" if processes == 2 else "")
            axes.plot(own["devices"] * processes, speed, style, color=colour, label=label)
    axes.set(
        xscale="log", yscale="log", xlabel="devices, all on two cores", ylabel="samples trained on a second"
    )
    axes.set_xticks([1, 2, 4, 8], ["1", "2", "4", "8"])
    axes.minorticks_off()
    axes.legend(frameon=False, fontsize=8.5)
    axes.set_title("Devices", loc="left", fontsize=11, color=INK)


def data_sets(axes: Axes) -> None:
    """Seconds of a fleet."""
    data = table("scale_data_sets")
    for workers, colour in ((1, OTHER), (2, MEASURED)):
        own = data[data["workers"] == workers]
        axes.plot(
            own["data_sets"],
            own["seconds"],
            "o-",
            color=colour,
            label=f"{workers} process" + "es" * (workers > 1),
        )
    axes.set(xlabel="data sets", ylabel="time of the command, s", xlim=(0, None), ylim=(0, None))
    axes.legend(frameon=False, fontsize=9)
    axes.set_title("Data sets", loc="left", fontsize=11, color=INK)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=HERE / "scale.svg")
    options = parser.parse_args()
    plt.style.use(HERE / "style.mplstyle")
    figure, ((time, memory), (third, fourth)) = plt.subplots(2, 2, figsize=(10, 7.4), layout="constrained")
    samples(time, memory)
    devices(third)
    data_sets(fourth)
    figure.savefig(options.out, metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    main()
