"""The C headers against JAX, over their range and in their limits; needs a compiler."""

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from click.testing import CliRunner
from needs import need_program

from acf_jax.cli.main import commands
from acf_jax.errors import InputError
from acf_jax.export.c_header import c_header
from acf_jax.export.c_names import is_taken
from acf_jax.export.formula import Formula, of_corrected, of_paper
from acf_jax.model import Impact, Rig, find_peaks
from acf_jax.surrogate import load_surrogate
from tests.export.networks import untrained, untrained_corrected
from tests.surrogate.test_surrogate_features import wide_box

PROGRAM = r"""
#include <stdio.h>
#include "%(header)s.h"
int main(void)
{
    double x[%(inputs)d];
    while (fread(x, sizeof x, 1, stdin) == 1) {
        %(type)s p = %(function)s(%(arguments)s);
        double y[] = {%(outputs)s};
        fwrite(y, sizeof y, 1, stdout);
    }
    return 0;
}
"""
STRICT = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-O2", "-ffp-contract=off"]
PEAK = {"header": "acf_peak", "type": "acf_peak", "function": "acf_find_peak"}

Run = Callable[[np.ndarray], np.ndarray]


@pytest.fixture(scope="module")
def compiler() -> str:
    return need_program("cc", "gcc", "clang", remedy="install gcc or clang")


def compiled(compiler: str, folder: Path, names: dict[str, str], inputs: int, outputs: list[str]) -> Run:
    """Runs samples (N, inputs) through a header in `folder`: (N, outputs)."""
    told = {
        "inputs": inputs,
        "arguments": ", ".join(f"x[{i}]" for i in range(inputs)),
        "outputs": ", ".join(f"p.{name}" for name in outputs),
    }
    program = folder / names["header"]
    source = program.with_suffix(".c")
    source.write_text(PROGRAM % (names | told))
    subprocess.run([compiler, *STRICT, str(source), "-o", str(program), "-lm"], check=True)

    def run(samples: np.ndarray) -> np.ndarray:
        content = np.ascontiguousarray(samples, float).tobytes()
        done = subprocess.run([program], input=content, capture_output=True, check=True)
        return np.frombuffer(done.stdout).reshape(-1, len(outputs))

    return run


@pytest.fixture(scope="module")
def in_c(compiler: str, tmp_path_factory) -> Run:
    """The exact peak: (N, 3) force, time, has_peak."""
    folder = tmp_path_factory.mktemp("c")
    result = CliRunner().invoke(commands, ["export", "--c", str(folder / "acf_peak.h")])
    assert result.exit_code == 0, result.output
    return compiled(compiler, folder, PEAK, 6, ["f_max", "t_max", "has_peak"])


def test_header_agrees_with_jax_over_the_wide_box(in_c: Run) -> None:
    rig, impact = wide_box(2**15, seed=41)
    peak = find_peaks(rig, impact)
    columns = (rig.m, rig.d, rig.k_f, rig.k_c, impact.v_e, impact.f_p)
    found = in_c(np.stack([np.asarray(x) for x in columns], axis=1))
    has_peak = np.asarray(peak.has_peak)
    assert np.array_equal(found[:, 2] == 1, has_peak)
    assert found[has_peak, 0] == pytest.approx(np.asarray(peak.f_max)[has_peak], rel=1e-13)
    assert found[has_peak, 1] == pytest.approx(np.asarray(peak.t_max)[has_peak], rel=1e-9)
    assert np.isposinf(found[~has_peak, :2]).all()


def test_header_in_its_limits(in_c: Run) -> None:
    samples = np.array(
        [
            [4, 0, 0, 175561, 0.2, 100],  # no damping, no actuator: sqrt(F_P^2 + k_C m v^2)
            [4, 0, 0, 175561, 0.2, 0],
            [4, 60, 2000, 175561, 0, 100],  # at rest
            [4, 60, 2000, 175561, 0, 0],
            [2, 2 * np.sqrt(2 * 5e4), 0, 5e4, 0.3, 50],  # critical damping
            [2, 2e4, 0, 5e4, 0.3, 5000],  # far overdamped
        ]
    )
    rig, impact = Rig(*samples.T[:4]), Impact(*samples.T[4:])
    peak = find_peaks(rig, impact)
    found = in_c(samples)
    assert np.array_equal(found[:, 2] == 1, np.asarray(peak.has_peak))
    expected = np.where(peak.has_peak, peak.f_max, np.inf)
    assert found[:, 0] == pytest.approx(expected, rel=1e-13)
    assert found[0, 0] == pytest.approx(np.hypot(100, 0.2 * np.sqrt(4 * 175561)), rel=1e-14)


def test_header_refuses_what_is_no_rig_and_no_impact(in_c: Run) -> None:
    """A sign error or a missing value in a controller must pass no limit."""
    sound = np.array([4, 60, 2000, 175561, 0.2, 100.0])
    wrong = [(i, -value) for i, value in enumerate(sound)] + [(0, 0.0), (3, 0.0)]
    wrong += [(i, x) for i in range(6) for x in (np.nan, np.inf)]
    samples = np.tile(sound, (len(wrong), 1))
    for row, (i, value) in zip(samples, wrong, strict=True):
        row[i] = value
    assert in_c(sound)[0, 2] == 1
    assert np.array_equal(in_c(samples), np.tile([np.inf, np.inf, 0], (len(wrong), 1)))


def agree_in_c(compiler: str, folder: Path, name: str, formula: Formula, least: float = 0.2) -> None:
    """The header of a surrogate beside JAX: values inside the range, flag and infinity outside."""
    (folder / f"{name}.h").write_text(c_header(formula, name, "of a test"))
    names = {"header": name, "type": f"{name}_result", "function": name}
    outputs = [*(q.name for q in formula.outputs), "is_inside"]
    run = compiled(compiler, folder, names, len(formula.inputs), outputs)
    x = formula.draw(np.random.default_rng(8), 2**12)
    x[-1, -1] = np.nan
    *expected, inside = (np.asarray(y) for y in jax.jit(jax.vmap(formula.function))(x))
    *found, is_inside = run(x).T
    assert np.array_equal(is_inside == 1, inside) and least < inside.mean() < 0.9 and not inside[-1]
    for y, wanted in zip(found, expected, strict=True):
        assert y[inside] == pytest.approx(wanted[inside], rel=1e-6)
        assert np.isposinf(y[~inside]).all()


def test_header_of_the_shipped_surrogate(compiler: str, tmp_path: Path) -> None:
    agree_in_c(compiler, tmp_path, "shipped", of_paper(load_surrogate()))
    text = (tmp_path / "shipped.h").read_text()
    for part in (
        "v_e          0.01 to 1 m/s",
        "m            kg, moving mass",
        "held-out",
        "and the rest is infinite",
    ):
        assert part in text


@pytest.mark.parametrize(
    "features, activation",
    [
        ("raw", "silu"),
        ("dimensionless", "gelu"),
        ("raw", "softsign"),
        pytest.param("raw", "softplus", marks=pytest.mark.long),
    ],
)
def test_header_of_every_kind_of_network(
    compiler: str, tmp_path: Path, features: str, activation: str
) -> None:
    agree_in_c(compiler, tmp_path, "other", of_paper(untrained(features, activation)))


def test_header_of_a_corrected_model(compiler: str, tmp_path: Path) -> None:
    formula = of_corrected(untrained_corrected(("k_c", "gravity.force_n", "v_e", "f_p")))
    agree_in_c(compiler, tmp_path, "gap", formula, least=0.1)
    text = (tmp_path / "gap.h").read_text()
    for part in ("double gravity_force_n, double v_e", "double t_max;", "m            1.5 kg, fixed"):
        assert part in text


@pytest.mark.parametrize("arguments", [[], ["--c", "peak.txt"]])
def test_export_says_what_is_missing(arguments: list[str]) -> None:
    with pytest.raises(InputError):
        CliRunner().invoke(commands, ["export", *arguments], catch_exceptions=False)


@pytest.mark.parametrize(
    "name, why",
    [
        ("double", "a name of C, C++ or math.h"),
        ("class", "a name of C, C++ or math.h"),
        ("expf", "a name of C, C++ or math.h"),
        ("Acf_Peak", "the include guard of the exact peak's header"),
        ("2peak", "letters, digits and _ only"),
    ],
)
def test_names_that_no_function_of_a_header_can_have(name: str, why: str, tmp_path: Path) -> None:
    header = tmp_path / f"{name}.h"
    with pytest.raises(InputError, match=re.escape(why)):
        CliRunner().invoke(
            commands, ["export", "--surrogate", "shipped", "--c", str(header)], catch_exceptions=False
        )
    assert not header.exists()


def test_every_function_that_math_h_declares_is_taken(compiler: str) -> None:
    text = subprocess.run(
        [compiler, "-E", "-x", "c", "-"],
        input="#include <math.h>\n",
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    declared = set(re.findall(r"\bextern [\w ]+?\**(\w+) \(", text, re.MULTILINE))
    assert "cosh" in declared
    assert not {name for name in declared if not name.startswith("_") and not is_taken(name)}


def test_a_stated_bound_is_rounded_up() -> None:
    surrogate = untrained_corrected(("k_c", "v_e", "f_p"))
    surrogate = eqx.tree_at(lambda s: s.bounds.time, surrogate, jnp.asarray(1.21e-5))
    (time,) = (q for q in of_corrected(surrogate).outputs if q.name == "t_max")
    assert "wrong by less than 0.000013 s" in time.meaning
