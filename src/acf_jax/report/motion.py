"""How the robot moved: commanded, measured, and as the explanation has it."""

import numpy as np

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.motion import inferred_motion
from acf_jax.report.markup import Html
from acf_jax.report.plot import CORRECTED, NOMINAL, Variant, axis, plot, series
from acf_jax.report.traces import MOST
from acf_jax.report.words import condition


def robot_motion(diagnosis: Diagnosis) -> Html | None:
    """The robot's velocities with a choice of trial, the largest departure first shown; None where not measured."""
    d, o = diagnosis, diagnosis.observations
    if o.robot is None:
        return None
    by_name = {t.name: t.motion for t in d.dataset.trials}
    time, velocity = inferred_motion(o, d.corrected)
    departures = np.abs(o.robot.velocity[:, 0]).max(-1) * np.array([by_name[n] is not None for n in o.names])
    rows = sorted(i for i in np.argsort(-departures)[:MOST] if departures[i] > 0)
    variants = []
    for i in rows:
        motion = by_name[o.names[i]]
        assert motion is not None
        end = float(o.time[i, o.weighed[i]].max())
        inside = time <= end
        shown = (motion.time >= -0.5 * end) & (motion.time <= end)
        commanded = {
            "x": series(1e3 * np.array([-0.5 * end, end])), "y": series([float(o.v_e[i])] * 2), "mode": "lines",
            "line": NOMINAL, "name": "commanded",
        }  # fmt: skip
        measured = {
            "x": series(1e3 * motion.time[shown]), "y": series(motion.value[shown]), "mode": "markers",
            "marker": {"color": "--measured", "size": 5}, "name": "measured",
        }  # fmt: skip
        inferred = {
            "x": series(1e3 * time[inside]), "y": series(velocity[i, inside]), "mode": "lines",
            "line": CORRECTED, "name": "inferred",
        }  # fmt: skip
        variants.append(
            Variant(f"{o.names[i]}: {condition(o.v_e[i], o.f_p[i])}", [commanded, measured, inferred])
        )
    caption = (
        "The velocity of the robot towards the part. Inferred: the measured one within its error and delay, fitted to"
        " the force, with what the explanation's effects add behind the robot's encoders."
    )
    layout = {"xaxis": axis("time since first contact / ms"), "yaxis": axis("robot velocity / m/s")}
    first = rows.index(int(np.argmax(departures)))
    return plot("motion", "Motion of the robot", caption, variants, layout, 340, "Trial", first)
