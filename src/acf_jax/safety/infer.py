"""Force, its bounds and its standard deviation for one impact, compiled once: the quick way and the exact way."""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from acf_jax.contact.body import Body
from acf_jax.contact.model import ContactModel, spread
from acf_jax.contact.peak import ClosedForm, Trained, coupled
from acf_jax.model import contact_force
from acf_jax.safety.certificate import certified_peak
from acf_jax.surrogate import Surrogate


class Inferred(NamedTuple):
    """lower <= peak force <= upper for the parameters' best values, and what those leave open."""

    lower: float  # N
    upper: float  # N
    std: float  # N
    is_known: bool  # there is a peak, and the way that was taken holds here


Way = Callable[[np.ndarray, Body], Inferred]
Input = Float[Array, " p+2"]  # z, then the body's compliance and mobility


def exact_way(model: ContactModel) -> Way:
    """The closed form, or the simulation of a corrected model."""

    def one(x: Input) -> Float[Array, " 4"]:
        peak, own = spread(model, x[:-2], Body(x[-2], x[-1]))
        return jnp.stack([peak.force, peak.force, own.std, peak.exists.astype(float)])

    return _compiled(one)


def quick_way(model: ContactModel, surrogate: Surrogate) -> Way:
    """The surrogate with its proved bound; known only inside its range, and only for the paper's model."""
    if not isinstance(model.main.peak, ClosedForm):
        raise ValueError("the surrogate stands for the paper's model; take the exact way for a corrected one")
    covariance, relative = jnp.asarray(model.main.covariance), jnp.asarray(model.relative)

    def one(x: Input) -> Float[Array, " 4"]:
        z, body = x[:-2], Body(x[-2], x[-1])
        rig, impact = coupled(z, body)
        found = certified_peak(surrogate, rig, impact)
        # the envelope theorem: at the peak the force's slope in time is zero
        gradient = jax.grad(lambda z: contact_force(*coupled(z, body), found.t))(z)
        variance = gradient[:-2] @ covariance @ gradient[:-2] + ((gradient * relative * z) ** 2).sum()
        inside = found.holds & surrogate.box.has(rig, impact).all()
        return jnp.stack([found.lower, found.upper, jnp.sqrt(variance), inside.astype(float)])

    return _compiled(one)


def trained_way(model: ContactModel) -> Way:
    """A surrogate of a corrected model with the bounds that its training measured; known only inside its box."""
    law = model.main.peak
    if not isinstance(law, Trained):
        raise ValueError("the model has no surrogate; take the exact way")
    bounds = law.surrogate.bounds

    def one(x: Input) -> Float[Array, " 4"]:
        peak, own = spread(model, x[:-2], Body(x[-2], x[-1]))
        lower = peak.force * (1 - bounds.force) / (1 + bounds.force)
        std = own.std + bounds.std * peak.force
        return jnp.stack([lower, peak.force, std, peak.exists.astype(float)])

    return _compiled(one)


def _compiled(one: Callable[[Input], Float[Array, " 4"]]) -> Way:
    program = jax.jit(one)

    def infer(z: np.ndarray, body: Body) -> Inferred:
        # one array in, one array out: what a call costs is the number of its arguments
        lower, upper, std, known = np.asarray(program(np.array([*z, *body], float))).tolist()
        return Inferred(lower, upper, std, bool(known))

    return infer
