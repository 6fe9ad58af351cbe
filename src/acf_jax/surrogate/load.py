"""A surrogate as a file: model.eqx."""

import json
from pathlib import Path
from typing import Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from acf_jax.errors import InputError
from acf_jax.surrogate.box import UNITS, Box
from acf_jax.surrogate.features import FEATURES
from acf_jax.surrogate.saved import read_header, read_leaves, write_tree
from acf_jax.surrogate.surrogate import Affine, HeldOutError, Surrogate

FORMAT = "acf-jax surrogate 1"
DEFAULT = Path(__file__).with_name("default.eqx")

ACTIVATIONS = {"tanh": jnp.tanh, "silu": jax.nn.silu, "gelu": jax.nn.gelu, "softplus": jax.nn.softplus}


class Shape(BaseModel):
    """The network's layers."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    width: int = Field(ge=1, le=1024, description="units of a hidden layer")
    depth: int = Field(ge=1, le=16, description="hidden layers")
    activation: Literal["tanh", "silu", "gelu", "softplus"] = "tanh"


class _Interval(BaseModel):
    low: float = Field(allow_inf_nan=False)
    high: float = Field(allow_inf_nan=False)


class _Header(BaseModel):
    """What the file must say before its leaves are read."""

    format: Literal["acf-jax surrogate 1"]
    features: Literal["raw", "dimensionless", "fold"]
    network: Shape
    dtype: Literal["float32", "float64"]
    bins: int = Field(ge=1, le=1000)
    ranges: dict[str, _Interval]


def new_network(inputs: int, shape: Shape, dtype: Any, key: Any) -> eqx.nn.MLP:
    """A multilayer perceptron from `inputs` numbers to one."""
    activation = ACTIVATIONS[shape.activation]
    return eqx.nn.MLP(inputs, "scalar", shape.width, shape.depth, activation, dtype=dtype, key=key)


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
    try:
        checked = _Header.model_validate(header)
    except ValidationError as error:
        faults = [f"{path}: header, {_dotted(e['loc'])}: {e['msg']}" for e in error.errors()]
        raise InputError([fault + "; train it again with this version" for fault in faults]) from None
    if set(checked.ranges) != set(UNITS):
        raise InputError(f"{path}: header, ranges: must name {', '.join(UNITS)}; train it again")

    surrogate = read_leaves(path, body, _like(checked, json.dumps(header)))
    if not all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(eqx.filter(surrogate, eqx.is_array))):
        raise InputError(f"{path}: holds numbers that are not finite; train it again")
    return with_dtype(surrogate, float)


def with_dtype(surrogate: Surrogate, dtype: Any) -> Surrogate:
    """The surrogate with its arrays in another precision."""
    arrays, rest = eqx.partition(surrogate, eqx.is_array)
    cast: Surrogate = eqx.combine(jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype), arrays), rest)
    return cast


def _like(header: _Header, text: str) -> Surrogate:
    """A surrogate of the header's shape, its numbers still to come."""
    dtype, features = np.dtype(header.dtype), FEATURES[header.features]
    inputs = len(features.inputs)

    def blank(*shape: int) -> Any:
        # NumPy's, because JAX without x64 has no float64
        return np.zeros(shape, dtype)

    network = eqx.filter_eval_shape(new_network, inputs, header.network, float, jax.random.key(0))
    network = jax.tree.map(
        lambda leaf: blank(*leaf.shape) if isinstance(leaf, jax.ShapeDtypeStruct) else leaf, network
    )
    return Surrogate(
        network,
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


def _dotted(location: tuple[int | str, ...]) -> str:
    return ".".join(map(str, location))
