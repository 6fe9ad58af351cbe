"""The peak force of one impact with its bounds, compiled once: the quick way and the exact way."""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from acf_jax.contact.body import Body
from acf_jax.contact.bound import Interval, Law, bounded
from acf_jax.contact.model import ContactModel
from acf_jax.contact.peak import ClosedForm, Trained, coupled
from acf_jax.safety.certificate import certified_peak
from acf_jax.surrogate import Surrogate


class Inferred(NamedTuple):
    """lower <= peak force <= force for the parameters' best values, and what those leave open."""

    lower: float  # N
    force: float  # N
    upper: float  # N, not exceeded with the stated confidence
    has_peak: bool  # at the best values; elsewhere the figures are stand-ins
    is_known: bool  # the way that was taken holds wherever the parameters may lie


Way = Callable[[np.ndarray], Inferred]  # of z, then the body's compliance and mobility


def exact_way(model: ContactModel, confidence: float) -> Way:
    """The closed form, or the simulation of a corrected model."""
    return _compiled(model, confidence)


def quick_way(model: ContactModel, confidence: float, surrogate: Surrogate) -> Way:
    """The surrogate with its proved bound; known only inside its range, and only for the paper's model."""
    if not isinstance(model.main.peak, ClosedForm):
        raise ValueError("the surrogate stands for the paper's model; take the exact way for a corrected one")

    def law(z: Float[Array, " p"], body: Body) -> Interval:
        rig, impact = coupled(z, body)
        found = certified_peak(surrogate, rig, impact)
        return Interval(found.lower, found.upper, found.holds & surrogate.box.has(rig, impact).all())

    return _compiled(model, confidence, law)


def trained_way(model: ContactModel, confidence: float) -> Way:
    """A surrogate of a corrected model with the bound that its training measured; known only inside its box."""
    trained = model.main.peak
    if not isinstance(trained, Trained):
        raise ValueError("the model has no surrogate; take the exact way")
    error = trained.surrogate.bounds.force

    def law(z: Float[Array, " p"], body: Body) -> Interval:
        peak = trained(z, body)
        return Interval(peak.force * (1 - error) / (1 + error), peak.force, peak.exists)

    return _compiled(model, confidence, law)


def _compiled(model: ContactModel, confidence: float, law: Law | None = None) -> Way:
    bound = bounded(model, confidence, law)

    # one array in, one array out: what a call costs is the number of its arguments
    @jax.jit
    def program(x: Float[Array, " p+4"]) -> Float[Array, "5"]:
        return jnp.stack([jnp.asarray(y, float) for y in bound(x[:-2], Body(x[-2], x[-1]))])

    def infer(x: np.ndarray) -> Inferred:
        lower, force, upper, has_peak, is_known = np.asarray(program(x)).tolist()
        return Inferred(lower, force, upper, bool(has_peak), bool(is_known))

    return infer
