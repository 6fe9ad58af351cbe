"""How long one answer takes: exact peak, surrogate, and the whole check, in Python, ONNX Runtime and C.

python -m benchmarks.check_latency
"""

import argparse
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

import jax
import numpy as np
import onnx
import onnxruntime
from onnx import helper, numpy_helper

from acf_jax.contact.ending import OPEN, Ending
from acf_jax.contact.read import of_rig
from acf_jax.export import peak_header
from acf_jax.export.c_header import c_header
from acf_jax.export.formula import Formula, of_corrected, of_paper
from acf_jax.export.onnx_model import onnx_model
from acf_jax.model import Impact, Rig, find_peak
from acf_jax.safety.check import Checker
from acf_jax.safety.limits import read_limits
from acf_jax.safety.situation import Situation
from acf_jax.start import start_jax
from acf_jax.surrogate import load_surrogate
from acf_jax.surrogate.corrected_file import load_corrected
from benchmarks.machine import describe

CALLS = 5000
RIG = {"m": 1.9, "d": 60.0, "k_f": 800.0, "k_c": 6e4}
STD = {"m": 0.02, "d": 0.2, "k_f": 0.3, "k_c": 0.05, "v_e": 0.005, "f_p": 0.01}
F_P = 60.0
EXAMPLE = Path(__file__).resolve().parents[1] / "examples/rig_surrogate.eqx"

PORTABLE, OWN = ("-O2",), ("-O3", "-march=native", "-fno-math-errno")  # what C is compiled with

Asked = tuple[Formula, list[float | None]]  # what to compute, and where; None stands for the velocity

PROGRAM = r"""
#include <stdio.h>
#include <time.h>
#include "acf_peak.h"
#include "surrogate.h"
#include "corrected.h"
static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e6 * (double)t.tv_sec + 1e-3 * (double)t.tv_nsec;
}
int main(void)
{
    double v, sum = 0;
    while (fread(&v, sizeof v, 1, stdin) == 1) {
        double y[4] = {now(), 0, 0, 0};
        sum += acf_find_peak(ARGUMENTS).f_max;
        y[1] = now();
        sum += surrogate(ARGUMENTS).f_max;
        y[2] = now();
        sum += corrected(CORRECTED).f_max;
        y[3] = now();
        fwrite(y, sizeof y, 1, stdout);
    }
    return sum > 0 ? 0 : 1;
}
"""


def microseconds(call: Callable[[float], object], speeds: Sequence[float]) -> list[float]:
    """Each call at a velocity of its own, after those that compile and warm up."""
    for v in speeds[:100]:
        call(v)
    spent = []
    for v in speeds:
        start = time.perf_counter_ns()
        call(v)
        spent.append((time.perf_counter_ns() - start) / 1e3)
    return spent


def in_c(
    compiler: str, options: Sequence[str], speeds: Sequence[float], folder: Path
) -> dict[str, list[float]]:
    """Exact peak and both surrogates, each call timed in C, the clock's own time included."""
    (folder / "acf_peak.h").write_text(peak_header())
    calls = {"ARGUMENTS": of_shipped(), "CORRECTED": of_example()}
    program = PROGRAM
    for name, (argument, (formula, at)) in zip(("surrogate", "corrected"), calls.items(), strict=True):
        (folder / f"{name}.h").write_text(c_header(formula, name, name))
        program = program.replace(argument, ", ".join("v" if x is None else repr(x) for x in at))
    (folder / "main.c").write_text(program)
    command = [compiler, "-std=c99", "-D_POSIX_C_SOURCE=199309L", *options, "-o", "main", "main.c", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    done = subprocess.run(
        [folder / "main"], input=np.array(speeds).tobytes(), capture_output=True, check=True
    )
    spent = np.diff(np.frombuffer(done.stdout).reshape(-1, 4), axis=1).T.tolist()
    return dict(zip(("exact peak", "surrogate", "surrogate of a corrected model"), spent, strict=True))


def of_shipped() -> Asked:
    """The shipped surrogate of the paper's model, at one rig."""
    return of_paper(load_surrogate()), [*RIG.values(), None, F_P]


def of_example() -> Asked:
    """The surrogate of the example's corrected model, in the middle of its box."""
    surrogate, _ = load_corrected(EXAMPLE)
    formula, domain = of_corrected(surrogate), surrogate.domain
    middle = domain.at(np.full((1, len(domain.free)), 0.5))[0, domain.free].tolist()
    return formula, [None if q.name == "v_e" else x for q, x in zip(formula.inputs, middle, strict=True)]


def bare_network(inputs: int, width: int = 32, outputs: int = 3) -> onnx.ModelProto:
    """Two hidden layers and nothing around them: the least that a surrogate can cost ONNX Runtime."""
    sizes = (inputs, width, width, outputs)
    weights = [np.full((a, b), 0.1) for a, b in pairwise(sizes)]
    stored = [numpy_helper.from_array(w, f"w{i}") for i, w in enumerate(weights)]
    nodes = []
    for i in range(len(weights)):
        nodes.append(helper.make_node("MatMul", [f"x{i}" if i else "x", f"w{i}"], [f"y{i}"]))
        nodes.append(helper.make_node("Tanh", [f"y{i}"], [f"x{i + 1}"]))
    del nodes[-1]
    ends = [
        helper.make_tensor_value_info(name, onnx.TensorProto.DOUBLE, [1, n])
        for name, n in (("x", inputs), (f"y{len(weights) - 1}", outputs))
    ]
    graph = helper.make_graph(nodes, "bare", ends[:1], ends[1:], stored)
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)


def in_onnx_runtime(
    model: onnx.ModelProto, at: list[float | None], speeds: Sequence[float], bound: bool = False
) -> list[float]:
    """A model, one sample a call, on one thread; `bound`: in arrays that are bound once, as docs/export.md shows."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    session = onnxruntime.InferenceSession(
        model.SerializeToString(), options, providers=["CPUExecutionProvider"]
    )
    x = np.array([[0.0 if value is None else value for value in at]])
    column = at.index(None)
    binding = session.io_binding()
    binding.bind_ortvalue_input("x", onnxruntime.OrtValue.ortvalue_from_numpy(x))
    for output in session.get_outputs():
        y = np.zeros((1, output.shape[1]), bool if "bool" in output.type else float)
        binding.bind_ortvalue_output(output.name, onnxruntime.OrtValue.ortvalue_from_numpy(y))

    def call(v: float) -> object:
        x[0, column] = v
        return session.run_with_iobinding(binding) if bound else session.run(None, {"x": x})

    return microseconds(call, speeds)


def in_python(speeds: Sequence[float]) -> dict[str, list[float]]:
    """Peak, surrogate and check of the library itself."""
    model, surrogate = of_rig(RIG, STD), load_surrogate()
    quick, exact = Checker(model, surrogate), Checker(model)
    asked = Situation("", read_limits().find("Palm (dominant side)"), "transient", 0.1, F_P, contact_area=2.0)
    stopped = Situation(
        "", read_limits().find("Sternum"), "quasi_static", 0.1, F_P, 2.0, ending=Ending(stop_after=0.05)
    )
    clamped = stopped._replace(ending=OPEN)  # a hand that recoils is lighter than what the surrogate knows
    values = np.array([*RIG.values(), 0.0, F_P])
    peak = jax.jit(lambda z: find_peak(Rig(*z[:4]), Impact(z[4], z[5])).f_max)
    network = jax.jit(lambda z: surrogate.force(Rig(*z[:4]), Impact(z[4], z[5])))
    assert quick.quick is not None
    certified = quick.quick

    def at(v: float) -> np.ndarray:
        z = values.copy()
        z[4] = v
        return z

    calls: dict[str, Callable[[float], object]] = {
        "exact peak": lambda v: float(peak(at(v))),
        "surrogate": lambda v: float(network(at(v))),
        "surrogate, proved bounds, deviation": lambda v: certified(np.array([*at(v), 1e-5, 0.0, *OPEN])),
        "check, the surrogate where it decides": lambda v: quick.judge(clamped._replace(v_e=v)),
        "check, the exact model": lambda v: exact.judge(asked._replace(v_e=v)),
        "check, clamped with a stated stop": lambda v: quick.judge(stopped._replace(v_e=v)),
        "check, the same simulated": lambda v: quick.whole(np.array([*at(v), 4e-5, 0.0, *stopped.ending])),
    }
    return {name: microseconds(call, speeds) for name, call in calls.items()}


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.check_latency", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--calls", type=int, default=CALLS, help=f"calls of each kind (default: {CALLS:,})")
    options = parser.parse_args(arguments)
    start_jax()
    speeds = np.random.default_rng(0).uniform(0.05, 0.5, options.calls).tolist()

    rows = {f"Python: {name}": spent for name, spent in in_python(speeds).items()}
    (paper, at_paper), (corrected, at_corrected) = of_shipped(), of_example()
    models = {
        "surrogate": (onnx_model(paper), at_paper),
        "surrogate of a corrected model": (onnx_model(corrected), at_corrected),
        "a bare network": (bare_network(len(at_corrected)), at_corrected),
    }
    for name, (model, at) in models.items():
        rows[f"ONNX Runtime from Python: {name}"] = in_onnx_runtime(model, at, speeds)
        rows[f"ONNX Runtime from Python: {name}, arrays bound"] = in_onnx_runtime(
            model, at, speeds, bound=True
        )
    compiler = shutil.which("cc")
    if compiler is None:
        print("no C compiler: the rows of C are left out", file=sys.stderr)
    else:
        for flags in (PORTABLE, OWN):
            with tempfile.TemporaryDirectory() as folder:
                for name, spent in in_c(compiler, flags, speeds, Path(folder)).items():
                    rows[f"C, `{' '.join(flags)}`: {name}"] = spent

    print(f"One sample a call, {len(speeds):,} calls of each kind; {describe()}\n")
    print("| | p50, µs | p99, µs |\n|---|--:|--:|")
    for name, spent in rows.items():
        print(f"| {name} | {statistics.median(spent):.1f} | {float(np.quantile(spent, 0.99)):.1f} |")


if __name__ == "__main__":
    main()
