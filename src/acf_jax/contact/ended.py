"""A contact model whose force counts until the contact has ended, not its first peak alone."""

import equinox as eqx
from jaxtyping import Array, Float

from acf_jax.contact.body import Body
from acf_jax.contact.braking import is_within_travel
from acf_jax.contact.ending import Ending
from acf_jax.contact.model import ContactModel, Variant
from acf_jax.contact.peak import AbstractPeak, Branches, ContactPeak, Scalar
from acf_jax.model.until import largest


class Ended(AbstractPeak):
    """The largest force until a stated ending, by the law itself: no surrogate has learnt what follows a first peak.

    A robot that travels farther than is left has no such force: at the end of the stroke its own mass would act.
    """

    law: AbstractPeak
    ending: Ending
    no_peak = (
        "the force cannot be followed until the robot has stopped, or the robot travels farther than is left"
    )

    @property
    def block(self) -> int:  # type: ignore[override]
        return min(self.law.block, 64)

    def __call__(self, z: Float[Array, " p"], body: Body) -> ContactPeak:
        found = self.branches(z, body)
        return ContactPeak(largest(found.force), found.exists)

    def branches(self, z: Float[Array, " p"], body: Body) -> Branches:
        return self.until(z, body, self.ending)

    def until(self, z: Float[Array, " p"], body: Body, ending: Ending) -> Branches:
        found = self.law.until(z, body, ending)
        return found._replace(exists=found.exists & is_within_travel(ending, z[-2]))

    def at_rest(self, z: Float[Array, " p"], x: Scalar | float) -> Scalar:
        return self.law.at_rest(z, x)

    def credits_stiffness(self) -> bool:
        return self.law.credits_stiffness()

    def is_simulated(self) -> bool:
        return self.law.is_simulated()


class Above(Ended):
    """What the largest force until a stated ending does not exceed; none exists where nothing is known."""

    @property
    def block(self) -> int:  # type: ignore[override]
        return self.law.block

    def until(self, z: Float[Array, " p"], body: Body, ending: Ending) -> Branches:
        return self.law.bound(z, body, ending)


def ended(model: ContactModel, ending: Ending, as_force: type[Ended] = Ended) -> ContactModel:
    """The model with every explanation's force counted until the ending.

    An ending of floats is part of the compiled program, one of arrays an argument of it. `as_force`: `Above` for what
    that force does not exceed.
    """

    def of(variant: Variant) -> Variant:
        return eqx.tree_at(lambda v: v.peak, variant, as_force(variant.peak.original(), ending))

    replaced: ContactModel = eqx.tree_at(
        lambda m: (m.main, m.others), model, (of(model.main), tuple(map(of, model.others)))
    )
    return replaced
