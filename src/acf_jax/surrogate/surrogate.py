"""A trained network in place of the peak's root find: force, gradient, and a bound on its error."""

from typing import Literal, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from acf_jax.errors import InputError
from acf_jax.model import Impact, Rig
from acf_jax.model.rig import broadcast
from acf_jax.surrogate.box import UNITS, Box
from acf_jax.surrogate.features import AbstractFeatures
from acf_jax.surrogate.fold import distance_to_fold

Scalar = Float[Array, ""]

# Rounding of the force itself, in units in the last place; matters in float32 only.
ULPS = 64


class Prediction(NamedTuple):
    """What the surrogate says of one sample or a batch."""

    f_max: Float[Array, "*batch"]  # N
    gradient: tuple[Rig, Impact]  # dF_max/d(parameter), N per the parameter's unit
    error_bound: Float[Array, "*batch"]  # N, see `Surrogate.error_bound`
    is_inside: Bool[Array, "*batch"]  # in the trained range, with a peak: the bound applies


class Affine(eqx.Module):
    """y = (x - centre)/scale, of one x or of many, one a column."""

    centre: Float[Array, "*shape"]
    scale: Float[Array, "*shape"]

    def __call__(self, x: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
        return (x - _column(self.centre, x)) / _column(self.scale, x)

    def inverse(self, y: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
        return y * _column(self.scale, y) + _column(self.centre, y)


def _column(numbers: Array, x: Array) -> Array:
    """Of as many dimensions as x, the last of which counts samples."""
    return numbers.reshape(numbers.shape + (1,) * (x.ndim - numbers.ndim))


class HeldOutError(eqx.Module):
    """The largest relative error seen on held-out samples, by distance u from the fold."""

    edges: Float[Array, " bins"]  # upper edges of u, the last is 1
    largest: Float[Array, " bins"]  # of this bin and all bins farther from the fold

    def __call__(self, u: Scalar) -> Scalar:
        # `largest` never grows with u, so the largest of this bin and those beyond is this bin's
        return jnp.where(u <= self.edges, self.largest, self.largest[-1]).max()


class Surrogate(eqx.Module):
    """F_max(rig, impact) by a network, for parameters inside a box.

    `force`, `gradient`, `error_bound` and `is_inside` take one sample and map with `jax.vmap`; calling
    the surrogate takes one sample or a batch and refuses what it was not trained for.
    """

    network: eqx.nn.MLP
    x: Affine
    y: Affine
    held_out: HeldOutError
    features: AbstractFeatures = eqx.field(static=True)
    box: Box = eqx.field(static=True)
    header: str = eqx.field(static=True, default="{}")  # JSON: configuration, versions, errors

    def __repr__(self) -> str:
        spans = zip(UNITS.items(), self.box.low, self.box.high, strict=True)
        told = [f"{name} {low:g} to {high:g} {unit}".removesuffix(" 1") for (name, unit), low, high in spans]
        return f"Surrogate of the paper's peak force ({', '.join(told)})"

    def force(self, rig: Rig, impact: Impact) -> Scalar:
        """F_max in N, of one sample; nothing is checked."""
        x = self.x(self.features.coordinates(rig, impact).astype(self.x.scale.dtype))
        return self.features.force(rig, impact, self.y.inverse(self.network(x)))

    def gradient(self, rig: Rig, impact: Impact) -> tuple[Rig, Impact]:
        """dF_max/d(parameter) of one sample, in N per the parameter's unit."""
        gradient: tuple[Rig, Impact] = jax.grad(lambda sample: self.force(*sample))((rig, impact))
        return gradient

    def error_bound(self, rig: Rig, impact: Impact) -> Scalar:
        """The largest error, in N, that held-out samples at most as far from the fold had.

        A bound by experience, not by proof: of n held-out samples drawn as this one is, the chance that
        this one exceeds them all is 1/(n + 1). It says nothing about samples outside the box.
        """
        force = self.force(rig, impact)
        relative = self.held_out(distance_to_fold(rig, impact).u) + ULPS * jnp.finfo(force.dtype).eps
        return relative * force

    def is_inside(self, rig: Rig, impact: Impact) -> Bool[Array, ""]:
        """Whether one sample lies in the box and has a peak."""
        return self.box.has(rig, impact).all() & distance_to_fold(rig, impact).has_peak

    def predict(self, rig: Rig, impact: Impact) -> Prediction:
        """Everything about one sample, as a flag where it was not trained for; for use inside `jax.jit`."""
        return Prediction(
            self.force(rig, impact),
            self.gradient(rig, impact),
            self.error_bound(rig, impact),
            self.is_inside(rig, impact),
        )

    def __call__(self, rig: Rig, impact: Impact, outside: Literal["refuse", "flag"] = "refuse") -> Prediction:
        """Force, gradient and error bound of one sample or of a batch.

        **Arguments:** `rig`, `impact` with fields that are scalars or of shape (N,), which broadcast; `outside`:
        'refuse' raises, 'flag' answers nevertheless with `is_inside` False, where no bound holds.

        **Raises:** `InputError` that lists each parameter outside the trained range, and impacts
        without a peak; `ValueError` for fields of several shapes.
        """
        if any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves((rig, impact))):
            raise ValueError("a traced sample cannot be refused; call `predict` inside jit, grad and vmap")
        prediction: Prediction = _predict(self, rig, impact)
        if outside == "refuse" and not np.all(prediction.is_inside):
            raise InputError(self._faults(rig, impact))
        return prediction

    def _faults(self, rig: Rig, impact: Impact) -> list[str]:
        rig, impact = jax.tree.map(jnp.atleast_1d, broadcast(rig, impact))
        inside = np.asarray(jax.vmap(self.box.has)(rig, impact))
        faults = self.box.faults(rig, impact, inside)
        has_peak = np.asarray(jax.vmap(distance_to_fold)(rig, impact).has_peak)
        without = np.flatnonzero(~has_peak & inside.all(axis=1))
        if without.size:
            faults.append(f"sample {without[0]} has no peak ({without.size} of {has_peak.size})")
        remedy = "; use acf_jax.model.find_peak there, or pass outside='flag'"
        return [fault + remedy for fault in faults]


@eqx.filter_jit
def _predict(surrogate: Surrogate, rig: Rig, impact: Impact) -> Prediction:
    rig, impact = broadcast(rig, impact)
    predict = Surrogate.predict if rig.m.shape == () else jax.vmap(Surrogate.predict, (None, 0, 0))
    prediction: Prediction = predict(surrogate, rig, impact)
    return prediction
