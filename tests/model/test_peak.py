"""The peak force against 60-digit truth: over the wide box, at its corners, in its limits, near the fold."""

import itertools
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acf_jax.files import read_yaml_mapping
from acf_jax.model import Impact, Rig, contact_force_rate, find_peak, find_peaks
from acf_jax.model import peak as batches
from acf_jax.model.blocks import BLOCK
from acf_jax.model.printed_eq10 import find_peak_by_printed_eq10
from tests import truth

REPOSITORY = Path(__file__).parents[2]

one_peak = jax.jit(find_peak)

LIMITS = {
    "undamped": (4.0, 0.0, 3000.0, 2e5, 0.2, 100.0),
    "no actuator stiffness": (4.0, 200.0, 0.0, 2e5, 0.2, 100.0),
    "neither": (4.0, 0.0, 0.0, 2e5, 0.2, 100.0),
    "no pretension": (4.0, 200.0, 3000.0, 2e5, 0.2, 0.0),
    "no pretension, nothing else": (4.0, 0.0, 0.0, 2e5, 0.2, 0.0),
    "critical, exactly": (1.0, 200.0, 0.0, 1e4, 0.1, 300.0),
    "critical, from below": (1.0, 200.0 * (1 - 1e-12), 10.0, 1e4, 0.1, 300.0),
    "critical, from above": (1.0, 200.0 * (1 + 1e-9), 0.0, 1e4, 0.1, 300.0),
    "slow": (4.0, 200.0, 3000.0, 2e5, 1e-9, 100.0),
    "fast": (4.0, 200.0, 3000.0, 2e5, 100.0, 100.0),
    "soft contact": (4.0, 5.0, 1000.0, 500.0, 0.05, 100.0),
    "overdamped fivefold": (1.0, 1000.0, 0.0, 1e4, 0.01, 300.0),
    "overdamped hundredfold": (1.0, 20000.0, 1.0, 1e4, 0.001, 500.0),
    "overdamped, barely turning": (1.0, 250.0, 0.0, 1e4, 0.1, 20.0001),
}


def batch(samples: np.ndarray) -> tuple[Rig, Impact]:
    return Rig(*samples[:, :4].T), Impact(*samples[:, 4:].T)


def corners_of_the_wide_box() -> np.ndarray:
    corners = []
    for m, zeta, k_f, k_c, v, f_p in itertools.product(
        (0.5, 10), (0, 1.5), (0, 1e4), (1e4, 1e6), (0.01, 1), (0, 500)
    ):
        corners.append((m, 2 * zeta * np.sqrt(m * (k_f + k_c)), k_f, k_c, v, f_p))
    return np.array(corners, float)


def assert_matches_truth(samples: np.ndarray, force: float, time: float) -> None:
    peaks = find_peaks(*batch(samples))
    exact = [truth.peak(tuple(sample)) for sample in samples.astype(float)]
    np.testing.assert_array_equal(peaks.has_peak, [e is not None for e in exact])
    assert peaks.f_max.dtype == samples.dtype
    for sample, f_max, t_max, e in zip(samples, peaks.f_max, peaks.t_max, exact, strict=True):
        assert np.isfinite(f_max) and np.isfinite(t_max), sample
        if e is not None:
            assert abs(float(f_max) / e.f_max - 1) < force, sample
            assert abs(float(t_max) / e.t_max - 1) < time, sample


@pytest.mark.parametrize(
    "samples", [truth.wide_box(200, seed=1), corners_of_the_wide_box()], ids=("box", "corners")
)
def test_matches_truth_in_float64(samples):
    assert_matches_truth(samples, force=1e-14, time=1e-11)


@pytest.mark.parametrize(
    "samples", [truth.wide_box(200, seed=2), corners_of_the_wide_box()], ids=("box", "corners")
)
def test_matches_truth_in_float32(samples):
    assert_matches_truth(samples.astype(np.float32), force=2e-6, time=1e-3)


@pytest.mark.parametrize("sample", LIMITS.values(), ids=LIMITS.keys())
def test_matches_truth_in_the_limits(sample):
    assert_matches_truth(np.array([sample]), force=1e-12, time=1e-7)


def at_the_fold(sample: tuple[float, ...]) -> float:
    """The k_f at which the sample's peak vanishes, to rounding."""
    m, d, _, k_c, v, f_p = sample
    low, high = 0.0, 1e6
    while high - low > 1e-14 * high:
        middle = (low + high) / 2
        has_peak = one_peak(Rig(m, d, middle, k_c), Impact(v, f_p)).has_peak
        low, high = (middle, high) if has_peak else (low, middle)
    return low


@pytest.mark.parametrize("zeta", [0.05, 0.5, 1.0, 1.4])
@pytest.mark.parametrize("distance", [1e-2, 1e-6, 1e-10])
def test_matches_truth_next_to_the_fold(zeta, distance):
    sample = (2.0, 2 * zeta * np.sqrt(2.0 * 1e5), 0.0, 1e5, 0.8, 400.0 * zeta)
    k_f = at_the_fold(sample)
    inside = np.array([(*sample[:2], k_f * (1 - distance), *sample[3:])])
    # a time next to a double root holds half the digits of the data
    assert_matches_truth(inside, force=1e-12, time=1e-14 / np.sqrt(distance) + 1e-12)
    outside = np.array([(*sample[:2], k_f * (1 + distance), *sample[3:])])
    assert truth.peak(tuple(outside[0])) is None
    assert not find_peaks(*batch(outside)).has_peak[0]


def test_no_peak_gives_the_inflection():
    sample = (4.0, 500.0, 9000.0, 2e4, 0.8, 50.0)
    assert truth.peak(sample) is None
    peak, inflection = one_peak(Rig(*sample[:4]), Impact(*sample[4:])), truth.inflection(sample)
    assert not peak.has_peak
    assert abs(float(peak.t_max) / inflection - 1) < 1e-12
    assert abs(float(peak.f_max) / truth.force(sample, inflection) - 1) < 1e-12


def test_no_peak_and_no_inflection_gives_a_settled_force():
    sample = (1.0, 300.0, 5000.0, 1e4, 0.5, 0.0)
    assert truth.inflection(sample) is None
    peak = one_peak(Rig(*sample[:4]), Impact(*sample[4:]))
    assert not peak.has_peak
    assert abs(float(peak.f_max) / truth.force(sample, float(peak.t_max)) - 1) < 1e-12


def test_nothing_happens_without_velocity():
    peak = one_peak(Rig(4.0, 100.0, 1000.0, 1e5), Impact(0.0, 80.0))
    assert peak.has_peak and peak.t_max == 0
    np.testing.assert_allclose(peak.f_max, 80.0, rtol=1e-15)
    rest = one_peak(Rig(4.0, 100.0, 1000.0, 1e5), Impact(0.0, 0.0))
    assert rest.f_max == 0 and np.isfinite(rest.t_max)


def test_batch_equals_samples_across_blocks():
    rig, impact = batch(truth.wide_box(BLOCK + 7, seed=3))
    blocked, mapped = find_peaks(rig, impact), jax.jit(jax.vmap(find_peak))(rig, impact)
    for x, y in zip(blocked, mapped, strict=True):
        np.testing.assert_allclose(x, y, rtol=1e-13)


def test_a_batch_within_another_program_is_the_batch_on_its_own():
    rig, impact = batch(truth.wide_box(BLOCK + 5, seed=4))
    alone = find_peaks(rig, impact).f_max
    np.testing.assert_allclose(jax.jit(lambda r, i: find_peaks(r, i).f_max)(rig, impact), alone, rtol=1e-14)
    constants = jax.jit(lambda x: x * find_peaks(rig, impact).f_max)  # no field of theirs is traced
    np.testing.assert_allclose(constants(1.0), alone, rtol=1e-14)


def test_a_compiler_that_knows_no_width_of_vectors_does_without(monkeypatch):
    rig, impact = batch(truth.wide_box(BLOCK + 5, seed=4))
    known = find_peaks(rig, impact).f_max
    monkeypatch.setattr(batches, "VECTORS", {"xla_no_such_option": 512})
    batches._in_wide_vectors.cache_clear()
    np.testing.assert_allclose(find_peaks(rig, impact).f_max, known, rtol=1e-14)
    assert batches._in_wide_vectors() is batches._as_it_comes
    monkeypatch.undo()
    batches._in_wide_vectors.cache_clear()


def test_fields_of_shapes_that_do_not_fit_are_refused_with_the_remedy():
    rig, impact = Rig(4.0, 60.0, 2e3, 1.7e5), Impact(0.2, 100.0)
    rigs, impacts = batch(truth.wide_box(3, seed=1))
    for find, one, other, says in (
        (find_peak, rig, impacts, r"\(3,\); use find_peaks"),
        (find_peaks, rigs, Impact(np.full(2, 0.2), 100.0), r"\(\) and \(2,\) and \(3,\); give each"),
        (find_peak, rigs, impacts, r"\(3,\); use find_peaks"),
        (find_peaks, rig, impact, r"\(\); use find_peak "),
    ):
        with pytest.raises(ValueError, match=says):
            find(one, other)


def test_numbers_broadcast_against_arrays_and_arrays_against_each_other():
    rig, velocities, pretensions = (
        Rig(4.0, 60.0, 2e3, 1.7e5),
        np.linspace(0.05, 0.35, 3),
        np.array([60.0, 100.0]),
    )
    swept = find_peaks(rig, Impact(velocities, 100.0))
    table = find_peaks(rig, Impact(velocities[:, None], pretensions))
    assert swept.f_max.shape == (3,) and table.f_max.shape == (3, 2)
    np.testing.assert_array_equal(table.f_max[:, 1], swept.f_max)
    for v, row in zip(velocities, table.f_max, strict=True):
        for f_p, force in zip(pretensions, row, strict=True):
            assert float(force) == pytest.approx(float(one_peak(rig, Impact(v, f_p)).f_max), rel=1e-13)
    slope = jax.grad(lambda impact: find_peaks(rig, impact).f_max.sum())(Impact(velocities, 100.0))
    one_slope = jax.jit(jax.grad(lambda i: find_peak(rig, i).f_max))
    each = [one_slope(Impact(v, 100.0)).f_p for v in velocities]
    assert float(slope.f_p) == pytest.approx(float(sum(each)), rel=1e-12)


def test_quantities_are_shown_with_their_units():
    rig, impact = Rig(4.0, 60.0, 2e3, 175561.0), Impact(np.array([0.05, 0.35]), 100.0)
    assert repr(rig) == "Rig(m=4 kg, d=60 N s/m, k_f=2000 N/m, k_c=175561 N/m)"
    assert repr(impact) == "Impact(v_e=0.05 to 0.35 m/s (2,), f_p=100 N)"
    swept = repr(find_peaks(rig, impact))
    assert swept == "Peak(108.50 to 313.99 N after 1.920 to 6.098 ms, 2 impacts)"
    assert repr(one_peak(rig, Impact(0.2, 100.0))) == "Peak(196.99 N after 5.067 ms)"
    assert repr(one_peak(Rig(1.0, 5e3, 1e4, 1e4), Impact(0.01, 0.0))) == "Peak(none, the force keeps rising)"
    shown = []
    jax.jit(lambda rig: shown.append(f"{rig} {find_peak(rig, Impact(0.2, 100.0))}"))(
        rig
    )  # of traced values as well
    assert shown[0].startswith("Rig(m=") and "Peak(" in shown[0]


@pytest.mark.parametrize(
    "kind", [jnp.float16, jnp.bfloat16, jnp.float8_e4m3b11fnuz, np.float32, np.int8, np.uint64, int]
)
def test_numbers_of_every_precision_give_a_peak(kind):
    values = (4, 10, 16, 24, 1, 26)
    expected = one_peak(Rig(*map(float, values[:4])), Impact(*map(float, values[4:])))
    rig, impact = Rig(*map(kind, values[:4])), Impact(*map(kind, values[4:]))
    assert rig.m.dtype == (jnp.float64 if jnp.issubdtype(jnp.dtype(kind), jnp.integer) else jnp.float32)
    for peak in (
        one_peak(rig, impact),
        jax.jit(lambda *v: find_peak(Rig(*v[:4]), Impact(*v[4:])))(*map(kind, values)),
    ):
        assert bool(peak.has_peak) == bool(expected.has_peak) and expected.has_peak
        np.testing.assert_allclose([peak.f_max, peak.t_max], [expected.f_max, expected.t_max], rtol=1e-5)


@pytest.mark.parametrize("one", [True, np.True_, np.array([True]), 1j, np.complex64(1)])
def test_what_is_no_real_number_is_no_parameter(one):
    with pytest.raises(ValueError, match=r"parameters must be real numbers, but are (bool|complex)"):
        Rig(one, 60.0, 2e3, 2e5)


@pytest.mark.parametrize(
    ("values", "fault"),
    [
        ((10**400, 60, 2000, 20000), "Rig.m must be finite and positive, but is inf"),
        ((0, 60, 2000, 20000), "Rig.m must be finite and positive, but is 0"),
        ((4, -1, 2000, 20000), "Rig.d must be finite and zero or positive, but is -1"),
        ((4, 60, 2000, np.float16(np.inf)), "Rig.k_c must be finite and positive, but is inf"),
        ((np.float32(1e-20), 60, 2e3, 2e4), r"Rig.m must be between 5.3e-09 and 1.2e\+10 in float32, but is 1e-20"),
        ((4, 60, np.float32(1e20), 2e4), r"Rig.k_f must be between 0 and 1.2e\+10 in float32, but is 1e\+20"),
        ((4, 60, 2e3, 1e200), r"Rig.k_c must be between 2e-76 and 3.3e\+77 in float64, but is 1e\+200"),
    ],
)  # fmt: skip
def test_parameters_that_no_rig_has_are_refused(values, fault):
    with pytest.raises(ValueError, match=fault):
        Rig(*values)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_whatever_is_accepted_has_a_finite_answer(dtype):
    """Magnitudes log-uniform over all that is accepted, a third of them at its ends, some zero or subnormal."""
    rng, n, info = np.random.default_rng(0), 40 * BLOCK, np.finfo(dtype)
    low, high = 16 * float(info.tiny) ** 0.25, 4 / float(info.tiny) ** 0.25

    def draw(least: float) -> np.ndarray:
        at = rng.random(n)
        at = np.select([at < 0.15, at > 0.85], [0.0, 1.0], at)
        return (
            (float(least) ** (1 - at) * high**at)
            .astype(dtype)
            .clip(None, np.nextafter(dtype(high), dtype(0)))
        )

    m, k_c = draw(low * 1.001), draw(low * 1.001)
    d, k_f, v_e, f_p = (
        np.where(rng.random(n) < 0.1, dtype(0), draw(least))
        for least in rng.permuted([info.tiny, info.smallest_subnormal, low, 1e-3])
    )
    peak = find_peaks(Rig(m, d, k_f, k_c), Impact(v_e, f_p))
    assert np.isfinite(peak.f_max).all() and np.isfinite(peak.t_max).all()
    assert 0.05 < np.mean(peak.has_peak) < 0.95


def test_a_sample_that_is_not_a_number_ends_and_spoils_no_other():
    samples = truth.wide_box(20, seed=9)
    clean = find_peaks(*batch(samples))
    spoiled = jax.jit(lambda s: find_peaks(*batch(s)))(
        samples * np.where(np.arange(20) == 7, np.nan, 1.0)[:, None]
    )
    others = np.arange(20) != 7
    np.testing.assert_allclose(spoiled.f_max[others], clean.f_max[others], rtol=1e-14)
    assert not spoiled.has_peak[7] and np.isnan(spoiled.f_max[7])


def test_the_root_is_the_first_one():
    """On a dense scan the force's rate has one sign up to t_max."""
    rig, impact = batch(truth.wide_box(300, seed=4))
    peaks = find_peaks(rig, impact)
    times = jnp.linspace(0, 1, 400, endpoint=False)[None, :] * peaks.t_max[:, None]
    rates = jax.jit(jax.vmap(jax.vmap(contact_force_rate, (None, None, 0))))(rig, impact, times)
    assert (rates[peaks.has_peak] > 0).all()
    assert 0.75 < peaks.has_peak.mean() < 0.9


def test_table_1_of_the_paper():
    """One rig reproduces the model column of Table 1."""
    rig = Rig(**read_yaml_mapping(REPOSITORY / "configs/table1_rig.yaml")["rig"])
    for v_e, paper in zip((0.05, 0.1, 0.2, 0.3, 0.35), (108, 130, 195, 271, 310), strict=True):
        assert abs(one_peak(rig, Impact(v_e, 100.0)).f_max - paper) < 0.5


@settings(max_examples=60, deadline=None)
@given(m=st.floats(0.5, 10), k_c=st.floats(1e4, 1e6), v=st.floats(0.01, 1), f_p=st.floats(0, 500))
def test_undamped_without_actuator_is_an_energy_balance(m, k_c, v, f_p):
    peak = one_peak(Rig(m, 0.0, 0.0, k_c), Impact(v, f_p))
    np.testing.assert_allclose(peak.f_max, np.sqrt(f_p**2 + k_c * m * v**2), rtol=1e-14)


@settings(max_examples=60, deadline=None)
@given(
    m=st.floats(0.5, 10),
    zeta=st.floats(0, 1.5),
    k_f=st.floats(0, 1e4),
    k_c=st.floats(1e4, 1e6),
    v=st.floats(0.01, 1),
    f_p=st.floats(0, 490),
    more=st.floats(0.01, 10),
)
def test_peak_grows_with_pretension_and_exceeds_it(m, zeta, k_f, k_c, v, f_p, more):
    rig = Rig(m, 2 * zeta * np.sqrt(m * (k_f + k_c)), k_f, k_c)
    less_force, more_force = one_peak(rig, Impact(v, f_p)), one_peak(rig, Impact(v, f_p + more))
    if less_force.has_peak and more_force.has_peak:
        assert less_force.f_max <= more_force.f_max * (1 + 1e-15)
        assert less_force.f_max >= f_p


def test_printed_eq10_is_exact_only_without_damping_or_actuator():
    printed = jax.jit(find_peak_by_printed_eq10)
    impact = Impact(0.3, 100.0)
    for rig in (Rig(4.0, 0.0, 8000.0, 1e5), Rig(4.0, 700.0, 0.0, 1e5)):
        np.testing.assert_allclose(printed(rig, impact).t_max, one_peak(rig, impact).t_max, rtol=1e-12)
    rig = Rig(4.0, 700.0, 8000.0, 1e5)
    assert printed(rig, impact).t_max < 0.99 * one_peak(rig, impact).t_max


def test_printed_eq10_finds_peaks_that_do_not_exist():
    rig, impact = batch(truth.wide_box(20_000, seed=5))
    full, printed = find_peaks(rig, impact), jax.jit(jax.vmap(find_peak_by_printed_eq10))(rig, impact)
    both = full.has_peak & printed.has_peak
    error = jnp.abs(printed.f_max / full.f_max - 1)[both]
    assert (printed.has_peak & ~full.has_peak).sum() > 100
    assert 0.005 < error.max() < 0.05 and jnp.median(error) < 1e-5
