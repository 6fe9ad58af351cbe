"""A surrogate's force with a bound on its error that is proved for each answer anew."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from acf_jax.model import Impact, Rig, contact_force
from acf_jax.model.response import contact_force_curvature, contact_force_rate
from acf_jax.surrogate import Surrogate
from acf_jax.surrogate.features import FoldFeatures
from acf_jax.surrogate.fold import distance_to_fold

Scalar = Float[Array, ""]
ROUNDING = 1e-11  # relative, of the force's evaluation at double precision


class Certified(NamedTuple):
    """lower <= F_max <= upper, where `holds`."""

    lower: Scalar  # N, the force at the time the network names: never above the peak
    upper: Scalar  # N
    t: Scalar  # s, that time
    holds: Bool[Array, ""]  # there is a peak, and the time lies where the proof applies


def certified_peak(surrogate: Surrogate, rig: Rig, impact: Impact) -> Certified:
    """Bounds of the peak force from a network that guesses when the peak comes.

    Between tau_0 and tau_0 + sigma_m the slope F' falls, is convex, and has its one zero t* (docs/theory.md: F' goes as
    r - s(sigma), and s is concave there). So with t the guessed time,

        F(t) <= F_max <= F(t) + |F'(t)| D,   |t* - t| <= D,

    where D follows from the chord of F' to the end t_m of the bracket if the peak is still to come,
    D = (t_m - t) F'(t)/(F'(t) - F'(t_m)), and from its tangent if it is over, D = F'(t)/F''(t). Nothing about the
    network enters: a bad guess widens the bound, it does not break it.

    **Arguments:** one sample; a surrogate with `FoldFeatures`.

    **Returns:** `Certified`, all finite.

    **Raises:** `ValueError` for a surrogate that does not predict a time.
    """
    if not isinstance(surrogate.features, FoldFeatures):
        raise ValueError(
            f"a bound can be proved only for features 'fold', but these are '{surrogate.features.name}'; "
            "train with features: fold"
        )
    fold = distance_to_fold(rig, impact)
    x = surrogate.x(surrogate.features.coordinates(rig, impact).astype(surrogate.x.scale.dtype))
    share = jnp.clip(surrogate.y.inverse(surrogate.network(x)), 0.0, 1.0)
    omega = rig.omega
    start, end = fold.tau_0 / omega, (fold.tau_0 + fold.sigma_m) / omega
    t = jax.lax.stop_gradient((fold.tau_0 + fold.sigma_m * share) / omega)
    force, rate = contact_force(rig, impact, t), contact_force_rate(rig, impact, t)
    last_rate = jnp.minimum(contact_force_rate(rig, impact, end), 0.0)
    curvature = contact_force_curvature(rig, impact, t)
    is_before = rate > 0
    fall = jnp.where(is_before, rate - last_rate, 1.0)
    ahead = (end - t) * jnp.where(is_before, rate, 0.0) / fall
    bends = curvature < 0
    behind = jnp.where(bends, rate / jnp.where(bends, curvature, -1.0), t - start)
    distance = jnp.where(is_before, ahead, jnp.clip(behind, 0.0, t - start))
    error = jnp.abs(rate) * distance + ROUNDING * jnp.abs(force)
    return Certified(force - ROUNDING * jnp.abs(force), force + error, t, fold.has_peak & jnp.isfinite(error))
