"""Each cause's force over time: the corrected model with every cause on or off, trial by trial."""

from collections.abc import Collection
from itertools import combinations
from typing import Any

import numpy as np

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.inference.forward import forward
from acf_jax.inference.parameters import Explanation, is_free_curve, switched_off
from acf_jax.report.markup import Html, element, join, void
from acf_jax.report.plot import CORRECTED, Variant, axis, plot, series
from acf_jax.report.words import condition, headed, listed, name_of

MOST = 60  # trials that the page carries
COLOURS = ("--nominal", "--recalibrated", "--contact")


def switched(diagnosis: Diagnosis) -> Html | None:
    """The figure with a switch a named cause; None without traces, without such a cause, and with a free curve.

    A cause that is off is taken out of the corrected model; nothing is fitted anew.
    """
    d = diagnosis
    causes = tuple(name for name in d.corrected.explanation if name in d.scored[0].explanation)
    rows = [i for i in range(len(d.observations.names)) if not d.observations.peak_only[i]][:MOST]
    if not causes or not rows or is_free_curve(d.corrected.explanation):
        return None
    sets = [chosen for n in range(len(causes) + 1) for chosen in combinations(causes, n)]
    forces = {chosen: _forces(d, set(causes) - set(chosen)) for chosen in sets}
    variants = [_trial(d, i, causes, forces) for i in rows]
    layout = {
        "xaxis": axis("time since first contact / ms", domain=[0, 1], anchor="y2"),
        "yaxis": axis("sensed force / N", domain=[0.4, 1]),
        "yaxis2": axis("of each cause / N", domain=[0, 0.32]),
    }
    caption = (
        "The corrected model with the causes that are on; nothing is fitted anew. Below: what each cause adds to the"
        " force, the others being on."
    )
    boxes = [
        element(
            "span",
            void("input", type="checkbox", checked=True, id=f"cause-{c}", data_switch="causes", data_cause=c),
            element("label", f" {headed(name_of((c,)))}", for_=f"cause-{c}"),
            class_="switch",
        )
        for c in causes
    ]
    switches = element("p", "Causes that act: ", *boxes, role="group", aria_label="Causes that act")
    return join([switches, plot("causes", "Each cause over time", caption, variants, layout, 520, "Trial")])


def _forces(d: Diagnosis, off: Collection[str]) -> np.ndarray:
    """Sensed force of every trial without some of the causes, (trials, steps), N."""
    o, explanation = d.observations, d.corrected.explanation
    theta = switched_off(explanation, d.corrected.physical, off)
    return forward(explanation, theta, o.v_e, o.f_p, d.corrected.grid).sensed


def _trial(d: Diagnosis, i: int, causes: Explanation, forces: dict[Explanation, np.ndarray]) -> Variant:
    o, fitted = d.observations, d.corrected
    time = o.time[i, o.used[i]]
    full = forces[causes][i]
    grid = np.arange(full.size) * fitted.grid.h + fitted.common[1]
    inside = grid <= time.max()
    x = series(1e3 * grid[inside], 4)
    traces: list[dict[str, Any]] = []
    for chosen, force in forces.items():
        words = listed([name_of((c,)) for c in chosen])
        traces.append(
            {
                "x": x,
                "y": series(force[i][inside]),
                "mode": "lines",
                "line": CORRECTED,
                "name": f"model with {words}" if words else "model without causes",
                "meta": {"causes": list(chosen)},
                "visible": chosen == causes,
            }
        )
    for k, cause in enumerate(causes):
        without = tuple(c for c in causes if c != cause)
        traces.append(
            {
                "x": x,
                "y": series((full - forces[without][i])[inside], 4),
                "mode": "lines",
                "line": {"color": COLOURS[k % len(COLOURS)], "width": 2},
                "yaxis": "y2",
                "name": f"of {name_of((cause,))}",
                "meta": {"cause": cause},
            }
        )
    marker = {"color": "--measured", "size": 5 if time.size < 150 else 3}
    measured = {
        "x": series(1e3 * time, 4),
        "y": series(o.force[i, o.used[i]]),
        "mode": "markers",
        "marker": marker,
    }
    traces.append({**measured, "name": "measured", "legendrank": 1})
    return Variant(f"{o.names[i]}: {condition(o.v_e[i], o.f_p[i])}", traces)
