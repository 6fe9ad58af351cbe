"""Operations in a row that are one: slices of slices, and scaling, shifting and matrix products."""

from collections.abc import Mapping

import numpy as np

from acf_jax.export.step import Operation, Step, Value


def joined(operation: Operation, made: Mapping[Value, Step]) -> Operation:
    """The operation on what lies before the steps that it can be joined with.

    W ((x - c)/s) + b = (W/s) x + (b - W c/s),   ((W x + b) - c)/s = (W/s) x + (b - c)/s

    **Arguments:** `made`: every step so far, by its output.
    """
    if operation.op == "slice":
        return _slice(operation, made)
    if operation.op == "affine":
        return _after_affine(operation, made)
    return _before_scaling(operation, made)


def _slice(operation: Operation, made: Mapping[Value, Step]) -> Operation:
    before = _maker(operation.inputs[0], made)
    if before is None or before.op != "slice":
        return operation
    start, stop = (before.more[0] + at for at in operation.more)
    return joined(Operation("slice", before.inputs, (start, stop)), made)


def _after_affine(operation: Operation, made: Mapping[Value, Step]) -> Operation:
    matrix, x, offset = operation.inputs
    before = _maker(x, made)
    assert isinstance(matrix, np.ndarray) and isinstance(offset, np.ndarray)
    if before is not None and before.op == "affine":
        inner, source, shift = before.inputs
        assert isinstance(inner, np.ndarray)
        return joined(Operation("affine", (matrix @ inner, source, offset + matrix @ shift)), made)
    scaling = None if before is None else _scaling(Operation(*before[:3]))
    if scaling is None or scaling[0].size != x.size:
        return operation
    source, factor, shift = scaling
    return joined(
        Operation("affine", (matrix * factor, source, offset + matrix @ np.broadcast_to(shift, x.size))), made
    )


def _before_scaling(operation: Operation, made: Mapping[Value, Step]) -> Operation:
    scaling = _scaling(operation)
    before = None if scaling is None else made.get(scaling[0])
    if scaling is None or before is None or before.op != "affine":
        return operation
    (source, factor, shift), (matrix, x, offset) = scaling, before.inputs
    if max(factor.size, shift.size) > source.size:
        return operation
    assert isinstance(matrix, np.ndarray) and isinstance(offset, np.ndarray)
    return Operation("affine", (factor.reshape(-1, 1) * matrix, x, factor * offset + shift))


def _scaling(operation: Operation) -> tuple[Value, np.ndarray, np.ndarray] | None:
    """Vector, factor and shift of an operation that scales or shifts by a constant."""
    one, zero = np.array(1.0), np.array(0.0)
    match operation.op, operation.inputs:
        case "add", (Value() as x, np.ndarray() as c) | (np.ndarray() as c, Value() as x):
            return x, one, c
        case "mul", (Value() as x, np.ndarray() as c) | (np.ndarray() as c, Value() as x):
            return x, c, zero
        case "sub", (Value() as x, np.ndarray() as c):
            return x, one, -c
        case "div", (Value() as x, np.ndarray() as c):
            return x, 1 / c, zero
    return None


def _maker(x: Value | np.ndarray, made: Mapping[Value, Step]) -> Step | None:
    return made.get(x) if isinstance(x, Value) else None
