"""Surrogates with untrained networks, for what must hold whatever the numbers are."""

import jax
import jax.numpy as jnp

from acf_jax.surrogate import CorrectedSurrogate, Surrogate, load_surrogate
from acf_jax.surrogate.corrected import FEATURES as ADDED
from acf_jax.surrogate.corrected import OUTPUTS, Bounds, Domain
from acf_jax.surrogate.features import FEATURES
from acf_jax.surrogate.load import Shape, new_network
from acf_jax.surrogate.surrogate import Affine


def untrained(features: str, activation: str = "tanh") -> Surrogate:
    """The shipped surrogate's box and bound around another network, of odd sizes."""
    shipped, inputs = load_surrogate(), len(FEATURES[features].inputs)
    network = new_network(inputs, Shape(width=7, depth=2, activation=activation), float, jax.random.key(3))
    x = Affine(jnp.linspace(0.1, 0.7, inputs), jnp.linspace(1.0, 9.0, inputs))
    y = Affine(jnp.array(0.2), jnp.array(0.3))
    return Surrogate(network, x, y, shipped.held_out, FEATURES[features], shipped.box)


def untrained_corrected(free: tuple[str, ...]) -> CorrectedSurrogate:
    """A surrogate of a corrected model in which what is not `free` is fixed."""
    quantities = {
        "m": ("kg", 1.5, 2.5), "d": ("N s/m", 20.0, 90.0), "k_f": ("N/m", 0.0, 1500.0), "k_c": ("N/m", 5e4, 1e5),
        "gravity.force_n": ("N", -12.0, 9.0), "v_e": ("m/s", 0.02, 0.5), "f_p": ("N", 0.0, 120.0),
        "mobility": ("1/kg", 0.0, 2.0),
    }  # fmt: skip
    units, low, high = zip(*quantities.values(), strict=True)
    high = tuple(h if name in free else at for name, at, h in zip(quantities, low, high, strict=True))
    domain = Domain(tuple(quantities), units, low, high, tuple(name in ("m", "v_e") for name in quantities))
    inputs, outputs = len(free) + len(ADDED), len(OUTPUTS)
    network = new_network(inputs, Shape(width=8, depth=2), float, jax.random.key(1), outputs)
    x = Affine(jnp.linspace(0.1, 0.7, inputs), jnp.linspace(1.0, 9.0, inputs))
    bounds = Bounds(*map(jnp.asarray, (2e-3, 1e-5, 0.0)))
    return CorrectedSurrogate(network, x, Affine(jnp.zeros(3), jnp.full(3, 0.2)), bounds, domain)
