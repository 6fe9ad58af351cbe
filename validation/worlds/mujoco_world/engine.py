"""Compiling a scene, running it, and reading it out."""

from collections.abc import Sequence
from typing import Any, ClassVar

import mujoco
import numpy as np
from mujoco import rollout
from scipy.interpolate import make_interp_spline

from validation.worlds.interface import AbstractWorld, Array, Impact, Response, Rig
from validation.worlds.mujoco_world.scene import Scene

LONGEST_STEP = 1.25e-5  # s
CHUNK = 0.004  # s, run before looking whether contact is lost
STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS


class MujocoWorld(AbstractWorld):
    """The paper's model and its causes in MuJoCo, integrated by its fourth-order Runge-Kutta method."""

    name: ClassVar[str] = "mujoco"

    def respond(
        self, rig: Rig, causes: Sequence[Any], impact: Impact, time: Array, after_loss: float = 0.0
    ) -> Response:
        scene = Scene(rig, impact)
        causes = sorted(causes, key=lambda cause: cause.stage)
        for cause in causes:
            cause.build(scene)
        interval = float(f"{time[-1] - time[-2]:.9g}")
        step = interval / np.ceil(interval * max(1.0 / LONGEST_STEP, scene.fastest))
        # A tendon's damper goes on pulling once contact is lost, where a pad would let go.
        after_loss = 0.0 if any(scene.damping) else after_loss
        grid, record, lost = _run(scene, step, float(time[-1]) + 4.0 * step, after_loss + 2.0 * interval)
        contact = scene.contact_force(record)
        sensed = contact
        for cause in causes:
            sensed = cause.read(grid, sensed, record)

        time = time[time <= min(lost + after_loss, time[-1])]
        touching = time >= 0.0
        values = np.zeros((2, time.size))
        for row, force in zip(values, (sensed, contact), strict=True):
            row[touching] = make_interp_spline(grid, force, k=3)(time[touching])
        values[1] = np.maximum(values[1], 0.0)  # a spline rings at the kink where contact is lost
        return Response(time, values[0], values[1], lost)


def _run(scene: Scene, step: float, end: float, after_loss: float) -> tuple[Array, dict[str, Array], float]:
    """Time, sensors by name, and the loss of contact."""
    model = scene.compile(step)
    data = mujoco.MjData(model)
    data.qvel[model.joint("carriage").dofadr[0]] = scene.impact.v_e
    state = np.zeros(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, state, STATE)
    steps = int(np.ceil(end / step)) + 1
    controls = np.stack(
        [np.broadcast_to(f(step * np.arange(steps)), steps) for f in scene.controls] or [np.empty(steps)][:0],
        axis=1,
    ) if scene.controls else None  # fmt: skip
    names = [model.sensor(i).name for i in range(model.nsensor)]
    chunk = int(np.ceil(CHUNK / step))
    parts: list[Array] = []
    done, lost = 0, np.inf
    while done < steps and step * done <= lost + after_loss:
        n = min(chunk, steps - done)
        control = None if controls is None else controls[None, done : done + n]
        states, sensed = rollout.rollout(model, data, state, control, nstep=n)
        state = states[0, -1]
        parts.append(sensed[0])
        done += n
        if lost == np.inf:
            values = np.concatenate(parts)
            force = scene.contact_force(dict(zip(names, values.T, strict=True)))
            lost = _loss(step * np.arange(force.size), force)
    values = np.concatenate(parts)
    return step * np.arange(len(values)), dict(zip(names, values.T, strict=True)), lost


def _loss(time: Array, force: Array) -> float:
    """Instant at which the force first falls to zero, between two points of the grid; infinite if never."""
    gone = np.flatnonzero((force[1:] <= 0.0) & (force[:-1] > 0.0))
    if not gone.size:
        return np.inf
    i = int(gone[0])
    slope = (force[i] - force[max(i - 1, 0)]) / (time[1] - time[0])
    return float(min(time[i + 1], time[i] - force[i] / slope) if slope < 0.0 else time[i + 1])
