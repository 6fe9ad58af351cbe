"""The ONNX model against the surrogate that it was made of, in ONNX Runtime."""

import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from click.testing import CliRunner

from acf_jax.cli.main import commands
from acf_jax.errors import InputError
from acf_jax.export.formula import Formula, of_corrected, of_paper
from acf_jax.export.trace import trace
from acf_jax.model import Impact, Rig
from acf_jax.surrogate import Surrogate, load_surrogate
from acf_jax.surrogate.box import UNITS, Box
from tests.export.networks import untrained, untrained_corrected
from tests.needs import need_module

SAMPLES = 2**13


@pytest.fixture(scope="module", autouse=True)
def runtime():
    need_module("onnx", "pip install 'acf-jax[export]'")
    return need_module("onnxruntime", "pip install 'acf-jax[export]'")


def answers_of(surrogate: Surrogate, x: np.ndarray) -> tuple[np.ndarray, ...]:
    """Force, bound and whether inside, by the surrogate's own methods."""
    found = jax.jit(jax.vmap(lambda x: surrogate.predict(Rig(*x[:4]), Impact(*x[4:]))))(x)
    return np.asarray(found.f_max), np.asarray(found.error_bound), np.asarray(found.is_inside)


def agree(session, surrogate: Surrogate, x: np.ndarray, least: float = 0.2) -> None:
    force, bound, inside = answers_of(surrogate, x)
    *found, is_inside = (y[:, 0] for y in session.run(None, {"x": x}))
    assert np.array_equal(is_inside, inside) and least < inside.mean() < 0.9
    for y, expected in zip(found, (force, bound), strict=True):
        assert y[inside] == pytest.approx(expected[inside], rel=1e-6)
        assert np.isposinf(y[~inside]).all()


def test_exported_file_agrees_with_the_surrogate_and_says_what_it_is(runtime, tmp_path, monkeypatch):
    monkeypatch.setattr("acf_jax.start.start_jax", lambda: None)  # tests set JAX themselves
    path = tmp_path / "peak.onnx"
    result = CliRunner().invoke(commands, ["export", "--surrogate", "shipped", "--onnx", str(path)])
    assert result.exit_code == 0, result.output
    assert "relative from JAX" in result.output
    surrogate, session = load_surrogate(), runtime.InferenceSession(path)
    x = of_paper(surrogate).draw(np.random.default_rng(17), SAMPLES)
    agree(session, surrogate, x)
    x[0, 4] = np.nan
    assert not session.run(["is_inside"], {"x": x[:1]})[0].item()

    told = session.get_modelmeta().custom_metadata_map
    assert [(q["name"], q["unit"]) for q in json.loads(told["inputs"])][::4] == [("m", "kg"), ("v_e", "m/s")]
    assert {r["name"]: (r["low"], r["high"]) for r in json.loads(told["ranges"])}["v_e"] == (0.01, 1.0)
    assert "held-out" in told["error_bound"] and json.loads(told["surrogate"])["features"] == "fold"


def test_the_page_prints_what_it_says(runtime, tmp_path, monkeypatch, capsys):
    """All arrays at once, and one impact at a time in arrays that are bound."""
    from acf_jax.export.onnx_model import onnx_model

    (tmp_path / "peak.onnx").write_bytes(onnx_model(of_paper(load_surrogate())).SerializeToString())
    page = (Path(__file__).resolve().parents[2] / "docs/export.md").read_text("utf-8")
    monkeypatch.chdir(tmp_path)
    exec("\n".join(re.findall("```python\n(.*?)```", page, re.DOTALL)), {})
    printed = capsys.readouterr().out
    *rows, last = printed.splitlines()
    assert "\n".join(rows) in page and f"# {float(last):.4f}" in page


@pytest.mark.parametrize(
    "features, activation",
    [
        ("raw", "silu"),
        ("dimensionless", "gelu"),
        ("dimensionless", "softsign"),
        pytest.param("dimensionless", "softplus", marks=pytest.mark.long),
    ],
)
def test_every_kind_of_network_can_be_exported(runtime, features, activation):
    from acf_jax.export.onnx_model import onnx_model

    surrogate = untrained(features, activation)
    answers = of_paper(surrogate)
    session = runtime.InferenceSession(onnx_model(answers).SerializeToString())
    agree(session, surrogate, answers.draw(np.random.default_rng(5), 512))


RANGES = {
    "underdamped": {"zeta": (0.0, 0.8)},
    "overdamped at most": {"zeta": (0.3, 2.5), "k_f": (0.0, 5.0)},
    "too wide for polynomials": {"zeta": (0.0, 300.0), "k_f": (0.0, 0.0)},
    "one actuator": {"k_f": (900.0, 900.0), "f_p": (0.0, 0.0)},
}


QUICKLY = ("too wide for polynomials", "one actuator")  # one of either form of the fold


@pytest.mark.parametrize(
    "name", [name if name in QUICKLY else pytest.param(name, marks=pytest.mark.long) for name in RANGES]
)
def test_every_range_of_the_papers_model_is_exported_right(runtime, name):
    from acf_jax.export.onnx_model import onnx_model

    ranges = RANGES[name]
    surrogate = load_surrogate()
    box = surrogate.box
    low, high = (
        tuple(ranges.get(name, (box.low[i], box.high[i]))[end] for i, name in enumerate(UNITS))
        for end in (0, 1)
    )
    answers = of_paper(replace(surrogate, box=Box(low, high)))
    assert (answers.brief is answers.function) == (high[1] > 100)
    session = runtime.InferenceSession(onnx_model(answers).SerializeToString())
    x = answers.draw(np.random.default_rng(3), SAMPLES)
    agree(session, replace(surrogate, box=Box(low, high)), x, least=1e-3)  # overdamped few have a peak


def test_the_shipped_surrogate_takes_few_operations(runtime):
    """Each costs a runtime as much as a hundred additions, and sums of products none of their own."""
    from acf_jax.export.onnx_model import onnx_model

    assert len(onnx_model(of_paper(load_surrogate())).graph.node) <= 43


@pytest.mark.parametrize("free", [("v_e", "f_p"), ("m", "k_c", "gravity.force_n", "v_e", "f_p", "mobility")])
def test_surrogates_of_corrected_models_are_exported_alike(runtime, free):
    from acf_jax.export.onnx_model import onnx_model

    surrogate = untrained_corrected(free)
    answers, domain = of_corrected(surrogate), surrogate.domain
    assert tuple(q.name for q in answers.inputs) == free
    session = runtime.InferenceSession(onnx_model(answers).SerializeToString())
    x = answers.draw(np.random.default_rng(5), 512)
    q = np.tile(domain.low, (512, 1))
    q[:, domain.free] = x
    expected = jax.jit(jax.vmap(surrogate.predict))(q)
    inside = np.asarray(expected.is_inside)
    force, time, bound, is_inside = (y[:, 0] for y in session.run(None, {"x": x}))
    assert np.array_equal(is_inside, inside) and 0.1 < inside.mean() < 0.9
    for y, wanted in ((force, expected.force), (time, expected.time), (bound, expected.error_bound)):
        assert (
            y[inside] == pytest.approx(np.asarray(wanted)[inside], rel=1e-6) and np.isposinf(y[~inside]).all()
        )


def test_a_model_that_differs_is_refused():
    from acf_jax.export.onnx_check import check_onnx
    from acf_jax.export.onnx_model import onnx_model

    model = onnx_model(of_paper(untrained("raw")))
    with pytest.raises(InputError, match="differs from JAX"):
        check_onnx(model.SerializeToString(), of_paper(untrained("raw", "silu")))


def test_joined_steps_compute_what_the_function_does(runtime):
    """Slices of slices, affine maps in a row, scalars beside vectors, reductions: by ONNX Runtime and by JAX."""
    from acf_jax.export.onnx_model import onnx_model

    matrix = jnp.array([[1.0, -2.0, 0.5], [0.3, 4.0, -1.0]])

    def function(x):
        part = x[1:][1:4]
        y = (matrix @ ((part - jnp.array([0.1, 0.2, 0.3])) / 7.0) * 2.0 - 1.0) / jnp.array([3.0, 5.0])
        y = jnp.where(x[0] > 0, y, 2.0 * x[0]) + x[0]
        z = jnp.concatenate([y, x[:2] ** 3, jnp.ones(1)])
        z = jnp.stack([z[4], z[0] + z[4]]) + z[2:4]
        inside = (z < 50).all() & ~(x[0] > 2) | (x[4] != x[4])
        return z.max() - z.min(), z.sum() + jax.nn.softplus(x[4]), inside

    told = of_paper(untrained("raw"))
    told = told._replace(inputs=told.inputs[:5], function=function, brief=function)
    assert isinstance(told, Formula)
    operations = [step.op for step in trace(function, 5).steps]
    assert "div" not in operations
    session = runtime.InferenceSession(onnx_model(told).SerializeToString())
    x = np.random.default_rng(1).normal(0, 2, (256, 5))
    for found, expected in zip(session.run(None, {"x": x}), jax.vmap(function)(x), strict=True):
        assert found[:, 0] == pytest.approx(np.asarray(expected), rel=1e-13)


def test_parts_of_a_vector_are_taken_out_one_by_one():
    """By slices, or by JAX 0.12's own primitive."""
    whole = trace(lambda x: tuple(jnp.unstack(x * 2.0)), 3)
    assert len(whole.outputs) == 3 and {out.size for out in whole.outputs} == {1}
    joined = trace(lambda x: tuple(jnp.unstack(jnp.stack([x[0], x[2]]))), 3)
    assert [step.op for step in joined.steps if step.op != "concatenate"] == ["slice", "slice"]


@pytest.mark.parametrize(
    "function, what",
    [
        (lambda x: [jax.lax.fori_loop(0, 3, lambda i, y: y * x[0], x[1])], "without loops"),
        (lambda x: [x @ x], "write it as a sum"),
        (lambda x: [jnp.outer(x, x).sum()], "only vectors"),
        (lambda x: [x[0].astype(int) + 1.0], "double precision"),
    ],
)
def test_what_cannot_be_exported_is_named(function, what):
    with pytest.raises(NotImplementedError, match=what):
        trace(function, 3)


def test_a_missing_package_names_the_extra(monkeypatch, tmp_path):
    monkeypatch.setattr("acf_jax.start.start_jax", lambda: None)
    for name in ("acf_jax.export.onnx_check", "acf_jax.export.onnx_model"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(InputError, match=r"onnxruntime; run `pip install 'acf-jax\[export\]'`"):
        arguments = ["export", "--surrogate", "shipped", "--onnx", str(tmp_path / "x.onnx")]
        CliRunner().invoke(commands, arguments, catch_exceptions=False)
    assert not list(tmp_path.iterdir())


def test_export_lists_all_faults_at_once(tmp_path):
    (tmp_path / "folder.h").mkdir()
    arguments = ["--onnx", "peak.txt", "--c", str(tmp_path / "folder.h"), "--surrogate", "no.eqx"]
    with pytest.raises(InputError) as caught:
        CliRunner().invoke(commands, ["export", *arguments], catch_exceptions=False)
    found = "\n".join(caught.value.faults)
    for part in ("must end in .onnx", "is a folder", "no.eqx: no such file"):
        assert part in found
    with pytest.raises(InputError, match="--onnx writes a surrogate"):
        CliRunner().invoke(commands, ["export", "--onnx", "peak.onnx"], catch_exceptions=False)
    with pytest.raises(InputError, match="names the function"):
        CliRunner().invoke(
            commands, ["export", "--surrogate", "shipped", "--c", "1-a.h"], catch_exceptions=False
        )
