"""A surrogate of a corrected model as a file: model.eqx, which carries the model that it stands for."""

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import jax
import numpy as np
from pydantic import BaseModel, Field

from acf_jax.errors import InputError
from acf_jax.surrogate.corrected import FEATURES, FIRST, LAST, OUTPUTS, Bounds, CorrectedSurrogate, Domain
from acf_jax.surrogate.load import (
    Shape,
    blank_network,
    check_header,
    check_ranges,
    check_scales,
    fill,
)
from acf_jax.surrogate.saved import read_header, write_tree
from acf_jax.surrogate.surrogate import Affine

FORMAT = "acf-jax corrected surrogate 1"

Finite = Annotated[float, Field(allow_inf_nan=False)]


class _Domain(BaseModel):
    names: tuple[str, ...] = Field(min_length=7)
    units: tuple[str, ...]
    low: tuple[Finite, ...]
    high: tuple[Finite, ...]
    logarithmic: tuple[bool, ...]


class _Header(BaseModel):
    """What the file must say before its leaves are read."""

    format: Literal["acf-jax corrected surrogate 1"]
    network: Shape
    dtype: Literal["float32", "float64"]
    which: Literal["contact", "sensed"]
    domain: _Domain
    model: dict[str, Any]


def save_corrected(
    path: Path, surrogate: CorrectedSurrogate, shape: Shape, model: dict[str, Any], more: dict[str, Any]
) -> None:
    """Write model.eqx; `model` is the diagnosis' model.json, `more` goes into the header beside it."""
    d = surrogate.domain
    header = {
        "format": FORMAT,
        "network": shape.model_dump(),
        "dtype": str(surrogate.x.scale.dtype),
        "which": surrogate.which,
        "domain": _Domain(
            names=d.names, units=d.units, low=d.low, high=d.high, logarithmic=d.logarithmic
        ).model_dump(mode="json"),
        "model": model,
    }
    write_tree(path, {**header, **more}, surrogate)


def is_corrected(path: Path) -> bool:
    """Whether a model.eqx stands for a corrected model; `InputError` when it is no model.eqx."""
    return read_header(path)[0].get("format") == FORMAT


def load_corrected(path: Path) -> tuple[CorrectedSurrogate, dict[str, Any]]:
    """The surrogate in a `model.eqx` that train.fit wrote with `labels`, and the model.json that it stands for.

    **Raises:** `InputError` when the file is missing, damaged, or of the paper's model.
    """
    header, body = read_header(path)
    if header.get("format") != FORMAT:
        raise InputError(f"{path}: stands for no corrected model; train one with `labels: {{model: ...}}`")
    checked = check_header(path, header, _Header)
    named = checked.domain
    sizes = {len(column) for column in (*named.model_dump().values(), set(named.names))}
    if len(sizes) > 1 or named.names[:4] != FIRST or named.names[-3:] != LAST:
        raise InputError(f"{path}: header: domain: its columns do not fit each other; train it again")
    domain = Domain(**named.model_dump())
    check_ranges(path, dict(zip(named.names, zip(named.low, named.high, strict=True), strict=True)))
    if any(is_log and low <= 0 for is_log, low in zip(named.logarithmic, named.low, strict=True)):
        raise InputError(f"{path}: header: domain: a logarithmic range begins at 0 or below; train it again")
    dtype = np.dtype(checked.dtype)
    inputs, outputs = len(domain.free) + len(FEATURES), len(OUTPUTS)

    def blank(*shape: int) -> Any:
        return np.zeros(shape, dtype)

    like = CorrectedSurrogate(
        blank_network(inputs, checked.network, dtype, outputs),
        x=Affine(blank(inputs), blank(inputs)),
        y=Affine(blank(outputs), blank(outputs)),
        bounds=Bounds(blank(), blank(), blank()),
        domain=domain,
        which=checked.which,
        header=json.dumps(header),
    )
    surrogate = fill(path, body, like)
    check_scales(path, surrogate.x, surrogate.y)
    if min(jax.tree.leaves(surrogate.bounds)) < 0:
        raise InputError(f"{path}: a bound of its error is negative; train it again")
    return surrogate, checked.model
