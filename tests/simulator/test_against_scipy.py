"""The simulator against SciPy: each effect's equations written a second time, in plain NumPy, solved by DOP853."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, tanh

import jax
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.signal import lsim

from acf_jax.effects import library
from acf_jax.simulator import simulate
from tests.effects.contract import IMPACT, QUICK, RIG, SAMPLES, H, make, run, start

M, D, K_F, K_C = (float(value) for value in (RIG.m, RIG.d, RIG.k_f, RIG.k_c))
V, F_P = float(IMPACT.v_e), float(IMPACT.f_p)
TIME = H * np.arange(SAMPLES)


@dataclass(frozen=True)
class Truth:
    """Right-hand sides of m x'' + d x' + k_F x = F_C + force, F_C = contact(s, s') and y' = state_rates(...)."""

    contact: Callable = lambda t, s, s_dot, y: K_C * s + F_P
    force: Callable = lambda t, x_dot, f_c, y: 0.0
    robot: Callable = lambda t, y: (0.0, 0.0)  # displacement and velocity besides v t
    pad: Callable = lambda y: (0.0, 0.0)
    state_rates: Callable = lambda t, s_dot, x_ddot, f_c, y: ()
    n_state: int = 0
    release: float = 0.0  # s, the flange is held until then
    filter: tuple | None = None  # numerator and denominator in s

    def solve(self, tool_mass: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Sensed and contact force at TIME; the sensor reads F_C less the inertia of a tool."""

        def contact(t, z):
            x, x_dot, *y = z
            (r, r_dot), (p, p_dot) = self.robot(t, y), self.pad(y)
            s_dot = V + r_dot - x_dot - p_dot
            return self.contact(t, V * t + r - x - p, s_dot, y), s_dot

        def rates(t, z):
            x, x_dot, *y = z
            f_c, s_dot = contact(t, z)
            x_ddot = (f_c + self.force(t, x_dot, f_c, y) - D * x_dot - K_F * x) / M
            return [x_dot, x_ddot, *self.state_rates(t, s_dot, x_ddot, f_c, y)]

        z_0 = np.zeros(2 + self.n_state)
        after = TIME[self.release <= TIME]
        options = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-13, "max_step": 2e-4}
        moving = solve_ivp(rates, (self.release, TIME[-1]), z_0, t_eval=after, **options).y.T
        held = np.zeros((SAMPLES - len(after), 2 + self.n_state))
        forces = np.array([contact(t, z)[0] for t, z in zip(TIME, [*held, *moving], strict=True)])
        x_ddot = np.array([0.0] * len(held) + [rates(t, z)[1] for t, z in zip(after, moving, strict=True)])
        behind = forces - tool_mass * x_ddot
        return (lsim(self.filter, behind, TIME)[1] if self.filter else behind), forces


def coulomb_friction(f_c, mu, v_s):
    return Truth(force=lambda t, x_dot, *_: -(f_c + mu * F_P) * tanh(x_dot / v_s))


def gravity(f_g):
    return Truth(force=lambda *_: f_g)


def force_regulation(hz, valve_hz):
    return Truth(
        force=lambda t, x_dot, f_c, y: -y[0],
        state_rates=lambda t, s_dot, x_ddot, f_c, y: (
            2 * pi * hz * (y[1] - y[0]),
            2 * pi * valve_hz * (F_P - y[1]),
        ),
        n_state=2,
    )


def end_stop(sigma, sigma_o):
    return Truth(
        contact=lambda t, s, *_: K_C * s + (1 - sigma) * F_P,
        force=lambda *_: -sigma_o * F_P,
        release=sigma * F_P / (K_C * V),
    )


def pretension_error(a, b, rise):
    acting = (1 + a) * F_P + b
    return Truth(
        contact=lambda t, s, *_: K_C * s + acting,
        force=lambda t, *_: -(F_P - acting) * (1 - np.exp(-t / rise)),
    )


def contact_damping(c, chi, c_2):
    def contact(t, s, s_dot, y):
        return K_C * s + F_P + (c + chi * max(s + F_P / K_C, 0) + c_2 * abs(s_dot)) * s_dot

    return Truth(contact=contact)


def contact_hardening(excess, gain, q):
    def law(whole):
        power = 100 * (K_C * abs(whole) / (100 * (1 + excess))) ** (1 + excess)
        return np.sign(whole) * power + gain * K_C * whole * (abs(whole) / 1e-3) ** q

    at_rest = brentq(lambda whole: law(whole) - F_P, 0.0, 0.1, xtol=1e-16)
    return Truth(contact=lambda t, s, *_: law(at_rest + s))


def pad_bottoming(ratio, s_b):
    def law(whole):
        return K_C * (whole + ratio * max(whole - s_b, 0))

    at_rest = brentq(lambda whole: law(whole) - F_P, 0.0, 0.1, xtol=1e-16)
    return Truth(contact=lambda t, s, *_: law(at_rest + s))


def pad_relaxation(a, p, tau):  # as a relaxed spring with a Maxwell branch beside it
    return Truth(
        contact=lambda t, s, s_dot, y: (1 - a) * K_C * s + F_P * (1 - p * (1 - np.exp(-t / tau))) + y[0],
        state_rates=lambda t, s_dot, x_ddot, f_c, y: (a * K_C * s_dot - y[0] / tau,),
        n_state=1,
    )


def pad_mass(m_p, hz, zeta):
    k_p, d_p = m_p * (2 * pi * hz) ** 2, 2 * zeta * m_p * 2 * pi * hz
    return Truth(
        pad=lambda y: (y[0], y[1]),
        force=lambda t, x_dot, f_c, y: F_P + k_p * y[0] + d_p * y[1] - f_c,
        state_rates=lambda t, s_dot, x_ddot, f_c, y: (
            y[1],
            (f_c - F_P - k_p * y[0] - d_p * y[1]) / m_p - x_ddot,
        ),
        n_state=2,
    )


def robot_compliance(inverse_mass, hz, zeta):
    omega = 2 * pi * hz
    return Truth(
        robot=lambda t, y: (y[0], y[1]),
        state_rates=lambda t, s_dot, x_ddot, f_c, y: (
            y[1],
            -inverse_mass * f_c - 2 * zeta * omega * y[1] - omega**2 * y[0],
        ),
        n_state=2,
    )


def robot_deceleration(a, b, t_0):
    brake = a + b * V

    def rates(t, y):  # the robot's own position, speed and acceleration as states
        wanted = -brake if t_0 < t < t_0 + V / brake else 0.0
        return y[1], y[2], (wanted - y[2]) / t_0

    return Truth(
        robot=lambda t, y: (y[0], y[1]), state_rates=lambda t, s_dot, x_ddot, f_c, y: rates(t, y), n_state=3
    )


def sensor_lag(tau, zeta):
    return Truth(filter=([1.0], [tau**2, 2 * zeta * tau, 1.0]))


def sensor_resonance(share, share_2, hz, ratio, zeta, zeta_2):
    def mode(omega, zeta):
        return np.array([omega**2]), np.array([1, 2 * zeta * omega, omega**2])

    omega = 2 * pi * hz
    (y_1, rest_1), (y_2, rest_2) = mode(omega, zeta), mode(ratio * omega, zeta_2)
    whole = np.polymul(rest_1, rest_2)
    ringing = share * np.polymul(y_1, rest_2) + share_2 * np.polymul(y_2, rest_1)
    return Truth(filter=(np.polyadd(ringing, (1 - share - share_2) * whole), whole))


def fixture_mass(m_w, k_w, tau):
    return Truth(filter=([tau, 1.0], [m_w / k_w, tau, 1.0]))


def sensor_scale(gain_error):
    return Truth(filter=([1 + gain_error], [1.0]))


def test_every_effect_has_its_second_opinion():
    assert [name for name in library() if name not in globals()] == []


CORNERS = {"pad_bottoming": 0.02}  # N, where a law has a corner: steps across it are of second order


@pytest.mark.parametrize("name", library())
def test_simulator_equals_scipy(name):
    for which in (0, -1):
        theta = start(library()[name], which)
        response = run(library()[name], [theta], pull=1.0)  # the equations' own continuation
        sensed, contact = globals()[name](*theta).solve()
        allowed = CORNERS.get(name, 2e-3)
        assert np.allclose(response.contact[0], contact, rtol=0, atol=allowed)
        assert np.allclose(response.sensed[0], sensed, rtol=0, atol=allowed)


@pytest.mark.parametrize("name", ["gravity", "end_stop", "pad_mass", "sensor_lag"])
def test_a_sensor_on_the_robots_side_reads_the_force_less_the_inertia_of_the_tool(name):
    kind, tool_mass = library()[name], 1.8
    theta = start(kind, -1)

    @jax.jit(compiler_options=QUICK)
    def response():
        return simulate(RIG, IMPACT, make((kind,), theta), H, SAMPLES, pull=1.0, tool_mass=tool_mass)

    found = response()
    sensed, contact = globals()[name](*theta).solve(tool_mass)
    assert np.allclose(found.contact, contact, rtol=0, atol=2e-3)
    assert np.allclose(found.sensed, sensed, rtol=0, atol=2e-2)
    assert np.abs(sensed - globals()[name](*theta).solve()[0]).max() > 10.0
