"""How a peak contact force follows from parameters: in closed form, by simulation, or by a surrogate."""

import abc
from typing import ClassVar, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from acf_jax.contact.body import Body, reduced_mass, series_stiffness
from acf_jax.contact.braking import is_within_travel, stopping_time, stopping_travel
from acf_jax.contact.carried import carried_force
from acf_jax.contact.ending import Ending
from acf_jax.contact.followed import force_until_rest
from acf_jax.contact.recoil import Recoil
from acf_jax.effects import AbstractEffect
from acf_jax.inference.forward import SAMPLES, STEP_PER_RADIAN, unpack
from acf_jax.inference.parameters import component_of, parameters
from acf_jax.model import Impact, Rig, find_peak
from acf_jax.model.until import force_bound, free_body_bound, largest, largest_force_until
from acf_jax.predict import LONGEST
from acf_jax.simulator import LargestForce, largest_force
from acf_jax.simulator.peak import Force
from acf_jax.surrogate import CorrectedSurrogate, Surrogate

Scalar = Float[Array, ""]
RIG = ("m", "d", "k_f", "k_c")
COARSEST = 0.2  # omega h; a coarser grid understates a peak by more than 0.1 %
BRAKES_ITSELF = "robot_deceleration"  # the effect of a corrected model


class ContactPeak(NamedTuple):
    """Peak contact force of one impact; where `exists` is False the model knows no peak there."""

    force: Float[Array, "*batch"]  # N
    exists: Bool[Array, "*batch"]


class Branches(NamedTuple):
    """Forces of one contact, the largest of which counts: each depends on the parameters in a way of its own."""

    force: Float[Array, " branches"]  # N
    exists: Bool[Array, ""]


class AbstractPeak(eqx.Module):
    """The peak contact force of one sample; z holds m, d, k_F, k_C, parameters of effects, v_E and F_P."""

    block: ClassVar[int]  # samples that one compiled program takes
    no_peak: ClassVar[str] = "the force keeps rising without a first peak"  # what it means where none exists

    @abc.abstractmethod
    def __call__(self, z: Float[Array, " p"], body: Body) -> ContactPeak:
        """Differentiable in forward mode."""

    @abc.abstractmethod
    def until(self, z: Float[Array, " p"], body: Body, ending: Ending) -> Branches:
        """The largest forces until the contact has ended: of what the impact sets swinging, and carried along."""

    def branches(self, z: Float[Array, " p"], body: Body) -> Branches:
        """What this law's force is the largest of; one alone but where a subclass says otherwise."""
        peak = self(z, body)
        return Branches(peak.force[None], peak.exists)

    def bound(self, z: Float[Array, " p"], body: Body, ending: Ending) -> Branches:
        """What the forces of `until` do not exceed, in closed form; none exists where nothing is known."""
        return Branches(jnp.full(2, jnp.inf), jnp.asarray(False))

    def at_rest(self, z: Float[Array, " p"], x: Scalar | float) -> Scalar:
        """The contact force that stays where robot and flange have come to rest, the flange compressed by x, N."""
        return carried_force(Rig(*z[:4]), Impact(z[-2], z[-1]), (), x, 0.0)

    def original(self) -> "AbstractPeak":
        """The law that a surrogate stands for; of any other law itself."""
        return self

    @abc.abstractmethod
    def credits_stiffness(self) -> bool:
        """Whether the body's stiffness is taken in series with the contact's."""

    def is_simulated(self) -> bool:
        """Whether each sample costs a simulation with effects."""
        return False


class ClosedForm(AbstractPeak):
    """The paper's model: `find_peak` with the series stiffness and the reduced mass."""

    block = 4096

    def __call__(self, z: Float[Array, " p"], body: Body) -> ContactPeak:
        peak = find_peak(*coupled(z, body))
        return ContactPeak(peak.f_max, peak.has_peak)

    def until(self, z: Float[Array, " p"], body: Body, ending: Ending) -> Branches:
        """Of a contact that is lost and hits again, or of one that holds and pulls until the robot has stopped.

        The equations' own force until a clamped contact's robot stops that has kept its speed is in closed form.
        """
        through = jax.vmap(Simulated((), np.inf).through, (None, None, None, 0))
        both = through(z, body, ending, jnp.array([0.0, 1.0]))
        has_form = (jnp.asarray(body.mobility) == 0) & ~jnp.isfinite(jnp.asarray(ending.deceleration))
        exact = largest_force_until(*coupled(z, body), stopping_time(ending, z[-2]))
        swinging, carried = largest(both.force)
        swinging = largest(jnp.stack([swinging, jnp.where(has_form, exact, 0.0)]))
        return Branches(jnp.stack([swinging, carried]), both.exists.all())

    def bound(self, z: Float[Array, " p"], body: Body, ending: Ending) -> Branches:
        """By the energy that impact and robot bring; of a robot that brakes nothing is known."""
        rig, impact = coupled(z, body)
        time, travel = (f(ending, impact.v_e) for f in (stopping_time, stopping_travel))
        is_free = jnp.asarray(body.mobility) > 0
        free = free_body_bound(rig, impact, 1 / jnp.where(is_free, body.mobility, 1.0))
        swinging = jnp.where(is_free, free, force_bound(rig, impact, time))
        swinging = jnp.where(jnp.isfinite(jnp.asarray(ending.deceleration)), jnp.inf, swinging)
        carried = carried_force(rig, impact, (), travel, impact.v_e)
        above = jnp.stack([swinging, jnp.where(is_free, 0.0, carried)])
        return Branches(above, jnp.isfinite(above).all() & is_within_travel(ending, impact.v_e))

    def credits_stiffness(self) -> bool:
        return True


class Learned(AbstractPeak):
    """A surrogate of the paper's model, its error bound added to its force; it knows no peak outside its box."""

    surrogate: Surrogate
    block = 4096
    no_peak = "the force keeps rising without a first peak, or the surrogate's range ends"

    def original(self) -> AbstractPeak:
        return ClosedForm()

    def until(self, z: Float[Array, " p"], body: Body, ending: Ending) -> Branches:
        return self.original().until(z, body, ending)

    def bound(self, z: Float[Array, " p"], body: Body, ending: Ending) -> Branches:
        return self.original().bound(z, body, ending)

    def __call__(self, z: Float[Array, " p"], body: Body) -> ContactPeak:
        rig, impact = coupled(z, body)
        force = self.surrogate.force(rig, impact) + self.surrogate.error_bound(rig, impact)
        return ContactPeak(force, self.surrogate.is_inside(rig, impact))

    def credits_stiffness(self) -> bool:
        return True


class Simulated(AbstractPeak):
    """The model with effects: the largest contact force until contact is lost, within 60 ms.

    The body's stiffness is in series with k_C where no effect acts at the contact; otherwise it is left out, which
    makes the contact stiffer and the force higher. The body's recoil is simulated. A force that is largest at
    the end of the window still rises: it has no peak. Nor has a contact too stiff for the shortest step, which would
    miss its top.
    """

    effects: tuple[str, ...] = eqx.field(static=True)
    longest_step: float = eqx.field(static=True)  # s
    reach: float = eqx.field(static=True, default=np.inf)  # N, see `unpack`
    block = 64

    def __call__(self, z: Float[Array, " p"], body: Body) -> ContactPeak:
        found = self.largest(z, body)
        return ContactPeak(found.force, found.exists)

    def largest(self, z: Float[Array, " p"], body: Body, which: Force = "contact") -> LargestForce:
        """The largest force of one sample and its time; `which` may ask for the sensor's reading instead."""
        rig, effects, fastest = self._against(z, body)
        h = jnp.maximum(jnp.minimum(self.longest_step, STEP_PER_RADIAN / fastest), LONGEST / (SAMPLES - 4))
        effects = [*effects, Recoil(jnp.asarray(body.mobility))]
        found = largest_force(rig, Impact(z[-2], z[-1]), effects, jax.lax.stop_gradient(h), LONGEST, which)
        return found._replace(exists=found.exists & (fastest * h <= COARSEST))

    def until(self, z: Float[Array, " p"], body: Body, ending: Ending) -> Branches:
        found = self.through(z, body, ending, 0.0)
        if BRAKES_ITSELF not in self.effects:
            return found
        # that effect has the flange brake with the robot, and its robot stops when it will: the ending's counts, too
        places = [
            k
            for k, (name, _) in enumerate(parameters(self.effects))
            if not name.startswith(f"{BRAKES_ITSELF}.")
        ]
        others = tuple(name for name in self.effects if name != BRAKES_ITSELF)
        without = Simulated(others, self.longest_step, self.reach)
        stated = without.through(jnp.concatenate([z[jnp.array(places)], z[-2:]]), body, ending, 0.0)
        return Branches(largest(jnp.stack([found.force, stated.force])), found.exists & stated.exists)

    def at_rest(self, z: Float[Array, " p"], x: Scalar | float) -> Scalar:
        rig, effects = unpack(self.effects, z[:-2], self.reach)
        return carried_force(rig, Impact(z[-2], z[-1]), effects, x, 0.0)

    def through(self, z: Float[Array, " p"], body: Body, ending: Ending, pull: Scalar | float) -> Branches:
        """The largest force until robot and flange are at rest; `pull` as for `force_until_rest`.

        Where the body is clamped, the force of `carried_force` counts as well.
        """
        rig, effects, fastest = self._against(z, body)
        impact, brakes_itself = Impact(z[-2], z[-1]), BRAKES_ITSELF in self.effects
        force, is_known = force_until_rest(
            rig, impact, effects, body, ending, fastest, self.longest_step, pull, brakes_itself
        )
        travelled = jnp.where(impact.v_e > 0, stopping_travel(ending, impact.v_e), 0.0)
        is_clamped = jnp.asarray(body.mobility) == 0
        carried = jnp.where(is_clamped, carried_force(rig, impact, effects, travelled, impact.v_e), 0.0)
        return Branches(jnp.stack([force, carried]), is_known)

    def _against(
        self, z: Float[Array, " p"], body: Body
    ) -> tuple[Rig, list[AbstractEffect], Float[Array, ""]]:
        """Rig and effects against a body, and the fastest rate among them and its recoil, 1/s."""
        rig, effects = unpack(self.effects, z[:-2], self.reach)
        if self.credits_stiffness():
            rig = Rig(rig.m, rig.d, rig.k_f, series_stiffness(rig.k_c, body))
        stiffest = jnp.sqrt((rig.k_f + rig.k_c) * (1 / rig.m + body.mobility))
        # within the decay of a strong damper, as `step_for`: a longer step takes its jump for a peak
        fastest = jnp.maximum(stiffest, STEP_PER_RADIAN * rig.d / rig.m)
        return rig, effects, fastest

    def is_simulated(self) -> bool:
        return True

    def credits_stiffness(self) -> bool:
        return all(component_of(name) != "contact" for name in self.effects)


class Trained(AbstractPeak):
    """A surrogate of a corrected model, its error bound added to its force; it knows no peak outside its box."""

    surrogate: CorrectedSurrogate
    law: Simulated  # what it stands for
    block = 4096
    no_peak = "the force may grow beyond its first peak, or the surrogate's range ends"

    def original(self) -> AbstractPeak:
        return self.law

    def until(self, z: Float[Array, " p"], body: Body, ending: Ending) -> Branches:
        return self.law.until(z, body, ending)

    def at_rest(self, z: Float[Array, " p"], x: Scalar | float) -> Scalar:
        return self.law.at_rest(z, x)

    def __call__(self, z: Float[Array, " p"], body: Body) -> ContactPeak:
        found = self.surrogate.predict(self.sample(z, body))
        return ContactPeak(found.force + found.error_bound, found.is_inside)

    def sample(self, z: Float[Array, " p"], body: Body) -> Float[Array, " p+1"]:
        """q of the surrogate: the body's stiffness in series with the contact's where the law credits it."""
        k = series_stiffness(z[3], body) if self.credits_stiffness() else z[3]
        mobility = jnp.asarray(body.mobility, float)
        return jnp.concatenate([z.at[3].set(k), mobility[None]])

    def credits_stiffness(self) -> bool:
        return self.law.credits_stiffness()


def coupled(z: Float[Array, " p"], body: Body) -> tuple[Rig, Impact]:
    """Rig and impact of the paper's model against a body."""
    rig = Rig(reduced_mass(z[0], body), z[1], z[2], series_stiffness(z[3], body))
    return rig, Impact(z[-2], z[-1])
