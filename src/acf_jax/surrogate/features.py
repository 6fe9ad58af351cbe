"""What the network sees, what it predicts, and how a force follows from that."""

import abc
from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from acf_jax.model import Impact, Peak, Rig, contact_force
from acf_jax.surrogate.fold import distance_to_fold

Scalar = Float[Array, ""]


class AbstractFeatures(eqx.Module):
    """Coordinates of the peak force: inputs x and output y of the network, and F_max(x, y)."""

    name: ClassVar[str]
    inputs: ClassVar[tuple[str, ...]]
    meaning: ClassVar[str]

    @abc.abstractmethod
    def coordinates(self, rig: Rig, impact: Impact) -> Float[Array, " inputs"]:
        """x of one sample."""

    @abc.abstractmethod
    def target(self, rig: Rig, impact: Impact, peak: Peak) -> Scalar:
        """y of one sample whose peak is known."""

    @abc.abstractmethod
    def force(self, rig: Rig, impact: Impact, y: Scalar) -> Scalar:
        """F_max in N that y stands for."""


class RawFeatures(AbstractFeatures):
    """The six parameters and log F_max: no physics. Logarithms where a quantity spans decades."""

    name = "raw"
    inputs = ("ln m", "d", "k_F", "ln k_C", "ln v", "F_P")
    meaning = "six parameters to ln F_max"

    def coordinates(self, rig: Rig, impact: Impact) -> Float[Array, " inputs"]:
        return jnp.stack([jnp.log(rig.m), rig.d, rig.k_f, jnp.log(rig.k_c), jnp.log(impact.v_e), impact.f_p])

    def target(self, rig: Rig, impact: Impact, peak: Peak) -> Scalar:
        return jnp.log(peak.f_max)

    def force(self, rig: Rig, impact: Impact, y: Scalar) -> Scalar:
        return jnp.exp(y)


class DimensionlessFeatures(AbstractFeatures):
    """The three groups, and F_max over its value for d = k_F = 0.

    x = (zeta, kappa, F_P/F_0),  y = ln(F_max/F_0),  F_0 = sqrt(F_P^2 + k_C m v^2)

    F_P/F_0 = p/sqrt(p^2 + kappa) is the group p, mapped to [0, 1].
    """

    name = "dimensionless"
    inputs = ("zeta", "kappa", "p/sqrt(p^2 + kappa)")
    meaning = "three dimensionless groups to ln(F_max/F_0)"

    def coordinates(self, rig: Rig, impact: Impact) -> Float[Array, " inputs"]:
        return jnp.stack([rig.zeta, rig.k_c / rig.k, impact.f_p / _undamped_force(rig, impact)])

    def target(self, rig: Rig, impact: Impact, peak: Peak) -> Scalar:
        return jnp.log(peak.f_max / _undamped_force(rig, impact))

    def force(self, rig: Rig, impact: Impact, y: Scalar) -> Scalar:
        return _undamped_force(rig, impact) * jnp.exp(y)


class FoldFeatures(AbstractFeatures):
    """Damping ratio and distance from the fold, to the time of the peak; Eq. (8) gives its force.

    x = (zeta, u),  y = sigma/sigma_m,  F_max = F_C((tau_0 + sigma)/omega)

    In u the time is smooth up to the fold, and three groups become two. The force is stationary in
    time, so the network's error enters squared - and always as an under-prediction.
    """

    name = "fold"
    inputs = ("zeta", "u")
    meaning = "damping ratio and distance from the fold to the peak's time, then Eq. (8)"

    def coordinates(self, rig: Rig, impact: Impact) -> Float[Array, " inputs"]:
        return jnp.stack([rig.zeta, distance_to_fold(rig, impact).u])

    def target(self, rig: Rig, impact: Impact, peak: Peak) -> Scalar:
        fold = distance_to_fold(rig, impact)
        return (rig.omega * peak.t_max - fold.tau_0) / fold.sigma_m

    def force(self, rig: Rig, impact: Impact, y: Scalar) -> Scalar:
        fold = distance_to_fold(rig, impact)
        return contact_force(rig, impact, (fold.tau_0 + fold.sigma_m * y) / rig.omega)


def _undamped_force(rig: Rig, impact: Impact) -> Scalar:
    return jnp.sqrt(impact.f_p**2 + rig.k_c * rig.m * impact.v_e**2)


FEATURES = {features.name: features for features in (RawFeatures(), DimensionlessFeatures(), FoldFeatures())}
