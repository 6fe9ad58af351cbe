"""A surrogate as a C99 header: each step one line, or one loop over a vector."""

import json
import re
import textwrap
from collections.abc import Sequence

import numpy as np

from acf_jax.export.formula import Formula, Range
from acf_jax.export.step import Operand, Step, Value
from acf_jax.export.trace import trace

EXPRESSIONS = {
    "abs": "fabs({})", "add": "{} + {}", "and": "{} && {}", "atan": "atan({})", "convert_element_type": "(double){}",
    "cos": "cos({})", "div": "{} / {}", "eq": "{} == {}", "exp": "exp({})", "ge": "{} >= {}", "gt": "{} > {}",
    "le": "{} <= {}", "log": "log({})", "log1p": "log1p({})", "logistic": "1 / (1 + exp(-{}))", "lt": "{} < {}",
    "max": "{0} > {1} ? {0} : {1}", "min": "{0} < {1} ? {0} : {1}", "mul": "{} * {}", "ne": "{} != {}", "neg": "-{}",
    "not": "!{}", "or": "{} || {}", "pow": "pow({}, {})", "select_n": "{0} ? {2} : {1}", "sin": "sin({})",
    "sqrt": "sqrt({})", "sub": "{} - {}",
}  # fmt: skip
REDUCTIONS = {
    "reduce_and": "{0} && {1}", "reduce_or": "{0} || {1}", "reduce_sum": "{0} + {1}",
    "reduce_max": "{0} > {1} ? {0} : {1}", "reduce_min": "{0} < {1} ? {0} : {1}",
}  # fmt: skip

# No branch and no call, so that compilers make vector instructions of the loop around it.
TANH = """
/* tanh to 4e-15: e^{-2|x|} is the 64th power of a short series */
static double %s_tanh_(double x)
{
    const double a = fabs(x), z = (20 < a ? 20 : a) / 32;
    double e = 1.0 / 40320;
    e = e * z - 1.0 / 5040;
    e = e * z + 1.0 / 720;
    e = e * z - 1.0 / 120;
    e = e * z + 1.0 / 24;
    e = e * z - 1.0 / 6;
    e = e * z + 0.5;
    e = e * z - 1;
    e = e * z + 1;
    e *= e;
    e *= e;
    e *= e;
    e *= e;
    e *= e;
    e *= e;
    return copysign((1 - e) / (1 + e), x);
}
"""


def c_header(formula: Formula, name: str, origin: str) -> str:
    """A header whose one function, `name`, answers for one sample; it needs math.h and nothing else.

    **Arguments:** `name`: an identifier of C. `origin`: where the surrogate comes from, for the header's comment.

    **Raises:** `NotImplementedError` naming an operation that has no counterpart in C.
    """
    program = trace(formula.function, len(formula.inputs))
    body = _Body(name)
    uses_tanh = any(step.op == "tanh" for step in program.steps)
    for step in program.steps:
        body.write(step)
    arguments = [identifier(q.name) for q in formula.inputs]
    fields = [f"    double {identifier(q.name)}; /* {q.unit}, {q.meaning} */" for q in formula.outputs]
    values = ", ".join(body.name(v) for v in program.outputs)
    parts = [
        _comment(formula, name, arguments, origin),
        f"#ifndef {name.upper()}_H\n#define {name.upper()}_H\n\n#include <math.h>\n",
        "typedef struct {",
        *fields,
        "    int is_inside; /* 0: outside the range, and the rest is infinite */",
        f"}} {name}_result;",
        TANH % (name) if uses_tanh else "",
        *(text for _, text in body.tables.values()),
        f"static {name}_result {name}({', '.join(f'double {a}' for a in arguments)})",
        "{",
        f"    const double v0[{len(arguments)}] = {{{', '.join(arguments)}}};",
        *body.lines,
        f"    const {name}_result result = {{{values}}};",
        "    return result;",
        "}",
        "\n#endif\n",
    ]
    return "\n".join(parts)


class _Body:
    """Tables and statements of a program; `v` are values, `t` tables of constants."""

    def __init__(self, function: str):
        self.function = function
        self.lines: list[str] = []
        self.tables: dict[tuple[tuple[int, ...], bytes], tuple[str, str]] = {}  # name and declaration

    def write(self, step: Step) -> None:
        """The lines of one step."""
        out, size = self.name(step.output), step.output.size
        kind = "int" if step.output.is_flag else "double"
        entries = [
            self.entry(x, "i") for x in step.inputs if step.op not in ("affine", "concatenate", "slice")
        ]
        match step.op:
            case "affine":
                self.affine(step)
            case "slice":
                self.assign(
                    kind,
                    out,
                    size,
                    self.entry(step.inputs[0], f"{step.more[0]} + i" if size > 1 else f"{step.more[0]}"),
                )
            case "concatenate":
                parts = [self.entry(x, f"{j}") for x in step.inputs for j in range(x.size)]
                self.lines.append(f"    const {kind} {out}[{size}] = {{{', '.join(parts)}}};")
            case "tanh":
                self.assign(kind, out, size, f"{self.function}_tanh_({entries[0]})")
            case "integer_pow":
                self.assign(kind, out, size, f"pow({entries[0]}, {step.more[0]})")
            case op if op in REDUCTIONS:
                (x,) = step.inputs
                self.lines.append(f"    {kind} {out} = {self.entry(x, '0')};")
                self.loop(1, x.size, f"{out} = {REDUCTIONS[op].format(out, entries[0])}")
            case op if op in EXPRESSIONS:
                self.assign(kind, out, size, EXPRESSIONS[op].format(*entries))
            case op:
                raise NotImplementedError(f"'{op}' has no counterpart in C here; add it to EXPRESSIONS")

    def affine(self, step: Step) -> None:
        """W x + b column by column: sums of vectors, which compilers turn into vector instructions."""
        matrix, x, offset = step.inputs
        out, size = self.name(step.output), step.output.size
        assert isinstance(matrix, np.ndarray)
        if size > 1:
            self.lines.append(f"    double {out}[{size}];")
            self.loop(0, size, f"{out}[i] = {self.entry(offset, 'i')}")
            columns = self.name(np.ascontiguousarray(matrix.T))
            at_once = 4 if x.size % 4 == 0 else 1  # fewer passes over the sums
            places = [f"j + {n}" if n else "j" for n in range(at_once)]
            terms = " + ".join(f"{columns}[{at}][i] * {self.entry(x, at)}" for at in places)
            self.lines.append(f"    for (int j = 0; j < {x.size}; j += {at_once})")
            self.loop(0, size, f"{out}[i] += {terms}", "        ")
        else:
            self.lines.append(f"    double {out} = {self.entry(offset, '0')};")
            self.loop(0, x.size, f"{out} += {self.entry(matrix.ravel(), 'i')} * {self.entry(x, 'i')}")

    def assign(self, kind: str, out: str, size: int, expression: str) -> None:
        if size > 1:
            self.lines.append(f"    {kind} {out}[{size}];")
            self.loop(0, size, f"{out}[i] = {expression}")
        else:
            self.lines.append(f"    const {kind} {out} = {expression};")

    def loop(self, start: int, stop: int, statement: str, indent: str = "    ") -> None:
        self.lines += [f"{indent}for (int i = {start}; i < {stop}; i++)", f"{indent}    {statement};"]

    def entry(self, x: Operand, index: str) -> str:
        """One entry of a vector; a scalar stands for each of its entries."""
        if x.size > 1:
            return f"{self.name(x)}[{index}]"
        return self.name(x) if isinstance(x, Value) else _literal(x.item())

    def name(self, x: Operand) -> str:
        if isinstance(x, Value):
            return f"v{x.number}"
        key = x.shape, x.tobytes()
        if key not in self.tables:
            name = f"{self.function}_t{len(self.tables)}_"
            shape = "".join(f"[{n}]" for n in x.shape)
            self.tables[key] = name, f"static const double {name}{shape} = {_braces(x)};"
        return self.tables[key][0]


def _literal(x: float | bool) -> str:
    if isinstance(x, bool):
        return f"{x:d}"
    text = "HUGE_VAL" if x == np.inf else repr(float(x))
    return f"({text})" if text.startswith("-") else text


def _braces(x: np.ndarray) -> str:
    if x.ndim > 1:
        return "{\n" + ",\n".join(_braces(row) for row in x) + "}"
    text = ", ".join(repr(float(v)) for v in x)
    return "{" + "\n".join(textwrap.wrap(text, 118)) + "}"


def identifier(name: str) -> str:
    return re.sub(r"\W", "_", name)


def _checksum(formula: Formula) -> list[str]:
    """Which surrogate it is, whatever its file is called."""
    checksum = json.loads(formula.header or "{}").get("sha256")
    return [f"SHA-256 {checksum}."] if checksum else []


def _comment(formula: Formula, name: str, arguments: Sequence[str], origin: str) -> str:
    """What a reader of the header must know."""
    ranges = [f"  {r.name:12} {_span(r)}" for r in formula.ranges]
    inputs = [f"  {a:12} {q.unit}, {q.meaning}" for a, q in zip(arguments, formula.inputs, strict=True)]
    outputs = [f"  {identifier(q.name):12} {q.unit}, {q.meaning}" for q in formula.outputs]
    lines = [
        f"Peak contact force of an active contact flange, by the trained surrogate {origin}.",
        "C99, needs math.h and nothing else; no allocation, no state, no recursion. Generated by",
        "`python -m acf_jax export`.",
        *_checksum(formula),
        "",
        f"  {name}_result r = {name}({', '.join(arguments)});",
        "  if (r.is_inside && r.f_max + r.error_bound <= limit) ...",
        "",
        "Inputs",
        *inputs,
        "Outputs",
        *outputs,
        f"  is_inside    1 within the ranges, where {formula.condition}; otherwise 0, and the rest is infinite",
        "Ranges",
        *ranges,
        f"Error bound: {formula.error}.",
    ]
    wrapped = [
        part for line in lines for part in textwrap.wrap(line, 112, subsequent_indent=" " * 15) or [""]
    ]
    return "\n".join(["/* " + wrapped[0], *(f" * {line}".rstrip() for line in wrapped[1:]), " */"])


def _span(r: Range) -> str:
    unit = "" if r.unit == "1" else f" {r.unit}"
    return f"{r.low:g} to {r.high:g}{unit}" if r.low < r.high else f"{r.low:.17g}{unit}, fixed"
