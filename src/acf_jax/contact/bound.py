"""What a peak force stays below with a stated confidence: parameters displaced, explanations mixed."""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.scipy.special import ndtr
from jaxtyping import Array, Bool, Float
from scipy.stats import norm

from acf_jax.contact.body import Body
from acf_jax.contact.model import ContactModel, Variant, beside, root_of
from acf_jax.contact.peak import AbstractPeak

Scalar = Float[Array, ""]
HALVINGS = 60


class Interval(NamedTuple):
    """lower <= force <= upper of one sample, of each branch of its law, where `known`."""

    lower: Float[Array, " branches"]  # N
    upper: Float[Array, " branches"]  # N
    known: Bool[Array, ""]


Law = Callable[[Float[Array, " p"], Body], Interval]


class Bounded(NamedTuple):
    """The peak force with everything that its parameters and explanations leave open."""

    lower: Scalar  # N, the main explanation at its best values, from below
    force: Scalar  # N, the same from above
    upper: Scalar  # N, not exceeded with the stated confidence
    has_peak: Bool[Array, ""]  # the main explanation's, at its best values
    holds: Bool[Array, ""]  # every explanation has a peak, wherever its parameters were displaced to


class _Own(NamedTuple):
    """Forces and deviations of the branches of one explanation."""

    lower: Scalar
    force: Float[Array, " branches"]
    std: Float[Array, " branches"]
    has_peak: Bool[Array, ""]
    holds: Bool[Array, ""]


def exact(peak: AbstractPeak) -> Law:
    """A law whose force is the peak itself."""

    def law(z: Float[Array, " p"], body: Body) -> Interval:
        found = peak.branches(z, body)
        return Interval(found.force, found.force, found.exists)

    return law


def bounded(
    model: ContactModel,
    confidence: float,
    main: Law | None = None,
    law_of: Callable[[AbstractPeak], Law] = exact,
) -> Callable[[Float[Array, " p"], Body], Bounded]:
    """The function (z, body) -> `Bounded`, for use inside `jax.jit`.

    Each explanation i is asked at its best values and displaced by k = Phi^-1(confidence) deviations (at least one)
    along each independent direction a of what is uncertain, to either side:

        k sigma_i = E (exp(sqrt(sum_a ln(1 + c_a/E)^2)) - 1),   c_a = max |F(z +- k sigma_a e_a) - F_i|,

    E = max(F_i - F_P, F_i/10). That is the first-order quantile for small deviations, the exact one where a single
    parameter is uncertain and F grows with it, and otherwise more: the force above the pretension is much like a
    product of powers, whose logarithms add. A draw without a peak
    is no force at all, so that a peak is asked for at every displaced point. Of the mixture, and of the branches b of
    each law, any of which may exceed it, the upper end is the smallest F with

        sum_i w_i sum_b Phi((F_ib - F)/sigma_ib) <= 1 - confidence.

    **Arguments:** `main`: a law in place of the main explanation's own, for example a surrogate's. `law_of`: the law
    of each explanation, by default its peak.
    """
    factor = float(norm.ppf(confidence))
    laws = (main or law_of(model.main.peak), *(law_of(v.peak) for v in model.others))
    reach = max(factor, 1.0)
    displacements = [_displacements(model, v, reach) for v in model.variants]
    least = [np.r_[v.low, 0.0, 0.0] for v in model.variants]
    weights = np.array([v.weight for v in model.variants])

    def found(z: Float[Array, " p"], body: Body) -> Bounded:
        places = (z, *(beside(model.main, v, z) for v in model.others))
        every = [
            _of_one(law, low, by, at, body, reach, model.form_error)
            for law, low, by, at in zip(laws, least, displacements, places, strict=True)
        ]
        first = every[0]
        force, std = jnp.concatenate([e.force for e in every]), jnp.concatenate([e.std for e in every])
        upper = first.force[0] + factor * first.std[0]
        if force.size > 1:
            weight = np.repeat(weights / weights.sum(), [e.force.size for e in every])
            upper = _quantile(force, std, weight, 1 - confidence)
        holds = jnp.stack([e.holds for e in every]).all()
        return Bounded(first.lower, first.force.max(), upper, first.has_peak, holds)

    return found


def _displacements(model: ContactModel, v: Variant, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """By how much z is displaced, a row each: by absolute amounts, and by shares of its own entries.

    First not at all, then `reach` deviations up along each independent direction, then as many down.
    """
    root = root_of(v.covariance).T
    relative = model.relative_of(v)
    shares = np.diag(relative)[relative > 0]
    root = np.pad(root, ((0, len(shares)), (0, 2)))
    shares = np.pad(shares, ((len(root) - len(shares), 0), (0, 0)))
    none = np.zeros((1, len(relative)))
    up, up_share = reach * root, reach * shares
    return np.concatenate([none, up, -up]), np.concatenate([none, up_share, -up_share])


def _of_one(
    law: Law,
    least: np.ndarray,
    by: tuple[np.ndarray, np.ndarray],
    z: Float[Array, " p"],
    body: Body,
    reach: float,
    form_error: float,
) -> _Own:
    """One explanation, asked wherever z is displaced to."""
    places = jax.vmap(lambda amount, share: jnp.maximum(z + amount + share * z, least))(*by)
    found = jax.vmap(law, (0, None))(places.at[0].set(z), body)
    lower, force = found.lower[0].max(), found.upper[0]
    up, down = jnp.split(jnp.abs(found.upper[1:] - force[None]), 2)
    # what the parameters act on is the force above the pretension; a tenth, so that other forces do not explode
    scale = jnp.maximum(force - z[-1], jnp.where(force > 0, force / 10, 1.0))
    shares = jnp.log1p(jnp.maximum(up, down) / scale[None])
    parameters = scale * jnp.expm1(jnp.sqrt((shares**2).sum(0)))
    form = reach * form_error * (force + parameters)
    std = jnp.sqrt(parameters**2 + form**2) / reach
    return _Own(lower, force, std, found.known[0], found.known.all())


def _quantile(force: Float[Array, " n"], std: Float[Array, " n"], weight: np.ndarray, rest: float) -> Scalar:
    """The smallest force that normal laws exceed with a probability, summed by `weight`, of at most `rest`."""
    factor = float(norm.isf(rest / weight.sum()))  # with which each alone is exceeded by its part of `rest`
    is_spread = std > 0
    width = jnp.where(is_spread, std, 1.0)

    def exceeded(f: Scalar) -> Scalar:
        return jnp.asarray(weight) @ jnp.where(is_spread, ndtr((force - f) / width), force > f)

    def halve(_: int, ends: tuple[Scalar, Scalar]) -> tuple[Scalar, Scalar]:
        low, high = ends
        middle = (low + high) / 2
        is_enough = exceeded(middle) <= rest
        return jnp.where(is_enough, low, middle), jnp.where(is_enough, middle, high)

    ends = force.min(), (force + factor * std).max()
    found: tuple[Scalar, Scalar] = jax.lax.fori_loop(0, HALVINGS, halve, ends)
    return found[1]
