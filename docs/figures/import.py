"""Draw docs/figures/import.svg: the recording examples/session.mcap, and the impacts cut from it.

python docs/figures/import.py
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from acf_jax.recording import Impacts, Mapping, find_impacts, read_session
from acf_jax.recording.page import envelope
from acf_jax.recording.rig import read_rig_file
from acf_jax.recording.series import Series

HERE = Path(__file__).parent
EXAMPLES = HERE.parents[1] / "examples"
INK, FORCE, ROBOT, BAND, PALE = "#1f2937", "#2563eb", "#d9480f", "#9ca3af", "#93b4f5"


def draw_recording(force: Axes, robot: Axes, impacts: Impacts) -> None:
    """The whole recording, cuts shaded."""
    session = impacts.session
    begin = int(session.force.time[0])
    assert isinstance(session.speed, Series)
    force.plot(*envelope(session.force, begin), color=FORCE, linewidth=0.7)
    robot.plot(*envelope(session.speed, begin), color=ROBOT, linewidth=0.9)
    for cut in impacts.kept:
        first, last = (1e-9 * (cut.contact.begin - begin + int(t)) for t in (cut.time[0], cut.time[-1]))
        for axes in (force, robot):
            axes.axvspan(first, last, color=BAND, alpha=0.22, linewidth=0)
    at = [1e-9 * (cut.contact.begin - begin) for cut in impacts.kept]
    force.plot(at, [cut.contact.peak for cut in impacts.kept], "o", color=INK, markersize=3.5)
    force.set(ylabel="force, N")
    force.tick_params(labelbottom=False)
    robot.set(xlabel="time since the first force sample, s", ylabel="robot, m/s")
    force.set_title("One recording: what was cut, and its peaks", loc="left", fontsize=11, color=INK)


def draw_cuts(axes: Axes, impacts: Impacts) -> None:
    """Every cut over time from first contact, by its pretension."""
    lowest = min(cut.condition[1] for cut in impacts.kept)
    for cut in impacts.kept:
        colour = PALE if cut.condition[1] == lowest else FORCE
        axes.plot(1e-6 * cut.time, cut.force, color=colour, linewidth=0.7)
    for f_p, colour in sorted(
        {(cut.condition[1], PALE if cut.condition[1] == lowest else FORCE) for cut in impacts.kept}
    ):
        axes.plot([], [], color=colour, label=f"pretension {f_p:g} N")
    axes.axvline(0.0, color=INK, linewidth=1)
    axes.text(
        -0.25,
        0.97,
        "first\ncontact",
        transform=axes.get_xaxis_transform(),
        ha="right",
        va="top",
        fontsize=9.5,
    )
    axes.set(xlabel="time since first contact, ms", ylabel="force, N", xlim=(-3.2, 15))
    axes.legend(frameon=False, loc="upper right")
    axes.set_title(f"The data set: {len(impacts.kept)} impacts", loc="left", fontsize=11, color=INK)


def main() -> None:
    plt.style.use(HERE / "style.mplstyle")
    prior = read_rig_file(EXAMPLES / "session_rig.yaml").prior
    impacts = find_impacts(read_session(EXAMPLES / "session.mcap", Mapping()), Mapping().contacts, prior)
    assert np.all([cut.keep for cut in impacts.cuts])
    figure = plt.figure(figsize=(10, 4.1), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.35, 1), height_ratios=(2.4, 1))
    force = figure.add_subplot(grid[0, 0])
    draw_recording(force, figure.add_subplot(grid[1, 0], sharex=force), impacts)
    draw_cuts(figure.add_subplot(grid[:, 1]), impacts)
    figure.savefig(HERE / "import.svg", metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    main()
