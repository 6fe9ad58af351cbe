"""Draw docs/figures/effects.svg: what each effect does to the sensed force, weak and strong.

python docs/figures/effects.py
"""

from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np

from acf_jax.effects import AbstractEffect, library
from acf_jax.inference.parameters import starts
from acf_jax.model import Impact, Rig
from acf_jax.simulator import simulate

HERE = Path(__file__).parent
INK, GREY = "#1f2937", "#9ca3af"
COLOURS = {"actuator": "#2563eb", "contact": "#d9480f", "robot": "#0f766e", "sensor": "#9333ea"}
RIG, IMPACT = Rig(m=3.0, d=60.0, k_f=1e3, k_c=1.2e5), Impact(v_e=0.2, f_p=80.0)
H, SAMPLES = 2.5e-5, 801
SIZES: dict[float, dict[str, Any]] = {  # in typical strengths
    0.5: {"linewidth": 1.2, "linestyle": (0, (4, 1.5))},
    1.5: {"linewidth": 1.5},
}
SIDE: dict[str, Any] = {"rotation": 90, "ha": "center", "va": "center", "fontsize": 11, "fontweight": "bold"}


def make(kind: type[AbstractEffect], size: float) -> AbstractEffect:
    """The effect at a multiple of its typical strength, its shapes where fits begin."""
    known = zip(kind.parameters(), starts(kind.id())[0], strict=True)
    return kind(*(jnp.asarray(start if p.shape else size * p.scale) for p, start in known))


def sensed(effects: list[AbstractEffect]) -> np.ndarray:
    return np.asarray(jax.jit(lambda: simulate(RIG, IMPACT, effects, H, SAMPLES).sensed)())


def main() -> None:
    jax.config.update("jax_enable_x64", True)
    plt.style.use(HERE / "style.mplstyle")
    plt.rcParams["font.size"] = 9
    kinds = {c: [kind for kind in library().values() if kind.component == c] for c in COLOURS}
    columns = max(map(len, kinds.values()))
    figure, axes = plt.subplots(
        4, columns, figsize=(2.5 * columns, 8.2), sharex=True, sharey=True, layout="constrained"
    )
    t, paper = 1e3 * H * np.arange(SAMPLES), sensed([])
    for row, (component, colour) in zip(axes, COLOURS.items(), strict=True):
        for panel, kind in zip(row, kinds[component], strict=False):
            panel.plot(t, paper, color=GREY, linewidth=2.4)
            for size, style in SIZES.items():
                panel.plot(t, sensed([make(kind, size)]), color=colour, **style)
            panel.set_title(kind.title.partition(" (")[0], loc="left", fontsize=9.5, color=INK, pad=3)
            panel.set(xlim=(0, 20), ylim=(-30, 245), xticks=(0, 10, 20), yticks=(0, 100, 200))
        for panel in row[len(kinds[component]) :]:
            panel.axis("off")
        row[0].set_ylabel("sensed force, N")
        row[0].text(-0.42, 0.5, component, transform=row[0].transAxes, color=colour, **SIDE)
        for panel in row[: len(kinds[component])]:
            panel.tick_params(labelbottom=True)
    for panel in axes[-1]:
        panel.set_xlabel("time since contact, ms")
    key = axes[2, len(kinds["robot"])]
    lines: tuple[tuple[float, str, dict[str, Any]], ...] = (
        (0.75, "paper's model", {"color": GREY, "linewidth": 2.4}),
        (0.55, "with the effect, weak", {"color": COLOURS["robot"]} | SIZES[0.5]),
        (0.35, "with the effect, strong", {"color": COLOURS["robot"]} | SIZES[1.5]),
    )
    for y, label, style in lines:
        key.plot((0.1, 0.25), (y, y), transform=key.transAxes, **style)
        key.text(0.31, y, label, transform=key.transAxes, va="center", color=INK)
    figure.savefig(HERE / "effects.svg", metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    main()
