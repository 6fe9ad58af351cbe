"""An ONNX model against the JAX function that it was made of."""

from typing import NamedTuple

import jax
import numpy as np
import onnxruntime

from acf_jax.errors import InputError
from acf_jax.export.formula import Formula

SAMPLES = 4096
TOLERANCE = 1e-6  # relative


class Agreement(NamedTuple):
    """How far ONNX Runtime and JAX are apart."""

    largest: float  # relative difference of any output, inside the range
    inside: int  # samples
    outside: int  # samples, all of them flagged


def check_onnx(model: bytes, formula: Formula, seed: int = 0) -> Agreement:
    """Ask both about samples over the range, dense at its faces, and a little beyond.

    **Raises:** `InputError` where they differ by more than 1e-6, or disagree on which samples are in the range.
    """
    x = formula.draw(np.random.default_rng(seed), SAMPLES)
    *here, inside = (np.asarray(column) for column in jax.jit(jax.vmap(formula.function))(x))
    session = onnxruntime.InferenceSession(model, providers=["CPUExecutionProvider"])
    *there, is_inside = (column[:, 0] for column in session.run(None, {"x": x}))
    flags_differ = int((inside != is_inside).sum()) + sum(int(np.isfinite(y[~inside]).sum()) for y in there)
    apart = [np.abs(b[inside] - a[inside]) / np.abs(a[inside]) for a, b in zip(here, there, strict=True)]
    largest = float(np.max(apart, initial=0.0))
    if flags_differ or not largest <= TOLERANCE:
        raise InputError(
            f"ONNX Runtime differs from JAX by up to {largest:.1e} relative, and on the range of {flags_differ} of"
            f" {SAMPLES} samples; nothing is written: try another version of onnxruntime"
        )
    return Agreement(largest, int(inside.sum()), int((~inside).sum()))
