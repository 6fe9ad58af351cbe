"""A JAX function of one sample as a flat list of steps, for writers of other languages."""

from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import ClosedJaxpr, Jaxpr, JaxprEqn, Literal, Var

from acf_jax.export.join import joined
from acf_jax.export.step import Operand, Operation, Program, Step, Value

# Primitives that rename or repeat a value, which the writers do where two sizes meet.
SAME = {"broadcast_in_dim", "convert_element_type", "copy", "reshape", "squeeze"}
# Those that must see every entry.
WHOLE = {"concatenate", "dot_general", "reduce_and", "reduce_max", "reduce_min", "reduce_or", "reduce_sum", "slice",
         "stack"}  # fmt: skip


def trace(function: Callable[[Any], Sequence[Any]], inputs: int) -> Program:
    """The steps that compute `function`, in double precision.

    Calls are opened, what depends on constants alone is computed, equal steps are joined and so are affine ones in a
    row, and what no output needs is dropped.

    **Arguments:** `function`: a vector of `inputs` numbers to a sequence of scalars.

    **Raises:** `NotImplementedError` naming what cannot be written as steps on vectors.
    """
    closed = jax.make_jaxpr(function)(jax.ShapeDtypeStruct((inputs,), jnp.float64))
    tracer, x = _Tracer(), Value(0, inputs, False)
    outputs = []
    for out in tracer.run(closed.jaxpr, closed.consts, [x]):
        if not isinstance(out, Value):
            raise NotImplementedError("an output does not depend on the sample")
        outputs.append(out)
    return Program(x, _needed(tuple(tracer.made.values()), outputs), tuple(outputs))


class _Tracer:
    """Walks through an expression of JAX and collects its steps."""

    def __init__(self) -> None:
        self.made: dict[Value, Step] = {}
        self.known: dict[Any, Value] = {}
        self.parts: dict[Value, tuple[Operand, ...]] = {}  # of what was put together

    def run(self, jaxpr: Jaxpr, constants: Sequence[Any], arguments: Sequence[Operand]) -> list[Operand]:
        values: dict[Var, Operand] = dict(zip(jaxpr.constvars, map(np.asarray, constants), strict=True))
        values |= dict(zip(jaxpr.invars, arguments, strict=True))

        def read(v: Any) -> Operand:
            return np.asarray(v.val) if isinstance(v, Literal) else values[v]

        for eqn in jaxpr.eqns:
            values |= dict(zip(eqn.outvars, self.outputs(eqn, [read(v) for v in eqn.invars]), strict=True))
        return [read(v) for v in jaxpr.outvars]

    def outputs(self, eqn: JaxprEqn, inputs: list[Operand]) -> list[Operand]:
        """What one equation computes; its steps are added."""
        name = eqn.primitive.name
        if all(isinstance(x, np.ndarray) for x in inputs):
            found = eqn.primitive.bind(*inputs, **eqn.params)
            return [np.asarray(x) for x in (found if eqn.primitive.multiple_results else [found])]
        if name in ("scan", "while", "cond"):
            raise NotImplementedError(f"'{name}': only functions without loops and branches can be exported")
        for body in eqn.params.values():
            if isinstance(body, ClosedJaxpr):
                return self.run(body.jaxpr, body.consts, inputs)
            if isinstance(body, Jaxpr):
                return self.run(body, (), inputs)
        out: Any = eqn.outvars[0].aval
        is_flag = out.dtype == bool
        if out.ndim > 1 or not (is_flag or out.dtype == np.float64):
            raise NotImplementedError(
                f"'{name}' makes {out}: only vectors in double precision can be exported"
            )
        if name in SAME and isinstance(inputs[0], Value) and inputs[0].is_flag == is_flag:
            return [inputs[0]]
        if name == "unstack":  # of JAX 0.12; slices before
            (x,) = inputs
            return [
                self.whole(Operation("slice", (x,), (i, i + 1)), 1, is_flag) for i in range(len(eqn.outvars))
            ]
        if name in WHOLE:
            return [self.whole(_whole(eqn, inputs), out.size, is_flag)]
        more = (eqn.params["y"],) if name == "integer_pow" else ()
        return [self.add(Operation(name, tuple(inputs), more), max(x.size for x in inputs), is_flag)]

    def whole(self, operation: Operation, size: int, is_flag: bool) -> Operand:
        """The output of an operation that sees every entry."""
        match operation:
            case Operation("slice", (Value() as x,), (start, stop)) if x in self.parts:
                ends = np.cumsum([part.size for part in self.parts[x]])
                for part, end in zip(self.parts[x], ends, strict=True):
                    if (start, stop) == (end - part.size, end):
                        return part  # what was put in is taken out again
            case Operation("concatenate", parts):
                return self.put_together(parts, is_flag)
        return self.add(operation, size, is_flag)

    def put_together(self, parts: tuple[Operand, ...], is_flag: bool) -> Value:
        """One vector of several; constants among them are the offset of an affine map."""
        parts = tuple(
            x if isinstance(x, Value) else np.atleast_1d(x) for x in parts
        )  # of rank one, as JAX's are
        values = tuple(x for x in parts if isinstance(x, Value))
        found = values[0]
        if len(values) > 1:
            found = self.add(Operation("concatenate", values), sum(x.size for x in values), is_flag)
        if len(values) < len(parts):
            is_value = np.concatenate([np.full(x.size, isinstance(x, Value)) for x in parts])
            matrix = np.zeros((is_value.size, found.size))
            matrix[is_value] = np.eye(found.size)
            offset = np.concatenate([np.zeros(x.size) if isinstance(x, Value) else x for x in parts])
            found = self.add(Operation("affine", (matrix, found, offset)), offset.size, False)
        self.parts[found] = parts
        return found

    def add(self, operation: Operation, size: int, is_flag: bool) -> Value:
        """The output of this operation, or of the same one before it."""
        op, inputs, more = joined(operation, self.made)
        key = op, more, *(x if isinstance(x, Value) else (x.shape, x.tobytes()) for x in inputs)
        if key not in self.known:
            value = self.known[key] = Value(len(self.known) + 1, size, is_flag)
            self.made[value] = Step(op, inputs, more, value)
        return self.known[key]


def _whole(eqn: JaxprEqn, inputs: list[Operand]) -> Operation:
    """An operation that must see every entry of its vectors."""
    name, parameters = eqn.primitive.name, eqn.params
    avals: list[Any] = [v.aval for v in eqn.invars]
    if any(x.size != aval.size for x, aval in zip(inputs, avals, strict=True)):
        raise NotImplementedError(f"'{name}' of a repeated scalar: write the vector out")
    if name == "slice":
        return Operation(name, tuple(inputs), (*parameters["start_indices"], *parameters["limit_indices"]))
    if name != "dot_general":
        return Operation("concatenate" if name == "stack" else name, tuple(inputs))
    (axes, _), (left, right) = parameters["dimension_numbers"], inputs
    matrix, axis, x = (left, axes[0], right) if isinstance(left, np.ndarray) else (right, axes[1], left)
    if not isinstance(matrix, np.ndarray):
        raise NotImplementedError("'dot_general' of two vectors: write it as a sum")
    rows = np.atleast_2d(np.moveaxis(matrix, axis[0], -1))
    return Operation("affine", (rows, x, np.zeros(len(rows))))


def _needed(steps: Sequence[Step], outputs: Sequence[Value]) -> tuple[Step, ...]:
    wanted, kept = set(outputs), []
    for step in reversed(steps):
        if step.output in wanted:
            kept.append(step)
            wanted |= {x for x in step.inputs if isinstance(x, Value)}
    return tuple(reversed(kept))
