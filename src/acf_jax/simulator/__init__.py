"""The paper's model with any set of effects, integrated in time."""

from acf_jax.simulator.peak import LargestForce as LargestForce
from acf_jax.simulator.peak import largest_force as largest_force
from acf_jax.simulator.simulate import Response as Response
from acf_jax.simulator.simulate import simulate as simulate
