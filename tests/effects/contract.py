"""The rules that every effect keeps. `test_effects.py` runs each rule on each effect that the library finds."""

import functools
import inspect
import re
from collections.abc import Callable
from typing import get_args

import jax
import jax.numpy as jnp
import numpy as np

from acf_jax.effects import AbstractEffect, Motion, Parameter
from acf_jax.effects._interface import Component
from acf_jax.inference.parameters import TYPICAL
from acf_jax.model import Impact, Rig
from acf_jax.simulator import Response, simulate

Kind = type[AbstractEffect]
RIG, IMPACT = Rig(m=3.0, d=30.0, k_f=1e3, k_c=1.2e5), Impact(v_e=0.21, f_p=80.0)
SAMPLES, H = 257, 5e-5  # 12.8 ms: past the peak, contact not yet lost
LONG = 4 * H  # past the loss of contact
QUICK = {"xla_backend_optimization_level": 0}  # compiling is what these tests wait for, not running
RULES: list[Callable[[Kind], None]] = []


def rule(check: Callable[[Kind], None]) -> Callable[[Kind], None]:
    RULES.append(check)
    return check


def make(kinds: tuple[Kind, ...], theta: jax.Array) -> list[AbstractEffect]:
    """The effects whose parameters, one after the other, are `theta`."""
    ends = np.cumsum([len(kind.parameters()) for kind in kinds])
    return [kind(*theta[end - len(kind.parameters()) : end]) for kind, end in zip(kinds, ends, strict=True)]


@functools.cache
def _program(kinds: tuple[Kind, ...], with_tangents: bool) -> Callable:
    """One compiled program for all rules that look at the same effects."""

    def forces(theta, impact, h, pull):
        return simulate(RIG, impact, make(kinds, theta), h, SAMPLES, pull=pull)

    def with_derivatives(theta, impact, h, pull):
        def along(direction):
            return jax.jvp(lambda theta: forces(theta, impact, h, pull), (theta,), (direction,))

        return jax.vmap(along, out_axes=(None, 0))(jnp.eye(theta.size))

    one = with_derivatives if with_tangents else forces
    return jax.jit(jax.vmap(one, in_axes=(0, None, None, None)), compiler_options=QUICK)


def _padded(kind: Kind, rows, impact, h, pull) -> tuple[Response, Response]:
    """Every call has as many rows as a cube has corners, so that an effect is compiled once."""
    rows, program = np.array(rows), _program((kind,), True)
    places = np.arange(-(-len(rows) // 8) * 8).reshape(-1, 8) % len(rows)
    results = [program(rows[place], impact, h, pull) for place in places]
    return jax.tree.map(lambda *leaves: np.concatenate(leaves)[: len(rows)], *results)


def run(kind: Kind, rows, impact=IMPACT, h=H, pull=0.0) -> Response:
    """Forces for each row of the effect's parameters, leaves of shape (rows, SAMPLES)."""
    return _padded(kind, rows, impact, h, pull)[0]


def tangents(kind: Kind, rows, impact=IMPACT, h=H, pull=0.0) -> Response:
    """Derivatives of `run` by forward mode, leaves of shape (rows, parameters, SAMPLES)."""
    return _padded(kind, rows, impact, h, pull)[1]


def run_company(kinds: tuple[Kind, ...], rows) -> Response:
    return jax.tree.map(np.asarray, _program(kinds, False)(np.array(rows), IMPACT, H, 0.0))


@functools.cache
def nominal(impact: tuple[float, float] = (0.21, 80.0), h: float = H, pull: float = 0.0) -> np.ndarray:
    return np.asarray(simulate(RIG, Impact(*impact), [], h, SAMPLES, pull=pull).contact)


def neutral(kind: Kind) -> np.ndarray:
    return np.array([p.scale if p.shape else 0.0 for p in kind.parameters()])


def start(kind: Kind, which: int, weaken: float = 1.0) -> np.ndarray:
    """Where fits begin: the first (weak) or last (strong) start of every parameter, of one that is sought its scale."""
    at = [p.scale if p.over and which else begins(p)[which] for p in kind.parameters()]
    return np.array([x * (1.0 if p.shape else weaken) for x, p in zip(at, kind.parameters(), strict=True)])


def begins(p: Parameter) -> list[float]:
    """The starts of a parameter for trials as they typically are."""
    return [value * getattr(TYPICAL, p.of) if p.of else value for value in p.starts]


@rule
def neutral_limit_is_the_papers_model(kind: Kind) -> None:
    rows = [[getattr(p, end) if p.shape else 0.0 for p in kind.parameters()] for end in ("low", "high")]
    for v_e, f_p, h, pull in ((0.21, 80.0, H, 0.0), (0.21, 80.0, LONG, 1.0), (0.1, 0.0, LONG, 0.0)):
        for force in run(kind, rows, Impact(v_e, f_p), h, pull):
            assert np.allclose(force, nominal((v_e, f_p), h, pull), rtol=0, atol=1e-9)


@rule
def parameters_are_known(kind: Kind) -> None:
    parameters = kind.parameters()
    modes = 1 + sum(p.over is not None for p in parameters)
    assert 1 <= len(parameters) <= 3 * modes, "at most three parameters, and as many of a second mode"
    assert not parameters[0].shape, "the first parameter is a strength"
    assert [p.shape for p in parameters] == sorted(p.shape for p in parameters), "strengths first"
    for p in parameters:
        assert p.unit and p.meaning and p.scale > 0 and p.starts, p.name
        assert all(p.low <= value <= p.high for value in begins(p)), p.name
        assert p.low > 0 if p.shape else p.low <= 0 <= p.high, p.name
    assert any(value for p in parameters if not p.shape for value in p.starts), "a start has a strength"


@rule
def it_is_described(kind: Kind) -> None:
    text = inspect.getdoc(kind)
    assert kind.title and text and kind.remedy and kind.remedy[0].islower() and kind.remedy[-1] != "."
    assert "=" in text, "the docstring gives the equation"
    assert re.search(r"\b(19|20)\d\d\b|[Pp]aper", text), "the docstring gives a source, with its year"
    assert inspect.getmodule(kind).__file__.endswith(f"/{kind.id()}.py")


@rule
def it_acts_where_it_says(kind: Kind) -> None:
    assert kind.component in get_args(Component)
    response = run(kind, [start(kind, -1)])
    if kind.component == "sensor":
        assert np.allclose(response.contact, nominal(), rtol=0, atol=1e-9)
        assert np.abs(response.sensed - nominal()).max() > 0.1
    else:
        assert kind.sense is AbstractEffect.sense  # nobody asks for it away from the sensor
        # without derivatives: beside them XLA may compute the two apart
        plain = _program((kind,), False)(np.array([start(kind, -1)]), IMPACT, H, 0.0)
        assert np.array_equal(plain.sensed, plain.contact)
        assert np.abs(response.contact - nominal()).max() > 0.1


@rule
def jvp_equals_finite_differences(kind: Kind) -> None:
    for which in (0, -1):
        at = start(kind, which)
        steps = np.diag([1e-6 * max(abs(x), p.scale) for x, p in zip(at, kind.parameters(), strict=True)])
        up, down = (run(kind, at + sign * steps, pull=1.0) for sign in (1, -1))
        exact = tangents(kind, [at], pull=1.0)
        for above, below, jvp in zip(up, down, exact, strict=True):
            difference = (above - below) / (2 * np.diag(steps)[:, None])
            scale = np.abs(difference).max(axis=1, keepdims=True)
            assert np.isfinite(jvp).all()
            assert (np.abs(jvp[0] - difference) <= 1e-5 * scale + 1e-6).all()


@rule
def response_is_continuous_at_the_neutral_limit(kind: Kind) -> None:
    """The first sample does not count: even the fastest sensor has not seen the jump of the force then."""
    fading = [run(kind, [start(kind, -1, weaken)]).sensed[:, 1:] for weaken in (1.0, 1e-3, 1e-6)]
    strong, weak, weakest = (np.abs(force - nominal()[1:]).max() for force in fading)
    assert weak < 0.1 * strong and weakest < 1e-3 * strong


@rule
def it_is_finite_within_its_bounds(kind: Kind) -> None:
    ends = [(p.low, p.high) for p in kind.parameters()]
    corners = np.array(np.meshgrid(*ends)).reshape(len(ends), -1).T
    assert all(np.isfinite(leaf).all() for leaf in run(kind, corners))


@rule
def it_supplies_no_energy(kind: Kind) -> None:
    """Without pretension nothing supplies energy: over a closed stroke of contact and flange none comes out."""
    if kind.component == "sensor":
        return
    rows = np.array([start(kind, 0), start(kind, -1)])
    absorbed, exchanged = jax.vmap(lambda theta: _closed_stroke(make((kind,), theta)[0]))(rows)
    assert (absorbed >= -1e-6 * exchanged).all()


@jax.jit
def _closed_stroke(effect: AbstractEffect) -> tuple[jax.Array, jax.Array]:
    """Energy that flows into the effect through its hooks while x and s go out and back, and its absolute sum, J."""
    impact, n, duration = Impact(v_e=0.2, f_p=0.0), 4000, 0.02
    h, turn = duration / n, 2 * jnp.pi / duration

    def motion(t, state):
        x, x_dot = 1e-3 * (1 - jnp.cos(turn * t)), 1e-3 * turn * jnp.sin(turn * t)
        s, s_dot = 0.5 * x, 0.5 * x_dot
        now = Motion(RIG, impact, impact.f_p, t, x, x_dot, s, s_dot, jnp.asarray(0.0), RIG.k_c * s)
        return now._replace(f_c=now.f_c + effect.contact_force(now, state))

    def onward(state, span, rates):
        return tuple(value + span * rate for value, rate in zip(state, rates, strict=True))

    def body(k, carry):
        state, absorbed, exchanged = carry
        t = k * h
        half = onward(state, h / 2, effect.rates(motion(t, state), 1e-3 * turn**2 * jnp.cos(turn * t), state))
        now = motion(t + h / 2, half)
        x_ddot = 1e-3 * turn**2 * jnp.cos(turn * now.t)
        power = (
            effect.contact_force(now, half) * now.s_dot
            - effect.force_on_mass(now, half) * now.x_dot
            + now.f_c * effect.pad_displacement(half)[1]
            - now.f_c * effect.robot_displacement(RIG, impact, now.t, half)[1]
        )
        state = onward(state, h, effect.rates(now, x_ddot, half))
        return state, absorbed + h * power, exchanged + h * jnp.abs(power)

    nothing = (jnp.zeros(()),) * effect.n_state, jnp.asarray(0.0), jnp.asarray(0.0)
    return jax.lax.fori_loop(0, n, body, nothing)[1:]
