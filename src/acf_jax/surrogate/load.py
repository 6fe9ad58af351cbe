"""A surrogate as a file: model.eqx."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from pydantic import BaseModel, Field, FiniteFloat

from acf_jax.errors import InputError
from acf_jax.forms import Form, Part, check_form
from acf_jax.surrogate.box import UNITS, Box, sign_fault
from acf_jax.surrogate.features import FEATURES
from acf_jax.surrogate.saved import read_header, read_leaves, write_tree
from acf_jax.surrogate.surrogate import Affine, HeldOutError, Surrogate

Tree = TypeVar("Tree")

FORMAT = "acf-jax surrogate 1"
DEFAULT = Path(__file__).with_name("default.eqx")

ACTIVATIONS = {
    "tanh": jnp.tanh,
    "silu": jax.nn.silu,
    "gelu": jax.nn.gelu,
    "softplus": jax.nn.softplus,
    "softsign": jax.nn.soft_sign,  # x/(1 + |x|): no exponential, which is most of what the others cost
}


class Shape(Part):
    """The network's layers."""

    width: int = Field(ge=1, le=1024, description="units of a hidden layer")
    depth: int = Field(ge=1, le=16, description="hidden layers")
    activation: Literal["tanh", "silu", "gelu", "softplus", "softsign"] = "tanh"


class _Interval(BaseModel):
    low: FiniteFloat
    high: FiniteFloat
    unit: str


class _Header(BaseModel):
    """What the file must say before its leaves are read."""

    format: Literal["acf-jax surrogate 1"]
    features: Literal["raw", "dimensionless", "fold"]
    network: Shape
    dtype: Literal["float32", "float64"]
    bins: int = Field(ge=1, le=1000)
    ranges: dict[str, _Interval]


def new_network(
    inputs: int, shape: Shape, dtype: Any, key: Any, outputs: int | Literal["scalar"] = "scalar"
) -> eqx.nn.MLP:
    """A multilayer perceptron from `inputs` numbers to one, or to a vector of `outputs`."""
    activation = ACTIVATIONS[shape.activation]
    return eqx.nn.MLP(inputs, outputs, shape.width, shape.depth, activation, dtype=dtype, key=key)


def blank_network(
    inputs: int, shape: Shape, dtype: Any, outputs: int | Literal["scalar"] = "scalar"
) -> eqx.nn.MLP:
    """The same without numbers, for a file to fill: NumPy's, because JAX without x64 has no float64."""
    network = eqx.filter_eval_shape(new_network, inputs, shape, float, jax.random.key(0), outputs)
    blank: eqx.nn.MLP = jax.tree.map(
        lambda leaf: np.zeros(leaf.shape, dtype) if isinstance(leaf, jax.ShapeDtypeStruct) else leaf, network
    )
    return blank


def save_surrogate(path: Path, surrogate: Surrogate, shape: Shape, more: dict[str, Any]) -> None:
    """Write model.eqx; `more` goes into its header (configuration, versions, errors)."""
    ranges = {
        name: {"low": low, "high": high, "unit": unit}
        for (name, unit), low, high in zip(UNITS.items(), surrogate.box.low, surrogate.box.high, strict=True)
    }
    header = {
        "format": FORMAT,
        "features": surrogate.features.name,
        "network": shape.model_dump(),
        "dtype": str(surrogate.x.scale.dtype),
        "bins": surrogate.held_out.largest.size,
        "ranges": ranges,
    }
    write_tree(path, {**header, **more}, surrogate)


def load_surrogate(path: Path | str | None = None) -> Surrogate:
    """The surrogate in a `model.eqx` that train.fit wrote; without a path, the one shipped with acf_jax.

    Its arrays take JAX's default precision, so that the force and its gradient are as smooth as the inputs.

    **Raises:** `InputError` when the file is missing, damaged, or none of ours.
    """
    path = DEFAULT if path is None else Path(path)
    header, body = read_header(path)
    checked = check_header(path, header, _Header)
    if set(checked.ranges) != set(UNITS):
        raise InputError(f"{path}: header: ranges: must name {', '.join(UNITS)}; train it again")
    if strange := [name for name, unit in UNITS.items() if checked.ranges[name].unit != unit]:
        raise InputError(
            f"{path}: header: ranges.{strange[0]}: must be in {UNITS[strange[0]]}; train it again"
        )
    check_ranges(path, {name: (found.low, found.high) for name, found in checked.ranges.items()})

    surrogate = fill(path, body, _like(checked, json.dumps(header)))
    check_scales(path, surrogate.x, surrogate.y)
    edges, largest = np.asarray(surrogate.held_out.edges), np.asarray(surrogate.held_out.largest)
    if (np.diff(edges, prepend=0) <= 0).any() or edges[-1] != 1:
        raise InputError(f"{path}: the bins of its error bound do not lead from 0 to 1; train it again")
    if (largest < 0).any() or (np.diff(largest) > 0).any():
        raise InputError(f"{path}: its error bound is negative, or shrinks towards the fold; train it again")
    return surrogate


def check_header(path: Path, header: dict[str, Any], form: type[Form]) -> Form:
    """The header in its form; `InputError` lists what does not fit."""
    return check_form(form, header, f"{path}: header", "train it again with this version")


def check_ranges(path: Path, ranges: Mapping[str, tuple[float, float]]) -> None:
    """`InputError` that lists the ranges that no rig and no impact has."""
    faults = []
    for name, (low, high) in ranges.items():
        if low > high:
            faults.append(f"{name}: low ({low:g}) is above high ({high:g})")
        elif fault := sign_fault(name, low):
            faults.append(f"{name}: {fault.partition(';')[0]}")
    if faults:
        raise InputError([f"{path}: header: ranges.{fault}; train it again" for fault in faults])


def check_scales(path: Path, *scales: Affine) -> None:
    """`InputError` where a network's inputs or outputs are not scaled by positive numbers."""
    if any((np.asarray(affine.scale) <= 0).any() for affine in scales):
        raise InputError(f"{path}: holds scales that are not above 0; train it again")


def fill(path: Path, body: bytes, like: Tree) -> Tree:
    """The module `like` with the numbers in a file's body, in JAX's default precision."""
    with np.errstate(over="ignore", invalid="ignore"):  # what is no number in JAX's precision is told
        filled = with_dtype(read_leaves(path, body, like), float)
    if not all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(eqx.filter(filled, eqx.is_array))):
        raise InputError(f"{path}: holds numbers that are not finite; train it again")
    return filled


def with_dtype(surrogate: Tree, dtype: Any) -> Tree:
    """The surrogate with its arrays in another precision."""
    arrays, rest = eqx.partition(surrogate, eqx.is_array)
    cast: Tree = eqx.combine(jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype), arrays), rest)
    return cast


def _like(header: _Header, text: str) -> Surrogate:
    """A surrogate of the header's shape, its numbers still to come."""
    dtype, features = np.dtype(header.dtype), FEATURES[header.features]
    inputs = len(features.inputs)

    def blank(*shape: int) -> Any:
        return np.zeros(shape, dtype)

    return Surrogate(
        blank_network(inputs, header.network, dtype),
        x=Affine(blank(inputs), blank(inputs)),
        y=Affine(blank(), blank()),
        held_out=HeldOutError(blank(header.bins), blank(header.bins)),
        features=features,
        box=Box(
            tuple(header.ranges[name].low for name in UNITS),
            tuple(header.ranges[name].high for name in UNITS),
        ),
        header=text,
    )
