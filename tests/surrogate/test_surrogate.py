"""The shipped surrogate: its stated error, its bound, its gradient, its range; and damaged files."""

import json
import subprocess
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from acf_jax.errors import InputError
from acf_jax.model import Impact, Rig, find_peak, find_peaks
from acf_jax.surrogate import Surrogate, load_surrogate
from acf_jax.surrogate.fold import distance_to_fold
from acf_jax.surrogate.load import DEFAULT
from tests.surrogate.test_surrogate_features import wide_box

# one size for all, so that XLA compiles each function once
SAMPLES = 2**17


@pytest.fixture(scope="module")
def shipped() -> Surrogate:
    return load_surrogate()


def test_shipped_default_keeps_its_word_on_fresh_samples(shipped: Surrogate) -> None:
    rig, impact = wide_box(SAMPLES, seed=11)
    peak = find_peaks(rig, impact)
    kept = np.asarray(peak.has_peak)
    answer = shipped(rig, impact, outside="flag")
    assert np.array_equal(answer.is_inside, kept)
    error = np.abs(np.asarray(answer.f_max - peak.f_max))[kept]
    stated = json.loads(shipped.header)["errors"]["box"]["relative"]
    relative = error / np.asarray(peak.f_max)[kept]
    assert np.quantile(relative, 0.999) <= 1.1 * stated["p99_9"] < 3e-4
    assert stated["max"] < 1e-4
    # Of n samples in a bin at most about one exceeds the largest of as many held-out ones.
    assert (error > np.asarray(answer.error_bound)[kept]).sum() <= 10


def test_size_of_the_shipped_file() -> None:
    assert DEFAULT.stat().st_size < 200_000


def test_gradient_against_finite_differences(shipped: Surrogate) -> None:
    rig, impact = wide_box(SAMPLES, seed=2)
    answer = shipped(rig, impact, outside="flag")
    # closer to the fold the step itself would cross it
    kept = np.asarray(answer.is_inside & (jax.vmap(distance_to_fold)(rig, impact).u > 0.05))
    force = jax.jit(jax.vmap(shipped.force))
    leaves, tree = jax.tree.flatten((rig, impact))
    for i, slope in enumerate(jax.tree.leaves(answer.gradient)):
        assert np.isfinite(slope).all()
        step = 1e-5 * leaves[i]
        ends = []
        for sign in (1, -1):
            moved = [leaf + sign * step if j == i else leaf for j, leaf in enumerate(leaves)]
            ends.append(force(*jax.tree.unflatten(tree, moved)))
        scale = leaves[i] / answer.f_max
        difference = (ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose((slope * scale)[kept], (difference * scale)[kept], atol=5e-6)


def test_gradient_is_finite_wherever_the_surrogate_answers(shipped: Surrogate) -> None:
    """Close below critical damping, without an actuator's stiffness, the fold's distance divides by next to nothing."""
    zeta = 1 - jnp.geomspace(1e-7, 1e-3, 400)
    one = jnp.ones_like(zeta)
    rig = Rig(m=4.0 * one, d=2 * zeta * jnp.sqrt(4.0 * 175561.0), k_f=0.0 * one, k_c=175561.0 * one)
    answer = shipped(rig, Impact(v_e=0.2 * one, f_p=0.0 * one), outside="flag")
    assert answer.is_inside.sum() > 100
    for slope in jax.tree.leaves(answer.gradient):
        assert np.isfinite(slope).all()
    np.testing.assert_allclose(
        answer.gradient[1].v_e, answer.f_max / 0.2, rtol=1e-6
    )  # F = v g(zeta) for F_P = 0


def test_gradient_is_that_of_the_model(shipped: Surrogate) -> None:
    rig, impact = wide_box(SAMPLES, seed=4)
    answer = shipped(rig, impact, outside="flag")
    exact = jax.grad(lambda sample: find_peaks(*sample).f_max.sum())((rig, impact))
    for ours, theirs, x in zip(*map(jax.tree.leaves, (answer.gradient, exact, (rig, impact))), strict=True):
        off = np.abs((ours - theirs) * x / answer.f_max)[np.asarray(answer.is_inside)]
        assert np.quantile(off, 0.999) < 1e-5
        assert off.max() < 1e-3


def test_one_sample_and_a_batch_agree(shipped: Surrogate) -> None:
    rig, impact = wide_box(SAMPLES)
    batch = shipped(rig, impact, outside="flag")
    one = shipped(*jax.tree.map(lambda leaf: leaf[7], (rig, impact)), outside="flag")
    assert one.f_max.shape == ()
    assert float(one.f_max) == pytest.approx(float(batch.f_max[7]), rel=1e-12)


def test_refuses_what_it_was_not_trained_for(shipped: Surrogate) -> None:
    def one(m: float, d: float, k_f: float, k_c: float, v_e: float, f_p: float) -> tuple[Rig, Impact]:
        return Rig(m=m, d=d, k_f=k_f, k_c=k_c), Impact(v_e=v_e, f_p=f_p)

    with pytest.raises(InputError) as error:
        shipped(*one(20.0, 0.0, 0.0, 1e5, 2.0, 100.0))
    assert [fault.split(" must be")[0] for fault in error.value.faults] == ["m", "v_e"]
    assert "0.01 to 1 m/s, but is 2 in sample 0" in error.value.faults[1]
    assert not bool(shipped(*one(20.0, 0.0, 0.0, 1e5, 2.0, 100.0), outside="flag").is_inside)
    with pytest.raises(ValueError, match="one shape"):
        shipped(Rig(np.full(3, 4.0), 60.0, 2e3, 1.7e5), Impact(np.full(2, 0.2), np.full(2, 100.0)))
    swept = shipped(Rig(4.0, 60.0, 2e3, 1.7e5), Impact(np.array([0.1, 0.2]), 100.0))
    alone = shipped(Rig(4.0, 60.0, 2e3, 1.7e5), Impact(0.2, 100.0))
    assert float(swept.f_max[1]) == pytest.approx(float(alone.f_max), rel=1e-12)

    with pytest.raises(InputError, match=r"zeta must be 0 to 1\.5, but is 2"):
        shipped(*one(1.0, 2 * 2 * np.sqrt(1e5).item(), 0.0, 1e5, 0.2, 100.0))

    # damped so much that the contact velocity is never compensated
    with pytest.raises(InputError, match="has no peak"):
        shipped(*one(1.0, 2 * 1.2 * np.sqrt(1.1e5).item(), 1e4, 1e5, 0.2, 1.0))
    with pytest.raises(InputError, match=r"v_e must be .* in sample 1 \(and 1 more\)"):
        shipped(
            Rig(m=jnp.ones(3), d=jnp.zeros(3), k_f=jnp.zeros(3), k_c=jnp.full(3, 1e5)),
            Impact(v_e=jnp.array([0.1, 3.0, 4.0]), f_p=jnp.full(3, 100.0)),
        )


def test_traced_samples_are_pointed_to_predict(shipped: Surrogate) -> None:
    rig, impact = Rig(m=2, d=0, k_f=0, k_c=1e5), Impact(v_e=0.2, f_p=100)
    with pytest.raises(ValueError, match="call `predict` inside jit"):
        jax.jit(lambda r: shipped(r, impact).f_max)(rig)
    inside = jax.jit(lambda r: shipped.predict(r, impact))(rig)
    assert float(inside.f_max) == pytest.approx(float(np.hypot(100, 0.2 * np.sqrt(2e5))), rel=1e-6)


def test_bound_grows_towards_the_fold(shipped: Surrogate) -> None:
    largest = np.asarray(shipped.held_out.largest)
    assert (np.diff(largest) <= 0).all() and (largest > 0).all()
    bounds = [float(shipped.held_out(jnp.asarray(u))) for u in (0.0, 0.05, 0.5, 0.95, 1.0)]
    assert bounds == sorted(bounds, reverse=True)
    assert bounds[0] == largest[0] and bounds[-1] == largest[-1]


def test_damaged_files_are_refused(tmp_path: Path) -> None:
    whole = DEFAULT.read_bytes()
    line, body = whole.split(b"\n", 1)
    header = json.loads(line)

    def with_header(**changes: object) -> bytes:
        return json.dumps({**header, **changes}).encode() + b"\n" + body

    damaged = {
        "missing": None,
        "empty": b"",
        "cut in the header": whole[:100],
        "cut in the leaves": whole[:-1],
        "one bit": whole[:-50] + bytes([whole[-50] ^ 1]) + whole[-49:],
        "longer": whole + b"x",
        "a pickle": b"\x80\x04\x95",
        "a list": b"[]\n",
        "other width": with_header(network={"width": 7, "depth": 3, "activation": "tanh"}),
        "huge width": with_header(network={"width": 10**9, "depth": 3}),
        "other features": with_header(features="raw"),
        "other format": with_header(format="something else"),
        "no ranges": with_header(ranges={}),
        "no finite range": json.dumps({**header, "ranges": {"m": {"low": float("nan"), "high": 1}}}).encode()
        + b"\n"
        + body,
    }
    for name, content in damaged.items():
        path = tmp_path / f"{name}.eqx"
        if content is not None:
            path.write_bytes(content)
        with pytest.raises(InputError, match=path.name):
            load_surrogate(path)


def test_loads_and_answers_without_x64() -> None:
    """A program that never turned on float64 gets the same force, in float32, and a bound that still holds."""
    code = """
import numpy as np
from acf_jax.model import Impact, Rig
from acf_jax.surrogate import load_surrogate
answer = load_surrogate()(Rig(m=4.0, d=40.0, k_f=2e3, k_c=1.5e5), Impact(v_e=0.2, f_p=100.0))
assert answer.f_max.dtype == np.float32
print(float(answer.f_max), float(answer.error_bound))
"""
    run = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    force, bound = map(float, run.stdout.split())
    exact = float(find_peak(Rig(m=4.0, d=40.0, k_f=2e3, k_c=1.5e5), Impact(v_e=0.2, f_p=100.0)).f_max)
    assert abs(force - exact) <= bound < 1e-4 * exact
