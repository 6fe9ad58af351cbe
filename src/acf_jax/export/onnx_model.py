"""A surrogate as an ONNX model: each step one node on a batch, in double precision."""

import json
from collections import Counter
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
        self.sums = _sums(program)
        within = {affine.output for affine, _ in self.sums.values()}
        self.cuts: dict[Value, set[int]] = {}  # where each vector that is sliced is cut
        for step in program.steps:
            if step.op == "slice" and isinstance(x := step.inputs[0], Value):
                self.cuts.setdefault(x, {0, x.size}).update(step.more)
        self.pieces: dict[Value, dict[int, str]] = {}  # of each vector that is sliced, by where they start
        for step in program.steps:
            if step.output not in within:
                self.write(step)

    def write(self, step: Step) -> None:
        """The nodes of one step."""
        inputs, output = list(step.inputs), [self.name(step.output)]
        match step.op:
            case "slice":
                self.slice(step)
            case "add" if step.output in self.sums:
                affine, other = self.sums[step.output]
                self.node("Gemm", [affine.inputs[1], affine.inputs[0], other], output, transB=1)
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
        """A vector is split once, at both ends of all its slices; longer slices are put together of its pieces."""
        source, (start, stop) = step.inputs[0], step.more
        assert isinstance(source, Value)
        if source not in self.pieces:
            cuts = sorted(self.cuts[source])
            self.pieces[source] = {cut: f"{self.name(source)}_{cut}" for cut in cuts[:-1]}
            self.node("Split", [source, np.diff(cuts)], list(self.pieces[source].values()), axis=1)
        pieces = [name for cut, name in self.pieces[source].items() if start <= cut < stop]
        if len(pieces) == 1 and step.output not in self.outputs:
            self.names[step.output] = pieces[0]
        else:
            self.node("Concat", pieces, [self.name(step.output)], axis=1)


def _sums(program: Program) -> dict[Value, tuple[Step, Value]]:
    """Additions of W x to a vector, which are one node: the step that makes W x, and the vector, by the sum."""
    made = {step.output: step for step in program.steps}
    uses = Counter(x for step in program.steps for x in step.inputs if isinstance(x, Value))
    uses.update(program.outputs)
    found: dict[Value, tuple[Step, Value]] = {}
    for step in program.steps:
        match step.op, step.inputs:
            case "add", (Value() as a, Value() as b) if a.size == b.size:
                for x, other in ((a, b), (b, a)):
                    before = made.get(x)
                    if before and before.op == "affine" and not np.any(before.inputs[2]) and uses[x] == 1:
                        found[step.output] = before, other
    return found
