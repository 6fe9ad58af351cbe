"""The rig's parameters and one impact, in the paper's symbols."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float


def _parameter(value: ArrayLike) -> Array:
    """The value as a floating array; its own precision where it has one, JAX's default otherwise."""
    array = jnp.asarray(value)
    return array if jnp.issubdtype(array.dtype, jnp.floating) else array.astype(float)


def _check_signs(owner: eqx.Module, positive: tuple[str, ...], not_negative: tuple[str, ...]) -> None:
    """Raise `ValueError` that lists each field outside its range; traced values cannot be checked."""
    faults = []
    for name in positive + not_negative:
        field = getattr(owner, name)
        if isinstance(field, jax.core.Tracer):
            continue
        value = np.asarray(field)  # NumPy compares without compiling anything
        in_range = np.isfinite(value) & (value > 0 if name in positive else value >= 0)
        if not in_range.all():
            range_ = "positive" if name in positive else "zero or positive"
            shown = value[~in_range].flat[0]
            faults.append(f"{type(owner).__name__}.{name} must be finite and {range_}, but is {shown:g}")
    if faults:
        raise ValueError("; ".join(faults) + "; give values in SI units (kg, N s/m, N/m, m/s, N)")


class Rig(eqx.Module):
    """An active contact flange on a robot, meeting a part: Eqs. (1) and (2) of the paper.

    Fields are scalars; a leading axis, the same for all, makes a batch for `jax.vmap` or `find_peaks`.

    **Raises:** `ValueError` when a concrete value cannot be that of a rig; traced values are not checked.
    """

    m: Float[Array, "*batch"]  # kg, moving mass of the flange, > 0
    d: Float[Array, "*batch"]  # N s/m, damping of the flange, >= 0
    k_f: Float[Array, "*batch"]  # N/m, stiffness of the actuator, >= 0
    k_c: Float[Array, "*batch"]  # N/m, stiffness of the contact, > 0

    def __init__(self, m: ArrayLike, d: ArrayLike, k_f: ArrayLike, k_c: ArrayLike):
        self.m, self.d, self.k_f, self.k_c = map(_parameter, (m, d, k_f, k_c))

    def __check_init__(self) -> None:
        _check_signs(self, positive=("m", "k_c"), not_negative=("d", "k_f"))

    @property
    def k(self) -> Array:
        """K = k_F + k_C, the stiffness the moving mass sees in contact, N/m (Eq. 3)."""
        return self.k_f + self.k_c

    @property
    def omega(self) -> Array:
        """omega = sqrt((k_F + k_C)/m), natural frequency in contact, rad/s (Eq. 4)."""
        return jnp.sqrt(self.k / self.m)

    @property
    def delta(self) -> Array:
        """delta = d/(2 m), decay rate, 1/s (Eq. 4)."""
        return self.d / (2 * self.m)

    @property
    def zeta(self) -> Array:
        """zeta = delta/omega, damping ratio: 1 is critical."""
        return self.d / (2 * jnp.sqrt(self.m * self.k))


class Impact(eqx.Module):
    """How robot and part meet: contact velocity and pretension.

    **Raises:** `ValueError` when a concrete value is negative or not finite; traced values are not checked.
    """

    v_e: Float[Array, "*batch"]  # m/s, contact velocity, >= 0
    f_p: Float[Array, "*batch"]  # N, pretension F_P, >= 0

    def __init__(self, v_e: ArrayLike, f_p: ArrayLike):
        self.v_e, self.f_p = _parameter(v_e), _parameter(f_p)

    def __check_init__(self) -> None:
        _check_signs(self, positive=(), not_negative=("v_e", "f_p"))


def shape_of(rig: Rig, impact: Impact) -> tuple[int, ...]:
    """The shape that all fields have in common: () of one sample, (N,) of a batch.

    **Raises:** `ValueError` when they have several.
    """
    shapes = sorted({jnp.shape(field) for field in jax.tree.leaves((rig, impact))})
    if len(shapes) > 1:
        found = " and ".join(map(str, shapes))
        raise ValueError(
            f"all fields of rig and impact must have one shape, but theirs are {found}; repeat what they share, as in"
            " jnp.full_like(v_e, 100.0)"
        )
    return shapes[0]
