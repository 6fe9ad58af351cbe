"""The equations of motion of rig and causes, solved by LSODA.

    m x'' + d x' + k_F x = F - opposing forces,   F_C = contact(s, s'),   s = s_0 + v t + offset - face

Without causes F = F_C = k_C s and face = x: Eqs. (1) and (2) of the paper, contact being lost at s = 0.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline
from scipy.optimize import brentq

from validation.worlds.interface import AbstractWorld, Array, Impact, Response, Rig
from validation.worlds.scipy_world.hooks import (
    AbstractActuatorCause,
    AbstractContactCause,
    AbstractRobotCause,
    AbstractScipyCause,
    AbstractSeatCause,
    AbstractSensorCause,
    Motion,
    Value,
    positive,
)

RTOL, ATOL = 1e-8, 1e-10  # 1e-10 m of compression is below 1e-4 N at any contact stiffness drawn
FINE = 16  # steps of a sensor's grid in one sample: its interpolation is then below 0.001 N


class Plant:
    """Rig, causes and one impact: the right-hand side, and the contact force along a solution."""

    def __init__(self, rig: Rig, causes: Sequence[AbstractScipyCause], impact: Impact):
        self.causes = sorted(causes, key=lambda cause: cause.stage)
        self.actuator = [(i, c) for i, c in enumerate(self.causes) if isinstance(c, AbstractActuatorCause)]
        self.laws = [(i, c) for i, c in enumerate(self.causes) if isinstance(c, AbstractContactCause)]
        self.robot = [(i, c) for i, c in enumerate(self.causes) if isinstance(c, AbstractRobotCause)]
        self.seats = [(i, c) for i, c in enumerate(self.causes) if isinstance(c, AbstractSeatCause)]
        if len(self.seats) > 1:
            raise ValueError("two causes between contact and flange mass cannot act together; leave one out")

        start = impact.f_p
        for _, cause in self.actuator:
            start = cause.acting(start)
        self.rig, self.impact = rig, Impact(impact.v_e, start)
        for _, cause in self.actuator:
            start *= cause.start_share()
        self.s_0 = self._compression_at(start)
        states = [cause.initial(rig, self.s_0, start) for cause in self.causes]
        ends = 2 + np.cumsum([0, *(len(state) for state in states)])
        self.places = [slice(int(a), int(b)) for a, b in pairwise(ends)]
        self.initial = np.array([0.0, 0.0, *(value for state in states for value in state)])

    def _compression_at(self, force: float) -> float:
        """The compression s_0 at which the contact at rest carries `force`."""

        def excess(s: float) -> float:
            states = {i: cause.initial(self.rig, s, force) for i, cause in self.laws}
            return float(self._law(states, s, 0.0)) - force

        if force <= 0.0:
            return 0.0
        nominal = force / self.rig.k_c
        return float(brentq(excess, 1e-3 * nominal, 30.0 * nominal, xtol=1e-15, rtol=1e-13))

    def _law(self, states: Any, s: Value, s_rate: Value) -> Value:
        force = self.rig.k_c * positive(s)
        for i, cause in self.laws:
            force = cause.contact(force, states[i], self.rig, self.impact, s, s_rate)
        return force

    def compression(self, t: Value, y: Any, states: Any) -> tuple[Value, Value]:
        """Compression of the contact and its rate, m and m/s."""
        s, s_rate = self.s_0 + self.impact.v_e * t, self.impact.v_e
        for i, cause in self.robot:
            lead, lead_rate = cause.offset(t, states[i], self.rig, self.impact)
            s, s_rate = s + lead, s_rate + lead_rate
        face, face_rate = (y[0], y[1])
        for i, seat in self.seats:
            face, face_rate = seat.face(states[i])
        return s - face, s_rate - face_rate

    def contact_force(self, t: Value, y: Any) -> Value:
        """F_C at one instant (y of shape (k,)) or along a solution (y of shape (k, n)), N."""
        states = [y[place] for place in self.places]
        return self._law(states, *self.compression(t, y, states))

    def rates(self, t: float, vector: Array) -> list[float]:
        """Time derivative of the state vector."""
        rig, impact, y = self.rig, self.impact, vector.tolist()
        states = [y[place] for place in self.places]
        s, s_rate = self.compression(t, y, states)
        f_c = self._law(states, s, s_rate)
        now = Motion(t, y[0], y[1], s, s_rate, f_c)

        on_mass = f_c
        for i, seat in self.seats:
            on_mass = seat.transmitted(states[i], rig, impact, now.x, now.x_rate)
        for i, actuator in self.actuator:
            on_mass -= actuator.opposing(states[i], rig, impact, now)
        derivative = [now.x_rate, (on_mass - rig.d * now.x_rate - rig.k_f * now.x) / rig.m]
        for i, cause in enumerate(self.causes):
            derivative.extend(cause.rates(states[i], rig, impact, now))
        return derivative


class Trajectory:
    """The solved motion up to `end` or, where contact is lost, to `after_loss` past the loss."""

    def __init__(self, plant: Plant, end: float, after_loss: float):
        def in_contact(t: float, y: Array) -> float:
            return float(plant.contact_force(t, y)) - 0.01

        in_contact.terminal, in_contact.direction = True, -1.0  # type: ignore[attr-defined]
        self._plant = plant
        self._before = _solve(plant, 0.0, end, plant.initial, in_contact)
        self.lost = float(self._before.t[-1]) if self._before.status == 1 else np.inf
        self.end = min(self.lost + after_loss, end)
        self._after = self._before
        if self.end > self.lost:
            self._after = _solve(plant, self.lost, self.end, self._before.y[:, -1], None)

    def contact_force(self, time: Array) -> Array:
        """F_C at increasing instants between 0 and `end`, shape (n,), N."""
        force = np.zeros_like(time)
        early = time <= self.lost
        for chosen, solved in ((early, self._before), (~early, self._after)):
            if chosen.any():
                force[chosen] = self._plant.contact_force(time[chosen], solved.sol(time[chosen]))
        return force


def _solve(plant: Plant, start: float, stop: float, y: Array, events: Any) -> Any:
    found = solve_ivp(
        plant.rates, (start, stop), y, "LSODA", dense_output=True, events=events,
        rtol=RTOL, atol=ATOL, max_step=plant.rig.half_period / 20.0,  # no step may jump over a rebound
    )  # fmt: skip
    if found.status < 0:
        raise RuntimeError(f"integration failed at t = {found.t[-1]:.6g} s: {found.message}")
    return found


class ScipyWorld(AbstractWorld):
    """The paper's model and its causes as ordinary differential equations."""

    name: ClassVar[str] = "scipy"

    def respond(
        self, rig: Rig, causes: Sequence[Any], impact: Impact, time: Array, after_loss: float = 0.0
    ) -> Response:
        sensors = [cause for cause in causes if isinstance(cause, AbstractSensorCause)]
        step = float(f"{time[-1] - time[-2]:.9g}") / FINE
        trajectory = Trajectory(Plant(rig, causes, impact), float(time[-1]) + step, after_loss)
        time = time[time <= trajectory.end]
        touching = time >= 0.0
        contact = np.zeros_like(time)
        contact[touching] = trajectory.contact_force(time[touching])
        sensed = contact.copy()
        if sensors:
            # The grid may end before the last sample by less than a step: the spline carries on that far.
            fine = step * np.arange(int(trajectory.end / step) + 1)
            reading = trajectory.contact_force(fine)
            for cause in sensors:
                reading = cause.read(fine, reading)
            sensed[touching] = make_interp_spline(fine, reading, k=3)(time[touching])
        return Response(time, sensed, contact, trajectory.lost)
