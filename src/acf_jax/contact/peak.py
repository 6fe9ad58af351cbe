"""How a peak contact force follows from parameters: in closed form, by simulation, or by a surrogate."""

import abc
from typing import ClassVar, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from acf_jax.contact.body import Body, reduced_mass, series_stiffness
from acf_jax.contact.braking import Braking, braking, stopping_time, stopping_travel
from acf_jax.contact.ending import Ending
from acf_jax.contact.recoil import Recoil
from acf_jax.diagnosis.forward import SAMPLES, STEP_PER_RADIAN, unpack
from acf_jax.diagnosis.predict import LONGEST
from acf_jax.diagnosis.space import component_of
from acf_jax.effects import AbstractEffect
from acf_jax.model import Impact, Rig, find_peak
from acf_jax.model.until import carried_force, largest_force_until
from acf_jax.simulator import LargestForce, largest_force
from acf_jax.simulator.peak import Force
from acf_jax.simulator.through import largest_force_through
from acf_jax.surrogate import CorrectedSurrogate, Surrogate

Scalar = Float[Array, ""]
RIG = ("m", "d", "k_f", "k_c")
COARSEST = 0.2  # omega h; a coarser grid understates a peak by more than 0.1 %
FINE = 0.08  # omega h of a simulation until the contact has ended
FEWEST_STEPS, MOST_STEPS = 4, 50_000  # of each of its parts
SETTLED = 25.0  # decay times, after which e^{-25} of a swing is left
AT_ONCE = 1e-3  # of a radian of the fastest motion, in which a robot stops that stops at once
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
        """The larger of two: the equations' own force, which holds and pulls where a contact would be lost, and that of
        a contact that is lost and hits again. The first is in closed form where body and robot allow one.
        """
        through = Simulated((), np.inf).through
        exact = largest_force_until(*coupled(z, body), stopping_time(ending, z[-2]))
        is_stated = isinstance(body.mobility, float) and isinstance(ending.deceleration, float)
        if is_stated and body.mobility == 0 and not ending.brakes:  # known before anything is traced
            found = through(z, body, ending, 0.0)
            return found._replace(force=found.force.at[0].max(exact))
        has_form = (jnp.asarray(body.mobility) == 0) & ~jnp.isfinite(jnp.asarray(ending.deceleration))
        rebounding, holding = (through(z, body, ending, pull) for pull in (0.0, 1.0))
        held = jnp.where(has_form, exact, holding.force[0])
        return rebounding._replace(force=rebounding.force.at[0].max(held))

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
        found = largest_force(rig, Impact(z[-2], z[-1]), effects, jax.lax.stop_gradient(h), LONGEST, which)
        return found._replace(exists=found.exists & (fastest * h <= COARSEST))

    def until(self, z: Float[Array, " p"], body: Body, ending: Ending) -> Branches:
        return self.through(z, body, ending, 0.0)

    def through(self, z: Float[Array, " p"], body: Body, ending: Ending, pull: Scalar | float) -> Branches:
        """The largest force until the contact has ended, every further contact included; `pull` as for `simulate`.

        A robot whose braking is not stated keeps its speed and stops at once. The flange, which it carries, goes on by
        itself: the force is followed until that has come to rest, too. Where the body is clamped, the force of
        `carried_force` counts as well.
        A parabola through three samples misses a maximum by |F_C'''| h^3/(9 sqrt 3) at most; that of a force that bends
        with (omega + d/m)^3 is added.
        """
        rig, effects, fastest = self._against(z, body)
        impact = Impact(z[-2], z[-1])
        rate = fastest + rig.d / rig.m
        begin, deceleration = braking(ending, impact.v_e, jax.lax.stop_gradient(AT_ONCE / rate))
        stop = stopping_time(ending, impact.v_e)
        is_told, is_clamped = jnp.isfinite(stop), jnp.asarray(body.mobility) == 0
        last = jnp.where(is_told, stop + _rest(rig), LONGEST)
        if not self.effects:  # what has settled is carried along, and a stop sets nothing swinging that presses harder
            settled = _settled(rig)
            last = jnp.where(is_clamped & (settled < begin), jnp.minimum(last, settled), last)
        corners = jnp.minimum(jnp.stack([begin, begin + impact.v_e / deceleration, last]), last)
        spans = jnp.diff(corners, prepend=0.0)
        longest_step = jnp.minimum(self.longest_step, FINE / rate)
        needed = jax.lax.stop_gradient(jnp.ceil(spans / longest_step))
        can_be_followed = (needed <= MOST_STEPS).all()
        steps = jnp.where(can_be_followed & (needed > 0), jnp.maximum(needed, FEWEST_STEPS), 0).astype(int)
        if BRAKES_ITSELF not in self.effects:  # which goes on braking as it did
            effects = [*effects, Braking(deceleration, begin)]
        force = largest_force_through(rig, impact, effects, corners, steps, pull)
        widest = jnp.minimum(longest_step, spans.max() / FEWEST_STEPS)
        between = 1 + jax.lax.stop_gradient(widest * rate) ** 3 / (9 * 3**0.5)
        travelled = jnp.where(impact.v_e > 0, stopping_travel(ending, impact.v_e), 0.0)
        carried = jnp.where(is_clamped, carried_force(rig, impact, travelled), 0.0)
        is_known = jnp.isfinite(force) & (is_told | (impact.v_e == 0)) & can_be_followed
        return Branches(jnp.stack([force * between, carried]), is_known)

    def _against(
        self, z: Float[Array, " p"], body: Body
    ) -> tuple[Rig, list[AbstractEffect], Float[Array, ""]]:
        """Rig and effects against a body, which recoils, and the fastest rate among them, 1/s."""
        rig, effects = unpack(self.effects, z[:-2], self.reach)
        if self.credits_stiffness():
            rig = Rig(rig.m, rig.d, rig.k_f, series_stiffness(rig.k_c, body))
        stiffest = jnp.sqrt((rig.k_f + rig.k_c) * (1 / rig.m + body.mobility))
        # within the decay of a strong damper, as `step_for`: a longer step takes its jump for a peak
        fastest = jnp.maximum(stiffest, STEP_PER_RADIAN * rig.d / rig.m)
        return rig, [*effects, Recoil(jnp.asarray(body.mobility))], fastest

    def is_simulated(self) -> bool:
        return True

    def credits_stiffness(self) -> bool:
        return all(component_of(name) != "contact" for name in self.effects)


def _settled(rig: Rig) -> Scalar:
    """When what the first contact set swinging is gone, s: the rest is carried along. Infinite without damping.

    The slowest decay is that of a flange without contact, delta - sqrt(delta^2 - k_F/m).
    """
    delta, spring = rig.delta, rig.k_f / rig.m
    beyond = delta**2 - spring
    is_overdamped = beyond > 0
    fast = delta + jnp.sqrt(jnp.where(is_overdamped, beyond, 1.0))
    return _over(SETTLED, jnp.where(is_overdamped, spring / fast, delta))


def _rest(rig: Rig) -> Scalar:
    """How long a flange is followed whose robot has stopped, s: a period of the contact, and until it has come back.

    A flange that was thrown off with V comes back within half a period of its own, or within three decay times m/d of
    its flight, which covers less than V m/d: later it would hit with less than V/6.
    """
    back = jnp.minimum(jnp.pi * _over(1.0, jnp.sqrt(rig.k_f / rig.m)), _over(3.0, rig.delta))
    return 2 * jnp.pi / rig.omega + jnp.where(rig.k_f > 0, back, 0.0)


def _over(share: float, rate: Scalar) -> Scalar:
    """share/rate, infinite for a rate of zero."""
    return jnp.where(rate > 0, share / jnp.where(rate > 0, rate, 1.0), jnp.inf)


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
