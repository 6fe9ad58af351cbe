"""The paper's model with any set of effects, integrated in time."""

from acf_jax.simulator.simulate import Response as Response
from acf_jax.simulator.simulate import simulate as simulate
