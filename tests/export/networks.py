"""Surrogates with untrained networks, for what must hold whatever the numbers are."""

import jax
import jax.numpy as jnp

from acf_jax.surrogate import Surrogate, load_surrogate
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
