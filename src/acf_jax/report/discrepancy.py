"""What an unknown cause looks like: the free discrepancy of its port along the trials."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.fit import Fit
from acf_jax.diagnosis.forward import forward, unpack
from acf_jax.diagnosis.sample import first_loss
from acf_jax.diagnosis.score import UNKNOWN, is_port
from acf_jax.diagnosis.space import component_of
from acf_jax.effects import Motion
from acf_jax.model import Impact
from acf_jax.report.markup import Html
from acf_jax.report.plot import Variant, axis, plot, series
from acf_jax.report.words import condition, percent

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
    if UNKNOWN not in d.credible and d.scored[0].explanation != UNKNOWN:
        return None
    fitted, p = max(
        ((f, p) for f, p in zip(d.fits, d.probability, strict=True) if is_port(f.explanation)),
        key=lambda item: item[1],
    )
    component = component_of(fitted.explanation[0])
    o = d.observations
    first = [int(np.flatnonzero(o.condition == c)[0]) for c in np.unique(o.condition)]
    first.sort(key=lambda i: (o.v_e[i], o.f_p[i]))
    chosen = [
        first[k]
        for k in np.unique(np.linspace(0, len(first) - 1, min(SHOWN, len(first))).round().astype(int))
    ]
    ends = [float(o.time[i, o.used[i]].max()) or fitted.grid.h * fitted.grid.steps for i in chosen]
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
    """The discrepancy of a port's fit along impacts until contact is lost, at the latest until `ends` (s).

    The fitted contact force drives the flange, m x'' + d x' + k_F x = F_C + F_discrepancy, by Heun's method.
    """
    grid = fitted.grid
    theta = fitted.theta[:-1]
    forces = forward(fitted.explanation, theta, v_e, f_p, grid)
    rig, (effect,) = unpack(fitted.explanation, jnp.asarray(theta))
    component = component_of(fitted.explanation[0])

    def see(t, y, f_c, impact):  # type: ignore[no-untyped-def]
        x, x_dot, own = y
        shift, shift_rate = effect.robot_displacement(rig, impact, t, own)
        s, s_dot = impact.v_e * t + shift - x, impact.v_e + shift_rate - x_dot
        return Motion(rig, impact, t, x, x_dot, s, s_dot, impact.f_p, f_c), shift

    def rates(t, y, f_c, impact):  # type: ignore[no-untyped-def]
        motion, _ = see(t, y, f_c, impact)
        x_ddot = (f_c + effect.force_on_mass(motion, y[2]) - rig.d * y[1] - rig.k_f * y[0]) / rig.m
        return y[1], x_ddot, effect.rates(motion, x_ddot, y[2])

    def one(v, f, contact):  # type: ignore[no-untyped-def]
        impact, h = Impact(v, f), grid.h

        def step(y, k):  # type: ignore[no-untyped-def]
            motion, shift = see(k * h, y, contact[k], impact)
            added = {
                "actuator": effect.force_on_mass(motion, y[2]),
                "contact": effect.contact_force(motion, y[2]),
                "robot": 1e3 * shift,
                "sensor": jnp.zeros(()),
            }[component]
            seen = jnp.stack([motion.x, motion.x_dot, motion.s, motion.s_dot, jnp.asarray(added)])
            a = rates(k * h, y, contact[k], impact)
            ahead = jax.tree.map(lambda p, q: p + h * q, y, a)
            b = rates((k + 1) * h, ahead, contact[k + 1], impact)
            return jax.tree.map(lambda p, q, r: p + h / 2 * (q + r), y, a, b), seen

        start = (jnp.zeros(()), jnp.zeros(()), jnp.zeros(effect.n_own))
        return jax.lax.scan(step, start, jnp.arange(grid.steps))[1]

    seen = np.asarray(jax.jit(jax.vmap(one))(v_e, f_p, forces.contact))
    courses = []
    for i, end in enumerate(ends):
        stop = min(int(end / grid.h) + 1, int(first_loss(forces.contact[i])), grid.steps)
        k = np.unique(np.linspace(0, stop - 1, min(POINTS, stop)).astype(int))
        x, x_dot, s, s_dot, added = seen[i, k].T
        if component == "sensor":
            added = forces.sensed[i, k] - forces.contact[i, k]
        courses.append(Course(1e3 * grid.h * k, 1e3 * x, x_dot, 1e3 * s, s_dot, forces.contact[i, k], added))
    return courses
