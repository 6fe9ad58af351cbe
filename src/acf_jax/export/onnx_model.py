"""A surrogate as an ONNX model: each step one node on a batch, in double precision."""

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from acf_jax.export.formula import Formula
from acf_jax.export.step import Operand, Program, Step, Value
from acf_jax.export.trace import trace

NODES = {
    "abs": "Abs", "add": "Add", "and": "And", "atan": "Atan", "concatenate": "Concat", "cos": "Cos", "div": "Div",
    "eq": "Equal", "exp": "Exp", "ge": "GreaterOrEqual", "gt": "Greater", "le": "LessOrEqual", "log": "Log",
    "logistic": "Sigmoid", "lt": "Less", "max": "Max", "min": "Min", "mul": "Mul", "neg": "Neg",
    "not": "Not", "or": "Or", "pow": "Pow", "reduce_max": "ReduceMax", "reduce_min": "ReduceMin",
    "reduce_sum": "ReduceSum", "select_n": "Where", "sin": "Sin", "sqrt": "Sqrt", "sub": "Sub", "tanh": "Tanh",
}  # fmt: skip
OPSET, IR = 18, 8  # of 2022, so that runtimes of the last years read the file
INPUT, INSIDE = "x", "is_inside"


def onnx_model(formula: Formula) -> onnx.ModelProto:
    """Inputs as the columns of `x`, (N, inputs); each output, and `is_inside`, of shape (N, 1).

    The model's metadata name inputs, outputs, units, ranges and what the error bound rests on, as JSON.

    **Raises:** `NotImplementedError` naming an operation that has no counterpart in ONNX.
    """
    names = [*(q.name for q in formula.outputs), INSIDE]
    kinds = [TensorProto.DOUBLE] * len(formula.outputs) + [TensorProto.BOOL]
    graph = _Graph(trace(formula.brief, len(formula.inputs)), names)
    model = helper.make_model(
        helper.make_graph(
            graph.nodes,
            "peak_force",
            [helper.make_tensor_value_info(INPUT, TensorProto.DOUBLE, ["N", len(formula.inputs)])],
            [helper.make_tensor_value_info(n, kind, ["N", 1]) for n, kind in zip(names, kinds, strict=True)],
            list(graph.constants.values()),
        ),
        opset_imports=[helper.make_opsetid("", OPSET)],
        ir_version=IR,
        producer_name="acf-jax",
    )
    told = {
        "inputs": [q._asdict() for q in formula.inputs],
        "outputs": [q._asdict() for q in formula.outputs],
        "ranges": [r._asdict() for r in formula.ranges],
    }
    helper.set_model_props(
        model,
        {key: json.dumps(value) for key, value in told.items()}
        | {"condition": formula.condition, "outside": "every output is infinite where is_inside is false"}
        | {"error_bound": formula.error, "surrogate": formula.header},
    )
    onnx.checker.check_model(model, full_check=True)
    return model


class _Graph:
    """Nodes and constants of a program; every value is a batch of vectors, (N, size)."""

    def __init__(self, program: Program, outputs: Sequence[str]):
        self.nodes: list[onnx.NodeProto] = []
        self.constants: dict[Any, onnx.TensorProto] = {}
        self.names = {program.x: INPUT} | dict(zip(program.outputs, outputs, strict=True))
        self.outputs = program.outputs
        self.entries: dict[str, list[str]] = {}  # of each vector that is sliced
        for step in program.steps:
            self.write(step)

    def write(self, step: Step) -> None:
        """The nodes of one step."""
        inputs, output = list(step.inputs), [self.name(step.output)]
        match step.op:
            case "slice":
                self.slice(step)
            case "concatenate":
                self.node("Concat", inputs, output, axis=1)
            case "select_n":
                flag, otherwise, then = inputs
                self.node("Where", [flag, then, otherwise], output)
            case "affine":
                matrix, x, offset = inputs
                self.node("Gemm", [x, matrix, offset], output, transB=1)
            case "log1p":
                self.node("Add", [*inputs, np.array(1.0)], [f"{output[0]}_1"])
                self.node("Log", [f"{output[0]}_1"], output)
            case "ne":
                self.node("Equal", inputs, [f"{output[0]}_1"])
                self.node("Not", [f"{output[0]}_1"], output)
            case "integer_pow":
                self.node("Pow", [*inputs, np.array(float(step.more[0]))], output)
            case "convert_element_type":
                self.node("Cast", inputs, output, to=TensorProto.DOUBLE)
            case "reduce_and":  # no reduction takes flags
                self.node("Cast", inputs, [f"{output[0]}_1"], to=TensorProto.INT32)
                self.node("ReduceMin", [f"{output[0]}_1", np.array([1])], [f"{output[0]}_2"])
                self.node("Cast", [f"{output[0]}_2"], output, to=TensorProto.BOOL)
            case "reduce_max" | "reduce_min" | "reduce_sum":
                self.node(NODES[step.op], [*inputs, np.array([1])], output)
            case op if op in NODES:
                self.node(NODES[op], inputs, output)
            case op:
                raise NotImplementedError(f"'{op}' has no counterpart in ONNX here; add it to NODES")

    def node(self, op: str, inputs: Sequence[Operand | str], outputs: list[str], **attributes: Any) -> None:
        names = [x if isinstance(x, str) else self.name(x) for x in inputs]
        self.nodes.append(helper.make_node(op, names, outputs, **attributes))

    def name(self, x: Operand) -> str:
        if isinstance(x, Value):
            return str(self.names.setdefault(x, f"v{x.number}"))
        key = x.shape, x.dtype.str, x.tobytes()
        if key not in self.constants:
            self.constants[key] = numpy_helper.from_array(np.ascontiguousarray(x), f"c{len(self.constants)}")
        return self.constants[key].name

    def slice(self, step: Step) -> None:
        """A vector is split into its entries once; slices are put together of them."""
        source, size = self.name(step.inputs[0]), step.inputs[0].size
        if source not in self.entries:
            self.entries[source] = [f"{source}_{i}" for i in range(size)]
            self.node("Split", [source, np.ones(size, int)], self.entries[source], axis=1)
        entries = self.entries[source][slice(*step.more)]
        if len(entries) == 1 and step.output not in self.outputs:
            self.names[step.output] = entries[0]
        else:
            self.node("Concat", entries, [self.name(step.output)], axis=1)
