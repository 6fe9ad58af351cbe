"""What an unknown cause looks like: its fitted free curve along the trials."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Int

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.effects import Motion
from acf_jax.effects._interface import Scalar
from acf_jax.evidence.posterior import UNKNOWN
from acf_jax.inference.fit import Fit
from acf_jax.inference.forward import unpack
from acf_jax.inference.interpolation import first_loss
from acf_jax.inference.parameters import component_of, is_free_curve, split
from acf_jax.model import Impact
from acf_jax.report.markup import Html
from acf_jax.report.plot import Variant, axis, plot, series
from acf_jax.report.words import condition, percent
from acf_jax.simulator.simulate import Moving, advance, make_system, start

SHOWN = 5  # conditions, one for each colour of the scale
POINTS = 150  # of a curve


class Course(NamedTuple):
    """The quantities of one impact over time, those on which a discrepancy may depend first."""

    time: np.ndarray  # ms
    stroke: np.ndarray  # mm
    speed: np.ndarray  # m/s
    compression: np.ndarray  # mm
    rate: np.ndarray  # m/s
    force: np.ndarray  # N, contact force
    discrepancy: np.ndarray  # N, or mm of the robot


AGAINST = {
    "actuator": {"stroke": "stroke / mm", "speed": "speed of the flange / (m/s)", "time": "time / ms"},
    "contact": {
        "compression": "compression / mm",
        "rate": "rate of compression / (m/s)",
        "time": "time / ms",
    },
    "robot": {"time": "time / ms", "force": "contact force / N"},
    "sensor": {"force": "contact force / N", "time": "time / ms"},
}
MEASURES = {
    "actuator": "additional force on the flange / N",
    "contact": "additional contact force / N",
    "robot": "displacement of the robot beside v t / mm",
    "sensor": "reading − contact force / N",
}


def unknown_cause(diagnosis: Diagnosis) -> Html | None:
    """The fitted discrepancy against what it may depend on; None where an unknown cause is not standing."""
    d = diagnosis
    of_curves = [(f, p) for f, p in zip(d.fits, d.probability, strict=True) if is_free_curve(f.explanation)]
    if not of_curves or (UNKNOWN not in d.credible and d.scored[0].explanation != UNKNOWN):
        return None
    fitted, p = max(of_curves, key=lambda item: item[1])
    component = component_of(split(fitted.explanation)[1][0])
    o = d.observations
    first = [int(np.flatnonzero(o.condition == c)[0]) for c in np.unique(o.condition)]
    first.sort(key=lambda i: (o.v_e[i], o.f_p[i]))
    chosen = [
        first[k]
        for k in np.unique(np.linspace(0, len(first) - 1, min(SHOWN, len(first))).round().astype(int))
    ]
    whole = fitted.grid.h * fitted.grid.steps
    ends = [float(o.time[i, o.used[i]].max(initial=0.0)) or whole for i in chosen]
    courses = along(fitted, o.v_e[chosen], o.f_p[chosen], np.array(ends))
    variants = []
    for quantity, label in AGAINST[component].items():
        data = [
            {
                "x": series(getattr(course, quantity), 4),
                "y": series(course.discrepancy, 4),
                "mode": "lines",
                "line": {"color": f"--scale-{round(k * 4 / max(1, len(chosen) - 1))}", "width": 2},
                "name": condition(o.v_e[i], o.f_p[i]),
            }
            for k, (i, course) in enumerate(zip(chosen, courses, strict=True))
        ]
        variants.append(Variant(label.split(" / ")[0], data, {"xaxis": axis(label)}))
    caption = (
        f"The discrepancy fitted at the {component} (probability {percent(p)}), along impacts as they ran. Curves of"
        " all conditions on one line: it depends on the chosen quantity alone; loops: it dissipates or lags."
    )
    layout = {"yaxis": axis(MEASURES[component])}
    return plot("unknown", "What the unknown cause looks like", caption, variants, layout, 380, "Against")


def along(fitted: Fit, v_e: np.ndarray, f_p: np.ndarray, ends: np.ndarray) -> list[Course]:
    """The discrepancy of a free curve's fit along impacts until contact is lost, at the latest until `ends` (s)."""
    h, steps = fitted.grid.h, fitted.grid.steps
    rig, effects = unpack(fitted.explanation, jnp.asarray(fitted.physical))
    place = fitted.explanation.index(split(fitted.explanation)[1][0])
    effect, component = effects[place], component_of(fitted.explanation[place])

    def one(v: Scalar, f: Scalar) -> tuple[Motion, Scalar]:
        system = make_system(rig, Impact(v, f), effects, fitted.grid.pull)

        def added(motion: Motion, moving: Moving) -> Scalar:
            state = moving.y.states[place]
            match component:
                case "actuator":
                    return effect.force_on_mass(motion, state)
                case "contact":
                    return effect.contact_force(motion, state)
                case "robot":
                    return 1e3 * effect.robot_displacement(rig, motion.impact, motion.t, state)[0]
            return moving.signals[-1] - moving.signals[0]

        def step(moving: Moving, k: Int[Array, ""]) -> tuple[Moving, tuple[Motion, Scalar]]:
            motion = system.motion(k * h, moving.y)
            return advance(system, k, jnp.asarray(h), moving), (motion, added(motion, moving))

        return jax.lax.scan(step, start(system, jnp.asarray(h)), jnp.arange(steps))[1]

    motions, discrepancy = jax.tree.map(np.asarray, jax.jit(jax.vmap(one))(v_e, f_p))
    courses = []
    for i, end in enumerate(ends):
        stop = min(int(end / h) + 1, int(first_loss(motions.f_c[i])), steps)
        k = np.unique(np.linspace(0, stop - 1, min(POINTS, stop)).astype(int))
        m = jax.tree.map(lambda values, i=i, k=k: values[i, k], motions)
        courses.append(Course(1e3 * m.t, 1e3 * m.x, m.x_dot, 1e3 * m.s, m.s_dot, m.f_c, discrepancy[i, k]))
    return courses
