"""Draw docs/figures/safety.svg: verdicts over contact velocity for the rig of configs/check_rig.yaml.

python docs/figures/safety.py
"""

from pathlib import Path

import jax
import matplotlib.pyplot as plt
import numpy as np
import yaml
from matplotlib.artist import Artist
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from acf_jax.contact.ending import Ending
from acf_jax.contact.read import of_rig
from acf_jax.safety.check import Checker
from acf_jax.safety.limits import read_limits
from acf_jax.safety.situation import CONTACTS, Situation
from acf_jax.surrogate import load_surrogate

HERE = Path(__file__).parent
RIG = HERE.parents[1] / "configs/check_rig.yaml"
INK = "#1f2937"
COLOURS = {"allowed": "#2f9e44", "not decidable": "#f08c00", "not allowed": "#d9480f"}
AREAS = ("Palm (dominant side)", "Deltoid muscle", "Sternum", "Middle of shin")
F_P, HIGHEST = 60.0, 1.5
STOP = Ending(stop_after=0.05)


def main() -> None:
    jax.config.update("jax_enable_x64", True)
    plt.style.use(HERE / "style.mplstyle")
    content = yaml.safe_load(RIG.read_text())
    checker = Checker(of_rig(content["rig"], content["relative_std"]), load_surrogate())
    limits = read_limits()
    speeds = np.linspace(0.005, HIGHEST, 300)
    figure, panels = plt.subplots(1, 2, figsize=(10, 4.1), sharey=True, layout="constrained")
    for panel, contact in zip(panels, CONTACTS, strict=True):
        for row, name in enumerate(AREAS):
            asked = Situation(
                "", limits.find(name), contact, 0.0, F_P, moving_mass=21.7, payload=6.9, ending=STOP
            )
            answers = [checker.judge(asked._replace(v_e=float(v))) for v in speeds]
            step = speeds[1] - speeds[0]
            for verdict, colour in COLOURS.items():
                here = speeds[[a.verdict == verdict for a in answers]]
                if here.size:  # one piece: the force grows with the speed
                    panel.barh(
                        row + 0.05, np.ptp(here) + step, 0.5, left=here[0] - step / 2, color=colour, alpha=0.8
                    )
            last = speeds[max(i for i, a in enumerate(answers) if a.verdict == "allowed")]
            beyond = " and more" if last == speeds[-1] else ""
            # above the bar, where nothing is drawn
            panel.text(
                0.01, row - 0.26, f"to {np.floor(100 * last) / 100:.2f} m/s{beyond}", color=INK, fontsize=9
            )
            if (standard := answers[0].standard_speed) is not None and standard < HIGHEST:
                panel.plot(
                    [standard] * 2, [row - 0.2, row + 0.3], color=INK, linewidth=2, solid_capstyle="butt"
                )
        panel.set(
            xlabel="contact velocity, m/s",
            xlim=(0, HIGHEST),
            ylim=(len(AREAS) - 0.5, -0.6),
            yticks=range(len(AREAS)),
            yticklabels=AREAS,
        )
        words = (
            "transient: the body recoils" if contact == "transient" else "quasi-static: the body is clamped"
        )
        panel.set_title(words, loc="left", fontsize=11, color=INK)
    marks: list[Artist] = [Patch(color=c, alpha=0.8) for c in COLOURS.values()]
    marks.append(Line2D([], [], color=INK, linewidth=2))
    figure.legend(
        marks, [*COLOURS, "the standard's own v_max"], loc="outside lower center", ncols=4, frameon=False
    )
    figure.savefig(HERE / "safety.svg", metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    main()
