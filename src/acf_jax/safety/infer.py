"""The force of one contact with its bounds, compiled once: its first peak, and all until the contact has ended."""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from acf_jax.contact.body import Body
from acf_jax.contact.bound import Bounded, Interval, Law, bounded
from acf_jax.contact.braking import stopping_travel
from acf_jax.contact.ended import ended
from acf_jax.contact.ending import Ending
from acf_jax.contact.model import ContactModel
from acf_jax.contact.peak import AbstractPeak, ClosedForm, Trained, coupled
from acf_jax.kept import quick_options
from acf_jax.safety.certificate import certified_peak
from acf_jax.surrogate import Surrogate


class Inferred(NamedTuple):
    """lower <= force looked for <= force for the parameters' best values, and what those leave open."""

    lower: float  # N
    force: float  # N
    upper: float  # N, not exceeded with the stated confidence
    exists: bool  # at the best values; elsewhere the figures are stand-ins
    is_known: bool  # the way that was taken holds wherever the parameters may lie


# of z, then the body's compliance and mobility, then the ending: what each of its programs infers
Way = Callable[[np.ndarray], tuple[Inferred, ...]]
Program = Callable[
    [Float[Array, " p+6"]], Float[Array, "5"]
]  # the same before it is compiled; `Bounded` in an array


def exact_peak(model: ContactModel, confidence: float) -> Program:
    """The first peak by the closed form, or by the simulation of a corrected model."""
    return _first_peak(model, confidence)


def quick_peak(model: ContactModel, confidence: float, surrogate: Surrogate) -> Program:
    """The same by the surrogate with its proved bound; known only inside its range, and only for the paper's model."""
    if not isinstance(model.main.peak, ClosedForm):
        raise ValueError("the surrogate stands for the paper's model; take the exact way for a corrected one")

    def law(z: Float[Array, " p"], body: Body) -> Interval:
        rig, impact = coupled(z, body)
        found = certified_peak(surrogate, rig, impact)
        known = found.holds & surrogate.box.has(rig, impact).all()
        return Interval(found.lower[None], found.upper[None], known)

    return _first_peak(model, confidence, law)


def trained_peak(model: ContactModel, confidence: float) -> Program:
    """The same by a surrogate of a corrected model, with the bound that training measured; known only in its box."""
    trained = model.main.peak
    if not isinstance(trained, Trained):
        raise ValueError("the model has no surrogate; take the exact way")
    error = trained.surrogate.bounds.force

    def law(z: Float[Array, " p"], body: Body) -> Interval:
        peak = trained(z, body)
        force = peak.force[None]
        return Interval(force * (1 - error) / (1 + error), force, peak.exists)

    return _first_peak(model, confidence, law)


def whole(model: ContactModel, confidence: float) -> Program:
    """The largest force until the contact has ended, by closed form and simulation."""
    return _joined(lambda z, body, ending: bounded(ended(model, ending), confidence)(z, body))


def bound(model: ContactModel, confidence: float) -> Program:
    """What no force until the contact has ended exceeds, be it lost and hit again: in closed form, and from above.

    For the paper's model; of a robot that brakes it knows nothing.
    """

    def found(z: Float[Array, " p"], body: Body, ending: Ending) -> Bounded:
        def law(z: Float[Array, " p"], body: Body) -> Interval:
            above, known = ClosedForm().bound(z, body, ending)
            return Interval(above, above, known)

        return bounded(model, confidence, law)(z, body)

    return _joined(found)


def at_rest(model: ContactModel, confidence: float) -> Program:
    """The force that stays: of a clamped body with the robot where it has stopped, of one that can withdraw without."""

    def found(z: Float[Array, " p"], body: Body, ending: Ending) -> Bounded:
        def law_of(peak: AbstractPeak) -> Law:
            def law(z: Float[Array, " p"], body: Body) -> Interval:
                travel = stopping_travel(ending, z[-2])
                is_pressed = (body.mobility == 0) & jnp.isfinite(travel)
                force = peak.at_rest(z, jnp.where(is_pressed, travel, 0.0))[None]
                return Interval(force, force, jnp.asarray(True))

            return law

        return bounded(model, confidence, law_of=law_of)(z, body)

    return _joined(found)


def _first_peak(model: ContactModel, confidence: float, law: Law | None = None) -> Program:
    first_peak = bounded(model, confidence, law)
    return _joined(lambda z, body, _: first_peak(z, body))


def _joined(found: Callable[[Float[Array, " p"], Body, Ending], Bounded]) -> Program:
    """One array in, one array out: what a call costs is the number of its arguments."""

    def program(x: Float[Array, " p+6"]) -> Float[Array, "5"]:
        answer = found(x[:-6], Body(*x[-6:-4]), Ending(*x[-4:]))
        return jnp.stack([jnp.asarray(y, float) for y in answer])

    return program


def compiled(*programs: Program, is_simulated: bool = False) -> Way:
    """The programs of one contact as one function of NumPy arrays: together, since a call costs more than its figures.

    `is_simulated`: the compiler's full effort takes twice as long and makes simulations no faster.
    """

    def together(x: Float[Array, " p+6"]) -> Float[Array, "programs 5"]:
        return jnp.stack([program(x) for program in programs])

    quick = jax.jit(together, compiler_options=quick_options() if is_simulated else None)

    def infer(x: np.ndarray) -> tuple[Inferred, ...]:
        rows = np.asarray(quick(x)).tolist()
        return tuple(Inferred(low, at, up, bool(exists), bool(known)) for low, at, up, exists, known in rows)

    return infer
