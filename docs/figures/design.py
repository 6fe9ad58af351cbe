"""Draw docs/figures/design.svg: the design space of configs/design.yaml, and what holds the limit there.

python docs/figures/design.py
"""

from pathlib import Path

import jax
import matplotlib.pyplot as plt
import numpy as np
import yaml

from acf_jax.contact.body import WALL
from acf_jax.contact.model import draw_forces
from acf_jax.contact.read import of_rig
from acf_jax.designs.config import read_config
from acf_jax.designs.landscape import landscape
from acf_jax.designs.solve import Design, design
from acf_jax.designs.task import make_task

HERE = Path(__file__).parent
CONFIG = HERE.parents[1] / "configs/design.yaml"
INK, FORCE, LIMIT = "#1f2937", "#2563eb", "#d9480f"


def main() -> None:
    jax.config.update("jax_enable_x64", True)
    plt.style.use(HERE / "style.mplstyle")
    config = read_config(CONFIG)
    rig = yaml.safe_load((CONFIG.parent / config.model).read_text())["rig"]
    ranges = {name: (r.low, r.high) for name, r in config.ranges().items()}
    model = of_rig(rig, config.relative_std)
    found = design(make_task(model, ranges, {}, config.goal, config.limit, config.probability), starts=8)
    assert isinstance(found, Design)

    figure, (plane, spread) = plt.subplots(
        1, 2, figsize=(10, 4.1), width_ratios=(1.25, 1), layout="constrained"
    )
    space = landscape(found, points=61)
    levels = np.arange(100, 700, 50)
    lines = plane.contour(*space.axes, space.upper, levels, colors=FORCE, linewidths=0.8, alpha=0.6)
    plane.clabel(lines, levels[::2], fmt="%d N", fontsize=8)
    plane.contourf(*space.axes, space.upper, [config.limit, 1e4], colors=[LIMIT], alpha=0.13)
    plane.contour(*space.axes, space.upper, [config.limit], colors=LIMIT, linewidths=2)
    x, y = space.point
    plane.plot(x, y, "*", color=INK, markersize=14, clip_on=False, zorder=4)
    words = f"optimum: {np.floor(1e3 * x) / 1e3:.3f} m/s with {y:g} N,\npad of {found.z[3] / 1e3:g} N/mm"
    line, box = {"arrowstyle": "-", "color": "#6b7280"}, {"facecolor": "white", "edgecolor": "none", "pad": 2}
    plane.annotate(words, (x, y), (0.56, 84.5), fontsize=9.5, color=INK, arrowprops=line, bbox=box)
    plane.text(
        0.03,
        116,
        f"allowed: at most {config.limit:g} N\nwith P = {config.probability:g}",
        fontsize=9.5,
        va="top",
    )
    plane.text(0.97, 116, "too hard", fontsize=9.5, va="top", ha="right", color=LIMIT)
    plane.set(xlabel="contact velocity, m/s", ylabel="pretension, N", xlim=ranges["v_e"], ylim=ranges["f_p"])
    plane.set_title("Force that is not exceeded, and the fastest contact", loc="left", fontsize=11, color=INK)

    forces, _ = draw_forces(model, found.z, WALL, 40_000, seed=3)
    bins = config.limit + np.arange(-36, 22.5, 1.5)  # an edge at the limit
    for part, colour in ((forces <= config.limit, FORCE), (forces > config.limit, LIMIT)):
        spread.hist(forces[part], bins, color=colour, alpha=0.75)
    spread.axvline(config.limit, color=LIMIT, linewidth=2)
    share = (forces <= config.limit).mean()
    spread.text(249, 0.97, f"{100 * share:.1f} % of 40,000 draws\nhold the limit", ha="right", va="top",
                transform=spread.get_xaxis_transform(), fontsize=9.5, color=FORCE)  # fmt: skip
    spread.margins(y=0.22)
    spread.set(xlabel="peak contact force, N", yticks=[], xlim=(215, 271))
    spread.spines["left"].set_visible(False)
    spread.set_title("The rig's uncertainty at the optimum", loc="left", fontsize=11, color=INK)
    figure.savefig(HERE / "design.svg", metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    main()
