"""A trained network in place of a simulation: peak force and its time of a model without a closed form.

One sample is a vector q = (m, d, k_F, k, parameters of effects, v_E, F_P, 1/m_H): what a corrected model depends on,
with k the contact's stiffness in series with a body's, and 1/m_H the mobility of a body that recoils, zero for a wall.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from acf_jax.surrogate.surrogate import Affine

Scalar = Float[Array, ""]

M, D, K_F, K, V_E, F_P, MOBILITY = 0, 1, 2, 3, -3, -2, -1  # places in q
FIRST, LAST = ("m", "d", "k_f", "k_c"), ("v_e", "f_p", "mobility")  # the names at these places
FEATURES = ("F_P/F_0", "zeta")  # what the network sees besides its inputs
OUTPUTS = ("ln(F_max/F_0)", "omega t_max", "whether it answers")
HALF_PERIOD = jnp.pi  # omega t, by which the first peak has come

# Values that were computed may miss a face of the box by rounding.
_ROUNDING = 1e-9


class Domain(eqx.Module):
    """The box of q that a surrogate was trained in; where both ends are equal, the value is fixed."""

    names: tuple[str, ...] = eqx.field(static=True)
    units: tuple[str, ...] = eqx.field(static=True)
    low: tuple[float, ...] = eqx.field(static=True)
    high: tuple[float, ...] = eqx.field(static=True)
    logarithmic: tuple[bool, ...] = eqx.field(static=True)  # samples and network see the logarithm

    @property
    def free(self) -> tuple[int, ...]:
        """The places of the inputs: what is not fixed."""
        return tuple(i for i, (low, high) in enumerate(zip(self.low, self.high, strict=True)) if low < high)

    def span(self, name: str) -> tuple[float, float] | None:
        """Lowest and highest value of a quantity; None for one that the box does not name."""
        return dict(zip(self.names, zip(self.low, self.high, strict=True), strict=True)).get(name)

    def has(self, q: Float[Array, "q *n"]) -> Bool[Array, "q *n"]:
        """Which values of one sample or more lie in the box."""
        shape = (-1,) + (1,) * (q.ndim - 1)
        low, high = jnp.asarray(self.low).reshape(shape), jnp.asarray(self.high).reshape(shape)
        slack = _ROUNDING * jnp.maximum(jnp.abs(low), jnp.abs(high))
        return (q >= low - slack) & (q <= high + slack)

    def at(self, unit: np.ndarray) -> np.ndarray:
        """Samples q (n, q) of points in the unit cube (n, inputs)."""
        q = np.tile(np.array(self.low), (len(unit), 1))
        for column, i in zip(unit.T, self.free, strict=True):
            low, high = self.low[i], self.high[i]
            is_log = self.logarithmic[i]
            q[:, i] = low * (high / low) ** column if is_log else (1 - column) * low + column * high
        return q

    def faults(self, q: np.ndarray) -> list[str]:
        """Why the surrogate does not answer for one sample."""
        outside = np.flatnonzero(~np.asarray(self.has(jnp.asarray(q))))
        if not outside.size:
            return ["the force may be larger after its first peak than at it: simulate this one"]
        return [
            f"{self.names[i]} = {q[i]:g} {self.units[i]} lies outside the trained {self.low[i]:g} to {self.high[i]:g}"
            for i in outside
        ]


class Bounds(eqx.Module):
    """What the errors stayed below, on held-out samples and in a search for the worst one, with some margin."""

    force: Scalar  # relative
    time: Scalar  # s
    least: Scalar  # of the third output: below it the surrogate does not answer


class CorrectedPrediction(NamedTuple):
    """What the surrogate says of one sample, or of n."""

    force: Float[Array, "*n"]  # N
    time: Float[Array, "*n"]  # s
    error_bound: Float[Array, "*n"]  # N
    is_inside: Bool[Array, "*n"]  # in the trained box, largest at the first peak: the bound applies


class CorrectedSurrogate(eqx.Module):
    """Peak force and its time over q, by one network with three outputs.

    x = (inputs, F_P/F_0, zeta),  y = (ln(F_max/F_0), omega t_max, a),  F_0 = sqrt(F_P^2 + k mu v_E^2)

    F_0 is the paper's peak for d = k_F = 0; mu = m/(1 + m/m_H), omega = sqrt((k_F + k)/mu), zeta = d/(2 mu omega). The
    force is learnt where it is largest within half a period, omega t_max < pi. Where it grows beyond that later, as
    k_F pushes back while the robot goes on, a is trained to be 0 instead of 1, and the surrogate does not answer.

    Takes one sample, or many as the columns of q, (q, n): each layer is then one product of matrices as they lie in
    memory, about twice as fast as `jax.vmap` over rows.
    """

    network: eqx.nn.MLP
    x: Affine
    y: Affine
    bounds: Bounds
    domain: Domain
    which: str = eqx.field(static=True, default="contact")  # the force learnt: at the contact, or sensed
    header: str = eqx.field(static=True, default="{}")  # JSON: model, configuration, versions, errors

    def __call__(self, q: Float[Array, "q *n"]) -> tuple[Float[Array, "*n"], ...]:
        """Peak force in N, its time in s, and a; nothing is checked."""
        x = self.x(coordinates(self.domain, q).astype(self.x.scale.dtype))
        y, scales = self.y.inverse(_layers(self.network, x)), _scales(q)
        return scales.force * jnp.exp(y[0]), y[1] / scales.omega, y[2]

    def predict(self, q: Float[Array, "q *n"]) -> CorrectedPrediction:
        """Everything about one sample or more, as a flag where it was not trained for."""
        force, time, a = self(q)
        is_inside = self.domain.has(q).all(0) & (a > self.bounds.least)
        return CorrectedPrediction(force, time, self.bounds.force * force, is_inside)


def _layers(network: eqx.nn.MLP, x: Float[Array, "inputs *n"]) -> Float[Array, "outputs *n"]:
    """The network of one sample, or of columns."""
    if x.ndim == 1:
        outputs: Array = network(x)
        return outputs
    *hidden, last = [(layer.weight, layer.bias) for layer in network.layers if layer.bias is not None]
    for weight, bias in hidden:
        x = network.activation(weight @ x + bias[:, None])
    return last[0] @ x + last[1][:, None]


class _Scales(NamedTuple):
    force: Float[Array, "*n"]  # N, F_0
    omega: Float[Array, "*n"]  # rad/s
    zeta: Float[Array, "*n"]


def _scales(q: Float[Array, "q *n"]) -> _Scales:
    mu = q[M] / (1 + q[M] * q[MOBILITY])
    omega = jnp.sqrt((q[K_F] + q[K]) / mu)
    return _Scales(jnp.sqrt(q[F_P] ** 2 + q[K] * mu * q[V_E] ** 2), omega, q[D] / (2 * mu * omega))


def coordinates(domain: Domain, q: Float[Array, "q *n"]) -> Float[Array, "inputs *n"]:
    """What the network sees of one sample or more, before scaling."""
    own = [jnp.log(q[i]) if domain.logarithmic[i] else q[i] for i in domain.free]
    scales = _scales(q)
    return jnp.stack([*own, q[F_P] / scales.force, scales.zeta])


def is_first_peak(q: Float[Array, " q"], time: Scalar, exists: Bool[Array, ""]) -> Bool[Array, ""]:
    """Whether the largest force of one sample is that of the first peak."""
    return exists & (_scales(q).omega * time < HALF_PERIOD)


def targets(q: Float[Array, " q"], force: Scalar, time: Scalar, exists: Bool[Array, ""]) -> Float[Array, "3"]:
    """What the network is to predict of one sample, before scaling; NaN where anything will do."""
    scales, is_first = _scales(q), is_first_peak(q, time, exists)
    y = jnp.stack([jnp.log(force / scales.force), scales.omega * time])
    return jnp.append(jnp.where(is_first, y, jnp.nan), is_first.astype(float))
