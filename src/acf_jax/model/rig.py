"""The rig's parameters and one impact, in the paper's symbols."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float


class Rig(eqx.Module):
    """An active contact flange on a robot, meeting a part (paper, Eqs. 1 and 2).

    Raises `ValueError` when a value cannot be that of a rig. Fields may be batched by `jax.vmap`.
    """

    m: Float[Array, ""]  # kg, moving mass of the flange, > 0
    d: Float[Array, ""]  # N s/m, damping of the flange, >= 0
    k_f: Float[Array, ""]  # N/m, stiffness of the actuator, >= 0
    k_c: Float[Array, ""]  # N/m, stiffness of the contact, > 0

    def __init__(self, m: float, d: float, k_f: float, k_c: float):
        self.m, self.d, self.k_f, self.k_c = (jnp.asarray(x, float) for x in (m, d, k_f, k_c))


class Impact(eqx.Module):
    """How robot and part meet: contact velocity and pretension."""

    v_e: Float[Array, ""]  # m/s, contact velocity, >= 0
    f_p: Float[Array, ""]  # N, pretension F_P, >= 0

    def __init__(self, v_e: float, f_p: float):
        self.v_e, self.f_p = jnp.asarray(v_e, float), jnp.asarray(f_p, float)
