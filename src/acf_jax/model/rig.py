"""The rig's parameters and one impact, in the paper's symbols."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float


def _parameter(value: ArrayLike) -> Array:
    """The value as a floating array: in its own precision from float32 on, else in JAX's default.

    Half precision ends at 65504, below any contact's stiffness in N/m, and is computed in float32.
    """
    if isinstance(value, int | np.integer | np.ndarray) and np.asarray(value).dtype.kind in "iuO":
        value = _as_float(value)  # JAX's integers may have 32 bits only
    array = jnp.asarray(value)
    if jnp.issubdtype(array.dtype, jnp.floating):
        return array.astype(jnp.float32) if jnp.finfo(array.dtype).bits < 32 else array
    if jnp.issubdtype(array.dtype, jnp.integer):
        return array.astype(float)
    raise ValueError(f"parameters must be real numbers, but are {array.dtype}; give values in SI units")


def _as_float(value: ArrayLike) -> np.ndarray | float:
    """Integers of any size; what float64 does not hold is infinite."""
    try:
        return np.asarray(value, float)
    except OverflowError:
        return np.inf


def _check_ranges(owner: eqx.Module, positive: tuple[str, ...], not_negative: tuple[str, ...]) -> None:
    """Raise `ValueError` that lists each field outside its range; traced values cannot be checked.

    Beyond sizes that no rig has, far from float64's ends but not from float32's, (k_C/K)^2 and the like would
    underflow, and the peak would not be a number.
    """
    faults = []
    for name in positive + not_negative:
        field = getattr(owner, name)
        if isinstance(field, jax.core.Tracer):
            continue
        value = np.asarray(field)  # NumPy compares without compiling anything
        root = float(jnp.finfo(value.dtype).tiny) ** 0.25
        low, high = (16 * root if name in positive else 0.0), 4 / root
        sign = "positive" if name in positive else "zero or positive"
        for is_right, what in (
            (np.isfinite(value) & (value > 0 if name in positive else value >= 0), f"finite and {sign}"),
            ((value >= low) & (value <= high), f"between {low:.2g} and {high:.2g} in {value.dtype}"),
        ):
            if not is_right.all():
                shown = value[~is_right].flat[0]
                faults.append(f"{type(owner).__name__}.{name} must be {what}, but is {shown:g}")
                break
    if faults:
        raise ValueError("; ".join(faults) + "; give values in SI units (kg, N s/m, N/m, m/s, N)")


class Rig(eqx.Module):
    """An active contact flange on a robot, meeting a part: Eqs. (1) and (2) of the paper.

    Fields are scalars; arrays make a batch for `jax.vmap`, where all have the same axis, or for `find_peaks`.

    **Raises:** `ValueError` when a concrete value cannot be that of a rig; traced values are not checked.
    """

    m: Float[Array, "*batch"]  # kg, moving mass of the flange, > 0
    d: Float[Array, "*batch"]  # N s/m, damping of the flange, >= 0
    k_f: Float[Array, "*batch"]  # N/m, stiffness of the actuator, >= 0
    k_c: Float[Array, "*batch"]  # N/m, stiffness of the contact, > 0

    def __init__(self, m: ArrayLike, d: ArrayLike, k_f: ArrayLike, k_c: ArrayLike):
        self.m, self.d, self.k_f, self.k_c = map(_parameter, (m, d, k_f, k_c))

    def __check_init__(self) -> None:
        _check_ranges(self, positive=("m", "k_c"), not_negative=("d", "k_f"))

    def __repr__(self) -> str:
        return _shown(self, ("kg", "N s/m", "N/m", "N/m"))

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
        _check_ranges(self, positive=(), not_negative=("v_e", "f_p"))

    def __repr__(self) -> str:
        return _shown(self, ("m/s", "N"))


def common_shape(rig: Rig, impact: Impact) -> tuple[int, ...]:
    """The shape that all fields broadcast to: () of one sample.

    **Raises:** `ValueError` when their shapes do not fit each other.
    """
    shapes = [jnp.shape(field) for field in jax.tree.leaves((rig, impact))]
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError:
        found = " and ".join(map(str, sorted(set(shapes))))
        raise ValueError(
            f"the fields of rig and impact must broadcast to one shape, but theirs are {found}; give each a number, or"
            " arrays of one length"
        ) from None


def broadcast(rig: Rig, impact: Impact) -> tuple[Rig, Impact]:
    """Rig and impact with every field repeated to their common shape.

    **Raises:** `ValueError` when their shapes do not fit each other.
    """
    shape = common_shape(rig, impact)
    repeated: tuple[Rig, Impact] = jax.tree.map(lambda field: jnp.broadcast_to(field, shape), (rig, impact))
    return repeated


def quantity(value: object, unit: str) -> str:
    """A number, or what an array holds, with its unit: `4 kg`, `0.05 to 0.35 m/s (5,)`; of a traced value its type."""
    if isinstance(value, jax.core.Tracer) or not hasattr(value, "shape"):
        return f"{value} {unit}"
    values = np.asarray(value)
    if values.ndim == 0 or not values.size:
        return f"{values:.6g} {unit}" if values.size else f"no {unit}"
    return f"{values.min():.6g} to {values.max():.6g} {unit} {values.shape}"


def _shown(module: eqx.Module, units: tuple[str, ...]) -> str:
    """A module of quantities on one line."""
    fields = zip(module.__dataclass_fields__, units, strict=True)
    written = ", ".join(f"{name}={quantity(getattr(module, name), unit)}" for name, unit in fields)
    return f"{type(module).__name__}({written})"
