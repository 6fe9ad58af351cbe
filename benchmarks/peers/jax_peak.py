"""The exact peak of `acf_jax.model`, and the same question put to stock optimistix and to diffrax.

All run on all cores: each of JAX's CPU devices, one a core, has its share of the batch.
"""

from collections.abc import Callable
from math import factorial
from typing import Any

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx

from acf_jax.kept import VECTORS
from acf_jax.model import Impact, Peak, Rig, contact_force, contact_force_rate, find_peak, find_peaks
from acf_jax.model.blocks import in_blocks
from acf_jax.model.carlson import carlson_rc
from benchmarks.box import Box, take
from benchmarks.peers.bracket import Bracket, guess
from benchmarks.peers.peer import Peer

Scalar = jax.Array


def _shares(*arrays: Any) -> list[Any]:
    """The batch (N,) in parts of equal size, one on each CPU device."""
    devices, size = jax.devices("cpu"), len(jax.tree.leaves(arrays)[0])
    edges = [size * i // len(devices) for i in range(len(devices) + 1)]
    return [
        jax.device_put(jax.tree.map(lambda a: a[start:stop], arrays), device)  # noqa: B023
        for device, start, stop in zip(devices, edges[:-1], edges[1:], strict=True)
    ]


def on_all_cores(
    function: Callable[..., Any], *arrays: Any, options: dict[str, Any] | None = None
) -> Callable[[], list[Any]]:
    """A call of `function(*arrays)`, batched over (N,), with a share of the batch on each CPU device.

    XLA runs one program on one device at a time, and splits a block of this size over threads badly.
    """
    runs = [
        (jax.jit(function, compiler_options=options).lower(*share).compile(), share)
        for share in _shares(*arrays)
    ]
    return lambda: jax.block_until_ready([compiled(*share) for compiled, share in runs])


def _joined(shares: list[Any]) -> Any:
    return jax.tree.map(lambda *parts: np.concatenate([np.asarray(p) for p in parts]), *shares)


def _parameters(box: Box) -> tuple[Rig, Impact]:
    return Rig(*box[:4]), Impact(*box[4:])


def _peak_peer(name: str, function: Callable[..., Any], box: Box) -> Peer:
    """In vectors as wide as `find_peaks` asks for."""
    return _forces_and_times(name, on_all_cores(function, *_parameters(box), options=VECTORS), box)


def _forces_and_times(name: str, call: Callable[[], list[Any]], box: Box) -> Peer:
    return Peer(name, call, lambda shares: np.stack(_joined(shares)[:2]), np.arange(len(box.m)))


def exact(box: Box) -> Peer:
    """As a user calls it: it compiles itself."""
    shares = _shares(*_parameters(box))
    return _forces_and_times(
        "JAX, find_peaks", lambda: jax.block_until_ready([find_peaks(*share) for share in shares]), box
    )


def optimistix_route(box: Box) -> Peer:
    """One sample by the project's own solver in optimistix, mapped over blocks of the batch."""
    return _peak_peer("optimistix, find_peak mapped", in_blocks(find_peak), box)


def _sine(zeta: Scalar, eta_squared: Scalar, sigma: Scalar) -> Scalar:
    """s(sigma) = e^{-zeta sigma} sin(eta sigma)/eta by its series, right in the whole bracket."""
    z = eta_squared * sigma * sigma
    sine = jnp.zeros_like(z)
    for j in range(10, -1, -1):
        sine = 1 / factorial(2 * j + 1) - z * sine
    return jnp.exp(-zeta * sigma) * sigma * sine


def _stock(name: str, solver: optx.AbstractRootFinder, box: Box) -> Peer:
    """A solver as optimistix ships it, on the reduced equation s(sigma) = r of `acf_jax.model`."""

    def equation(sigma: Scalar, args: tuple[Scalar, Scalar, Scalar]) -> Scalar:
        zeta, eta_squared, r = args
        return _sine(zeta, eta_squared, sigma) - r

    def one(rig: Rig, impact: Impact) -> Peak:
        zeta, kappa, epsilon = rig.zeta, rig.k_c / rig.k, rig.k_f / rig.k
        momentum = rig.m * rig.omega * impact.v_e
        a, eta_squared = impact.f_p / momentum - kappa * zeta, (1 - zeta) * (1 + zeta)
        q = a * a + kappa * kappa * eta_squared
        is_turning = (eta_squared > 0) | ((a > 0) & (q > 0))
        root_q = jnp.sqrt(jnp.where(is_turning, q, 1.0))
        angle = kappa * carlson_rc(jnp.abs(a), root_q)
        tau_0 = jnp.where(a < 0, jnp.pi / jnp.sqrt(jnp.maximum(eta_squared, 1e-300)) - angle, angle)
        w = root_q * jnp.exp(-zeta * tau_0)
        sigma_m = carlson_rc(zeta, jnp.ones_like(zeta))
        r_m = jnp.exp(-zeta * sigma_m)
        has_peak = is_turning & (epsilon < w * r_m)
        r = jnp.where(has_peak, epsilon / w, r_m / 2)
        start = guess(zeta, sigma_m, r_m, jnp.sqrt(1 - r / r_m))
        options = {"lower": jnp.zeros_like(sigma_m), "upper": sigma_m}
        args = (zeta, eta_squared, r)
        sigma = optx.root_find(equation, solver, start, args, options, max_steps=64, throw=False).value
        s, slope = jax.jvp(lambda sigma: _sine(zeta, eta_squared, sigma), (sigma,), (jnp.ones_like(sigma),))
        tau = tau_0 + sigma
        force = epsilon * tau + 2 * zeta * kappa + w * (slope + 2 * zeta * s)
        return Peak(impact.f_p * epsilon + kappa * momentum * force, tau / rig.omega, has_peak)

    return _peak_peer(name, in_blocks(one), box)


def optimistix_newton(box: Box, tolerance: float) -> Peer:
    return _stock("optimistix.Newton", optx.Newton(0.0, tolerance), box)


def optimistix_bisection(box: Box, tolerance: float) -> Peer:
    # `flip` is given: finding it out raises for the whole batch.
    return _stock("optimistix.Bisection", optx.Bisection(0.0, tolerance, flip=False), box)


def diffrax_event(box: Box, ends: Bracket, tolerance: float) -> Peer:
    """t_max by integrating Eq. (3) until the event x' = v, which is Eq. (9), then F_C from Eq. (8).

    In tau = omega t and X = omega x/v: X'' + 2 zeta X' + X = kappa tau + p, event X' = 1.
    """

    def field(t: Scalar, y: Scalar, args: tuple[Scalar, ...]) -> Scalar:
        zeta, kappa, p = args
        return jnp.stack([y[1], kappa * t + p - 2 * zeta * y[1] - y[0]])

    def condition(t: Scalar, y: Scalar, args: Any, **_: Any) -> Scalar:
        return y[1] - 1.0

    term, solver = diffrax.ODETerm(field), diffrax.Tsit5()
    event = diffrax.Event(condition, optx.Newton(0.0, tolerance), direction=True)
    steps = diffrax.PIDController(rtol=1e-8, atol=1e-8)

    def one(rig: Rig, impact: Impact) -> tuple[Scalar, Scalar]:
        args = (rig.zeta, rig.k_c / rig.k, impact.f_p / (rig.m * rig.omega * impact.v_e))
        solution = diffrax.diffeqsolve(
            term, solver, 0.0, 20.0, None, jnp.zeros(2), args,
            event=event, stepsize_controller=steps, throw=False,
        )  # fmt: skip
        assert solution.ts is not None
        t_max = solution.ts[0] / rig.omega
        return contact_force(rig, impact, t_max), t_max

    call = on_all_cores(in_blocks(one), *_parameters(take(box, ends.chosen)))
    return Peer("diffrax with an event", call, lambda shares: np.stack(_joined(shares)), ends.chosen)


def envelope_gradient(box: Box, ends: Bracket) -> Peer:
    """dF_max with respect to all six parameters, as `find_peaks` differentiates: by the envelope theorem."""

    def total(both: tuple[Rig, Impact]) -> Scalar:
        return find_peaks(*both).f_max.sum()

    def gradient(rig: Rig, impact: Impact) -> tuple[Rig, Impact]:
        return jax.grad(total)((rig, impact))

    call = on_all_cores(gradient, *_parameters(take(box, ends.chosen)))
    return Peer("JAX, jax.grad of find_peaks", call, _force_slope, ends.chosen)


def _force_slope(shares: list[Any]) -> Any:
    return _joined(shares)[1].f_p[None]


def _through_root_find(
    name: str, adjoint: optx.AbstractAdjoint, box: Box, ends: Bracket, tolerance: float
) -> Peer:
    """The same gradient through optimistix's Newton on Eq. (9), from the guess, given for nothing."""

    def f_max(both: tuple[Rig, Impact], tau: Scalar, omega: Scalar) -> Scalar:
        def rate(tau: Scalar, both: tuple[Rig, Impact]) -> Scalar:
            return contact_force_rate(*both, tau / omega)

        solver = optx.Newton(0.0, tolerance)
        tau = optx.root_find(rate, solver, tau, both, max_steps=16, adjoint=adjoint, throw=False).value
        return contact_force(*both, tau / omega)

    def gradient(rig: Rig, impact: Impact, tau: Scalar, omega: Scalar) -> tuple[Rig, Impact]:
        return jax.grad(f_max)((rig, impact), tau, omega)

    rig, impact = _parameters(take(box, ends.chosen))
    call = on_all_cores(in_blocks(gradient), rig, impact, ends.guess, rig.omega)
    return Peer(name, call, _force_slope, ends.chosen)


def implicit_gradient(box: Box, ends: Bracket, tolerance: float) -> Peer:
    return _through_root_find("optimistix, ImplicitAdjoint", optx.ImplicitAdjoint(), box, ends, tolerance)


def unrolled_gradient(box: Box, ends: Bracket, tolerance: float) -> Peer:
    adjoint = optx.RecursiveCheckpointAdjoint()
    return _through_root_find("optimistix, unrolled", adjoint, box, ends, tolerance)
