"""What measured peaks identify: Table 1 of the paper, and recovery of a known product."""

import numpy as np
import pytest

from acf_jax.errors import InputError
from acf_jax.identify import MOST, Peaks, ideal_peak, identify, information, relative_error

V_E = np.array([0.05, 0.1, 0.2, 0.3, 0.35])
F_P = np.full(5, 100.0)
PAPER_MODEL = np.array([108.0, 130, 195, 271, 310])
TABLE_1 = Peaks(V_E, F_P, np.array([110.0, 137, 198, 282, 320]))


def test_table_1_gap_shrinks_as_far_as_one_number_can():
    found = identify(TABLE_1)
    assert f"{100 * relative_error(PAPER_MODEL, TABLE_1.f_max):.2f}" == "3.37"
    assert f"{100 * found.error:.2f}" == "1.64"
    assert f"{100 * found.error_left_out:.2f}" == "1.90"
    assert found.interval[0] < found.sqrt_k_c_m < found.interval[1]


def test_the_paper_s_column_holds_838():
    assert abs(identify(Peaks(V_E, F_P, PAPER_MODEL)).sqrt_k_c_m - 838) < 2


@pytest.mark.parametrize("product", [50.0, 838.0, 5000.0])
def test_recovers_the_product_of_exact_peaks(product):
    found = identify(Peaks(V_E, F_P, ideal_peak(product, V_E, F_P)))
    np.testing.assert_allclose(found.sqrt_k_c_m, product, rtol=1e-9)
    assert found.error < 1e-9


def test_the_interval_covers_the_truth_as_often_as_it_says():
    random = np.random.default_rng(0)
    covered = 0
    for _ in range(400):
        noisy = ideal_peak(838.0, V_E, F_P) * (1 + 0.02 * random.standard_normal(5))
        low, high = identify(Peaks(V_E, F_P, noisy)).interval
        covered += low <= 838.0 <= high
    assert 0.92 < covered / 400 < 0.98


def test_many_peaks_are_told_of_in_bounded_time_and_memory():
    v_e = np.linspace(0.05, 0.35, MOST)
    peaks = Peaks(v_e, np.full(MOST, 100.0), ideal_peak(838.0, v_e, np.full(MOST, 100.0)))
    found = identify(peaks)
    np.testing.assert_allclose([found.sqrt_k_c_m, *found.interval], 838.0, rtol=1e-9)
    assert information(peaks, found).rank >= 1
    one_more = Peaks(*(np.append(column, column[:1]) for column in (peaks.v_e, peaks.f_p, peaks.f_max)))
    with pytest.raises(InputError, match=r"holds 2,001 peaks; give 2,000 at most"):
        identify(one_more)


def test_peaks_do_not_tell_mass_from_stiffness():
    told = information(TABLE_1, identify(TABLE_1))
    assert told.std_together["m"] == told.std_together["k_c"] == float("inf")
    assert told.std_alone["sqrt_k_c_m"] < 0.02
    assert told.std_together["zeta"] > 1 and told.std_together["epsilon"] > 1
    assert told.rank == 1


@pytest.mark.parametrize("f_p", [0.0, 100.0])
@pytest.mark.parametrize("scatter", [0.0, 0.01])
def test_peaks_at_one_speed_leave_the_product_open_to_damping(f_p, scatter):
    v_e, pretension = np.full(3, 0.2), np.full(3, f_p)
    peaks = Peaks(v_e, pretension, ideal_peak(838.0, v_e, pretension) * (1 + scatter * np.array([-1, 0, 1])))
    told = information(peaks, identify(peaks))
    assert told.std_alone["sqrt_k_c_m"] < 0.02 and told.rank == 1
    assert set(told.std_together.values()) == {float("inf")}


def test_one_trial_has_no_interval():
    found = identify(Peaks(V_E[:1], F_P[:1], TABLE_1.f_max[:1]))
    assert np.isnan(found.interval).all() and found.error_left_out is None


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("f_max", "fault"),
    [
        (
            [10.0, 37, 98, 182, 220],
            "2 of 5 peaks lie below their pretension, the first of them peak 1, 10 N at 100 N",
        ),
        ([95.0, 101, 96, 97, 96], "the product that fits best is zero"),
    ],
)
def test_peaks_that_no_product_explains_are_refused(f_max, fault):
    with pytest.raises(InputError, match=fault):
        identify(Peaks(V_E, F_P, np.array(f_max)))


def test_peaks_below_the_pretension_are_refused():
    with pytest.raises(InputError, match=r"no peak exceeds its pretension"):
        identify(Peaks(V_E, F_P, np.full(5, 99.0)))
