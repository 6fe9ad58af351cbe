"""The C header against JAX over the wide box and in its limits; needs a compiler and never runs in CI."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from acf_jax.cli.main import commands
from acf_jax.errors import InputError
from acf_jax.model import Impact, Rig, find_peaks
from tests.surrogate.test_surrogate_features import wide_box

PROGRAM = r"""
#include <stdio.h>
#include "acf_peak.h"
int main(void)
{
    double x[6];
    while (fread(x, sizeof x, 1, stdin) == 1) {
        acf_peak p = acf_find_peak(x[0], x[1], x[2], x[3], x[4], x[5]);
        double y[3] = {p.f_max, p.t_max, p.has_peak};
        fwrite(y, sizeof y, 1, stdout);
    }
    return 0;
}
"""


@pytest.fixture(scope="module")
def compiler() -> str:
    if os.environ.get("CI", "").lower() in ("1", "true"):
        pytest.skip("compiles C: not in CI")
    found = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if found is None:
        pytest.skip("needs a C compiler: install gcc or clang")
    return found


@pytest.fixture(scope="module")
def header(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("c") / "acf_peak.h"
    result = CliRunner().invoke(commands, ["export", "--c", str(path)])
    assert result.exit_code == 0, result.output
    return path


@pytest.fixture(scope="module")
def in_c(compiler, header):
    """Runs samples (N, 6) through the compiled header: (N, 3) force, time, has_peak."""
    source, program = header.with_name("main.c"), header.with_name("main")
    source.write_text(PROGRAM)
    strict = [
        "-std=c99",
        "-pedantic",
        "-Wall",
        "-Wextra",
        "-Wconversion",
        "-Werror",
        "-O2",
        "-ffp-contract=off",
    ]
    subprocess.run([compiler, *strict, str(source), "-o", str(program), "-lm"], check=True)

    def run(samples: np.ndarray) -> np.ndarray:
        done = subprocess.run(
            [program], input=np.ascontiguousarray(samples).tobytes(), capture_output=True, check=True
        )
        return np.frombuffer(done.stdout).reshape(-1, 3)

    return run


def test_header_agrees_with_jax_over_the_wide_box(in_c):
    rig, impact = wide_box(2**15, seed=41)
    peak = find_peaks(rig, impact)
    columns = (rig.m, rig.d, rig.k_f, rig.k_c, impact.v_e, impact.f_p)
    found = in_c(np.stack([np.asarray(x) for x in columns], axis=1))
    has_peak = np.asarray(peak.has_peak)
    assert np.array_equal(found[:, 2] == 1, has_peak)
    assert found[has_peak, 0] == pytest.approx(np.asarray(peak.f_max)[has_peak], rel=1e-13)
    assert found[has_peak, 1] == pytest.approx(np.asarray(peak.t_max)[has_peak], rel=1e-9)
    assert np.isfinite(found).all()


def test_header_in_its_limits(in_c):
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
    assert found[:, 0] == pytest.approx(np.asarray(peak.f_max), rel=1e-13)
    assert found[0, 0] == pytest.approx(np.hypot(100, 0.2 * np.sqrt(4 * 175561)), rel=1e-14)


@pytest.mark.parametrize("arguments", [[], ["--c", "peak.txt"]])
def test_export_says_what_is_missing(arguments):
    with pytest.raises(InputError):
        CliRunner().invoke(commands, ["export", *arguments], catch_exceptions=False)
