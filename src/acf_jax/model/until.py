"""What follows the first peak: the largest contact force until a time, and what no rebound exceeds.

With k_F > 0 the force rises again as the robot goes on. Proofs of the two statements below, in the symbols of
docs/theory.md:

**The maxima fall and then rise.** F = c_0 + c_1 t + h(t) with h(t + T) = e^{-delta T} h(t), T = P/omega, P = 2
pi/eta and c_1 >= 0. Each maximum M_n = F(t_n) is the largest of its swing, so with q = 1 - e^{-delta T}

    M_{n+1} - M_n >= F(t_n + T) - F(t_n) = c_1 T - q h(t_n),
    M_n - M_{n-1} <= F(t_n) - F(t_n - T) = c_1 T - q e^{delta T} h(t_n).

If M_n >= M_{n-1}, then q h(t_n) <= c_1 T e^{-delta T} and M_{n+1} >= M_n.

**Contact lost and made again.** In the robot's frame, xi = x - v t, the energy E = m xi'^2/2 + F_C^2/(2 k_C) + k_F
xi^2/2 obeys E' = -d xi'^2 - L xi' with L = d v + k_F v t. Integrated by parts, with J the integral of xi where xi >
0,

    F_C^2/(2 k_C) <= E(0) + L (F_C - F_P)/k_C + k_F v J.

Where xi > 0, L xi <= y = E(0) + k_F v J, so y' <= y k_F/(d + k_F t): y grows at most as d + k_F t does, and not
before t_0 = tau_0/omega, since xi < 0 until the first peak. That gives `force_bound`.

**When the robot stops.** With X(t) the robot's way and q = -xi the flange's, m q'' = d (X' - q') + k_F (X - q) -
F_C. Then L = d X' + k_F X, and its fall at a stop adds at most d v (F* - F_P)/k_C to the energy, with F* the
largest force of all. So the bound holds for F* too, with the time of the stop for t. For a free body the same
follows for a stop while contact is lost: the flange's speed is at most v + rho, with m rho^2 + m_H (v - b)^2 <= m_H
v^2 and b the body's speed, so the next hit has mu (v + rho - b)^2 <= m_H v^2. At rest, W = m q'^2/2 + F_C^2/(2 k_C)
+ k_F x^2/2 obeys W' = -d q'^2 - F_C y', and the body's speed y' only grows. At the largest force q' = y', so no
later force exceeds sqrt(k_C (2 W - m y'^2)).
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from acf_jax.model.halley import find_crossing
from acf_jax.model.peak import reduce
from acf_jax.model.response import contact_force
from acf_jax.model.rig import Impact, Rig

Scalar = Float[Array, ""]
MOST_PERIODS = 1e6  # beyond it no peak is left that counts


def largest(values: Float[Array, "n *rest"]) -> Float[Array, "*rest"]:
    """The largest along the first axis, with the derivatives of that one.

    `jnp.max` looks for what to differentiate by comparing each value with the maximum. Where the compiler computes a
    value twice and rounds differently, none is equal, and the derivative is 0/0.
    """
    found: Array = jnp.take_along_axis(values, values.argmax(0)[None], 0)[0]
    return found


def largest_force_until(rig: Rig, impact: Impact, t: Scalar) -> Scalar:
    """The largest contact force of the paper's equations within [0, t], in closed form.

    The maxima of F_C, a period P = 2 pi/nu apart, solve s(sigma) = r e^{zeta n omega P}, each in the bracket of the
    first one. Their forces fall and then rise, never the other way round, so that only these five can be the largest:
    F_C(0), the first maximum, the last two before t, and F_C(t).

    **Arguments:** `rig`, `impact`: one sample. `t`: s, scalar, may be infinite.

    **Returns:** N, scalar; infinite where the force rises for ever and t is infinite. First derivatives are exact.

    **Example:**

        >>> rig = Rig(m=0.54, d=0.7, k_f=9500.0, k_c=35800.0)
        >>> float(largest_force_until(rig, Impact(v_e=0.98, f_p=8.0), 0.03))  # twice the first peak, of 139 N
        296.8
    """
    found = reduce(rig, impact)
    crossing, omega = found.crossing, rig.omega
    is_swinging = crossing.eta_squared > 0
    period = 2 * jnp.pi / jnp.sqrt(jnp.where(is_swinging, crossing.eta_squared, 1.0))
    end = jnp.where(jnp.isfinite(t), t, 0.0)
    growth = crossing.zeta * period  # of ln r from one maximum to the next
    left = -jnp.log(jnp.maximum(crossing.ratio, jnp.finfo(growth.dtype).tiny))
    there_are = jnp.where(growth > 0, jnp.floor(left / jnp.where(growth > 0, growth, 1.0)), MOST_PERIODS)
    begun = jnp.floor((omega * end - found.tau_0) / period)
    last = jnp.where(is_swinging, jnp.clip(begun, 0.0, jnp.minimum(there_are, MOST_PERIODS)), 0.0)

    def maximum(n: Scalar) -> Scalar:
        ratio = jnp.minimum(crossing.ratio * jnp.exp(growth * n), 1.0)
        sigma = find_crossing(crossing._replace(ratio=ratio))
        at = jax.lax.stop_gradient((found.tau_0 + n * period + sigma) / omega)  # stationary there
        is_there = found.has_peak & (at <= t)
        return jnp.where(is_there, contact_force(rig, impact, jnp.where(is_there, at, 0.0)), impact.f_p)

    maxima = [maximum(n) for n in (jnp.zeros_like(last), jnp.maximum(last - 1, 0.0), last)]
    rises = rig.k_f * impact.v_e > 0
    at_the_end = jnp.where(
        jnp.isfinite(t), contact_force(rig, impact, end), jnp.where(rises, jnp.inf, impact.f_p)
    )
    return largest(jnp.stack([impact.f_p, *maxima, at_the_end]))


def force_bound(rig: Rig, impact: Impact, t: Scalar) -> Scalar:
    """A force that the contact does not exceed within [0, t], whether it is lost and hits again or holds and pulls.

        F <= L + sqrt((L - F_P)^2 - F_P^2 + (k_C m v^2 + F_P^2) R),   L = d v + k_F v t,
        R = (d + k_F t)/(d + k_F t_0)

    from the energy in the robot's frame, with t_0 = tau_0/omega, before which no contact can be lost. Where the robot
    stops at t, the flange does not exceed it afterwards either.

    **Arguments:** as of `largest_force_until`.

    **Returns:** N, scalar; infinite where t is and k_F v > 0.
    """
    t_0 = reduce(rig, impact).tau_0 / rig.omega
    is_loading = rig.k_f * impact.v_e > 0
    bound_t = jnp.where(is_loading, jnp.maximum(t, t_0), t_0)
    load = rig.d * impact.v_e + rig.k_f * impact.v_e * bound_t
    carrying = rig.d + rig.k_f * t_0
    growth = jnp.where(is_loading, (rig.d + rig.k_f * bound_t) / jnp.where(carrying > 0, carrying, 1.0), 1.0)
    energy = (rig.k_c * rig.m * impact.v_e**2 + impact.f_p**2) * growth  # times 2 k_C
    # (L - F_P)^2 - F_P^2 without the difference of large numbers
    return load + jnp.sqrt(load * (load - 2 * impact.f_p) + energy)


def free_body_bound(rig: Rig, impact: Impact, body_mass: Scalar) -> Scalar:
    """sqrt(F_P^2 + k_C m_H v^2), N: no contact with a free body of mass m_H that comes with v exceeds it at any time.

    The body brings its kinetic energy, the preload its own; damping only takes from them.
    """
    return jnp.sqrt(impact.f_p**2 + rig.k_c * body_mass * impact.v_e**2)
