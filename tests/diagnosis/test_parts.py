"""The parts of a diagnosis against what they should be, each without a data set."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array
from scipy.stats import norm

from acf_jax.dataset import Noise
from acf_jax.diagnosis.document import _explanations
from acf_jax.diagnosis.experiment import error_probability
from acf_jax.diagnosis.fit import BEYOND, Fit
from acf_jax.diagnosis.forward import Forces, Grid, forward, reach_of
from acf_jax.diagnosis.model_file import variant
from acf_jax.diagnosis.ports import ports
from acf_jax.diagnosis.ports._continued import continued
from acf_jax.diagnosis.ports.sensor import UnknownSensor
from acf_jax.diagnosis.predict import Prediction, predict
from acf_jax.diagnosis.sample import at_times, first_loss, peak_of, taps
from acf_jax.diagnosis.score import (
    HIGHEST,
    UNKNOWN,
    WEIGHTS,
    Evidence,
    Scored,
    Weights,
    credible_set,
    doubt,
    explanations,
    log_scores,
    of_each_fit,
    probabilities,
)
from acf_jax.diagnosis.space import (
    Explanation,
    Measures,
    begin,
    component_of,
    coordinates,
    every_effect,
    starts,
)
from acf_jax.diagnosis.whiten import Whitener
from tests.corrected import gap_model
from tests.corrected import variant as made
from tests.diagnosis.imagined import RIG
from tests.typical import typical


@pytest.mark.parametrize("name", sorted(every_effect()))
def test_coordinates_invert_and_starts_lie_within_the_bounds(name: str) -> None:
    space = coordinates(RIG, (name,), (0.1, 1e-4))
    for start in starts(name):
        theta = begin(RIG.values, start)
        u = space.coordinate(theta)
        np.testing.assert_allclose(space.value(u), theta, rtol=1e-12, atol=1e-15)
        assert (u >= space.low).all() and (u <= space.high).all()
        step = 1e-6
        slope = (space.value(u + step) - space.value(u - step)) / (2 * step)
        np.testing.assert_allclose(space.slope(u), slope, rtol=1e-6)


def test_some_starts_are_multiples_of_what_is_typical_of_rig_and_trials() -> None:
    usual, larger = starts("unknown_sensor"), starts("unknown_sensor", Measures(force=600.0))
    level = [p.name for p in every_effect()["unknown_sensor"].parameters()].index("level_n")
    assert [start[level] for start in larger] == pytest.approx([3 * start[level] for start in usual])
    assert [start[:level] for start in larger] == [start[:level] for start in usual]
    highest = every_effect()["unknown_sensor"].parameters()[level].high
    assert max(start[level] for start in starts("unknown_sensor", Measures(force=1e9))) == highest


def test_interpolation_is_exact_for_cubics() -> None:
    h = 0.1
    grid = h * np.arange(30)
    times = np.array([0.0, 0.033, 0.5, 1.234, 2.7])
    cubic = np.polynomial.Polynomial([1.0, -2.0, 0.5, 0.3])
    held = np.ones(len(grid))
    np.testing.assert_allclose(at_times(cubic(grid), times, h, held), cubic(times), rtol=1e-12)
    near, _, rate = taps(times, h, held)
    np.testing.assert_allclose(
        (cubic(grid)[near] * rate).sum(0), cubic.deriv()(times), rtol=1e-10, atol=1e-10
    )


@pytest.mark.parametrize("lost", [0.1, 0.1003, 0.1011, 0.1019])  # s, between points of the grid or on one
def test_interpolation_ends_where_contact_is_lost(lost: float) -> None:
    h = 2e-3
    grid, times = h * np.arange(60), np.linspace(0.08, 0.115, 200)

    def force(t: np.ndarray) -> np.ndarray:
        return np.maximum(100 * np.sin(t * np.pi / lost), 0.0) * (t < lost)

    found = at_times(force(grid), times, h, force(grid))
    np.testing.assert_allclose(found, force(times), atol=1e-3)
    reading = at_times(force(grid) + 5.0, times, h, force(grid))  # of a sensor with an offset
    np.testing.assert_allclose(reading, force(times) + 5.0, atol=1e-3)


@pytest.mark.parametrize("steps", [0.05, 0.5, 1.0, 1.9])  # of the grid, from the last sample to the loss
def test_a_loss_of_contact_right_behind_the_last_sample_is_told(steps: float) -> None:
    h, end = 2e-3, 0.0813
    lost = end + steps * h
    grid, times = h * np.arange(int(np.ceil(end / h)) + BEYOND + 1), np.linspace(0.06, end, 50)

    def force(t: np.ndarray) -> np.ndarray:
        return np.maximum(100 * np.sin(t * np.pi / lost), 0.0) * (t < lost)

    np.testing.assert_allclose(at_times(force(grid), times, h, force(grid)), force(times), atol=1e-3)


def test_the_peak_lies_within_the_impact_phase() -> None:
    time = np.arange(200) * 1e-3
    force = 100 * np.sin(time * np.pi / 0.1)  # contact is lost after 0.1 s
    force[150:] = 500.0
    peak, when = peak_of(force, 1e-3, force)
    assert peak == pytest.approx(100.0, rel=1e-6)
    assert when == pytest.approx(0.05, abs=1e-6)


@pytest.mark.parametrize(
    "noise", [Noise(0.7), Noise(1.3, share=0.4, correlation_time=8e-4), Noise(0.5, 1.0, 2e-3)]
)
def test_whitening_leaves_independent_noise_of_unit_size(noise: Noise) -> None:
    """At times even and uneven, the second of two trials being shorter than the first."""
    even = 1.25e-4 * np.arange(90)
    uneven = np.cumsum(np.random.default_rng(0).uniform(0.3, 2.0, 90)) * 1.25e-4
    used = np.arange(90) < np.array([[90], [60]])
    noises = [np.linalg.cholesky(noise.covariance(times)) for times in (even, uneven)]
    padded = np.where(used, np.stack([even, uneven]), 0.0)
    white = Whitener(padded, used, noise)(np.stack(noises).transpose(0, 2, 1))
    np.testing.assert_allclose(white[0].T @ white[0], np.eye(90), atol=1e-9)
    np.testing.assert_allclose(white[1, :, :60].T @ white[1, :, :60], np.eye(60), atol=1e-9)
    assert not white[1, :, 60:].any()


def test_error_probability_against_sampling() -> None:
    p, q, d = 0.7, 0.2, 1.5
    rng = np.random.default_rng(0)
    n = 400_000
    first = rng.random(n) < p / (p + q)
    signal = rng.normal(size=n) + np.where(first, 0.0, d)
    says_first = np.log(p / q) - d * signal + d**2 / 2 > 0
    assert error_probability(p, q, d) == pytest.approx((says_first != first).mean(), abs=3e-3)
    assert error_probability(0.5, 0.5, d) == pytest.approx(norm.sf(d / 2))
    assert error_probability(p, q, 0.0) == pytest.approx(q / (p + q))


def _probabilities(chi_square: tuple[float, ...]) -> np.ndarray:
    names = [(), ("gravity",), ("coulomb_friction",), ("unknown_actuator",)]
    rest = (0.0,) * 4
    return probabilities([Evidence(e, x, rest) for e, x in zip(names, chi_square, strict=True)], 1000)


def test_probabilities_follow_the_evidence_and_are_never_certain() -> None:
    same = _probabilities((1000.0, 1000.0, 1000.0, 1000.0))
    assert same.argmax() == 0 and same.sum() == pytest.approx(1.0)
    clear = _probabilities((10000.0, 1000.0, 1400.0, 998.0))
    assert clear.argmax() == 1
    assert clear.max() <= HIGHEST + 1e-12
    outside = _probabilities((100000.0, 40000.0, 60000.0, 1000.0))
    assert outside.argmax() == 3


def test_beside_a_form_that_leaves_only_noise_even_a_large_gap_hides_no_difference() -> None:
    def odds(*left: float) -> float:
        one, other = _probabilities((1e6, *left, 1e6))[1:3]
        return float(one / other)

    assert odds(1000.0, 1010.0) / odds(1000.0, 1000.0) == pytest.approx(np.exp(0.5 * WEIGHTS.exact * 10.0))
    assert odds(3000.0, 3010.0) / odds(3000.0, 3000.0) < 1.1  # neither form is exact


def test_a_pair_that_leaves_only_noise_stands_before_a_law_that_leaves_much_more() -> None:
    """However small a share that is of the gap."""
    names: list[Explanation] = [(), ("gravity",), ("pad_mass", "sensor_lag")]

    def odds(left: float) -> float:
        chi_square = (5e6, left, 1000.0)
        p = probabilities([Evidence(e, x, (0.0,) * 4) for e, x in zip(names, chi_square, strict=True)], 1000)
        return float(p[2] / p[1])

    assert odds(1000.0) < 0.1
    assert odds(32000.0) > 10.0


def test_a_form_that_strains_the_rig_is_not_exact() -> None:
    """As in a blind run: a pair that fits far within the noise only because the mass is 15 deviations off."""
    names: list[Explanation] = [(), ("gravity", "sensor_lag"), ("pad_mass", "sensor_lag")]

    def odds(strain: float) -> float:
        rows = zip(names, (80000.0, 1000.0, 760.0), ((0.0,), (0.0,), (strain,)), strict=True)
        p = probabilities([Evidence(*row) for row in rows], 1000)
        return float(p[1] / p[2])

    assert odds(240.0) > 10.0
    assert odds(0.0) < 0.1


def test_contact_is_lost_only_after_there_was_some() -> None:
    contact = np.array(
        [[0.0, 0.0, 3.0, 5.0, 0.0, 0.0], [2.0, 3.0, 4.0, 3.0, 2.0, 1.0], [1.0, 0.0, 1.0, 2.0, 1.0, 0.0]]
    )
    np.testing.assert_array_equal(first_loss(contact), [4, 6, 1])
    assert first_loss(np.zeros(6)) == 6


def port_shares(strain: float = 0.0, weights: Weights = WEIGHTS, **chi_square: float) -> dict[str, float]:
    """Of an unknown cause, by what each port leaves; its rig strained at the actuator's."""
    names = [(), *((name,) for name in ports())]
    left = (20000.0, *(chi_square[component_of(name)] for name in ports()))
    strains = [(strain if "unknown_actuator" in name else 0.0,) * 4 for name in names]
    p = probabilities([Evidence(*row) for row in zip(names, left, strains, strict=True)], 1000, weights)[1:]
    return {component_of(name): float(value) for name, value in zip(ports(), p / p.sum(), strict=True)}


def test_the_port_stays_open_where_none_fits() -> None:
    alike = replace(WEIGHTS, in_series=0.0)
    near = port_shares(weights=alike, actuator=1000.0, contact=2000.0, robot=2000.0, sensor=2000.0)
    far = port_shares(weights=alike, actuator=11000.0, contact=12000.0, robot=12000.0, sensor=12000.0)
    assert near["actuator"] > 0.9
    assert far["actuator"] < 0.8


def test_ports_that_all_forces_pass_and_strained_ones_have_to_fit_better() -> None:
    even = port_shares(actuator=1000.0, contact=1000.0, robot=1000.0, sensor=1000.0)
    assert even["actuator"] == even["contact"]
    assert even["robot"] == even["sensor"] == pytest.approx(even["contact"] * np.exp(-WEIGHTS.in_series))
    strained = port_shares(20.0, actuator=1000.0, contact=1000.0, robot=1000.0, sensor=1000.0)
    assert strained["actuator"] < 0.1 * strained["contact"]


def test_noise_whose_colour_is_hardly_known_is_no_unknown_cause() -> None:
    evidence = [Evidence(e, 1350.0, (0.0,) * 4) for e in ((), ("unknown_robot",))]
    known, guessed = (probabilities(evidence, 1000, noise_doubt=doubt)[0] for doubt in (0.0, 0.2))
    assert guessed > 0.99 and known < 0.01
    assert Noise(1.0, 0.9, 1e-3, samples=200).doubt == pytest.approx(0.2)
    assert Noise(1.0, samples=20).doubt == 0.0


def test_ports_and_further_effects_cost_more_where_single_effects_pay_for_their_freedom() -> None:
    names: list[Explanation] = [(), ("gravity",), ("gravity", "sensor_lag"), ("unknown_robot",)]

    def odds(volume: float | None) -> np.ndarray:
        rows = zip(names, (1050.0, 1010.0, 1005.0, 1000.0), strict=True)
        evidence = [Evidence(e, x, (0.0,) * 4, volume if e == ("gravity",) else None) for e, x in rows]
        p = np.exp(log_scores(evidence, 1000))
        return np.asarray(p[2:4] / p[0])

    np.testing.assert_allclose(odds(-3.0) / odds(None), np.exp(-WEIGHTS.small))


def test_what_a_fit_owes_to_what_it_has_seen_counts_but_where_freedom_has_its_price() -> None:
    names: list[Explanation] = [(), ("gravity",), ("gravity", "sensor_lag"), ("unknown_robot",)]

    def odds(owed: float, volume: float | None = None) -> float:
        rows = zip(names, (1100.0, 1040.0, 1012.0, 1000.0), (0.0, 0.0, 10.0, 10.0 + owed), strict=True)
        evidence = [
            Evidence(e, x, (0.0,) * 4, volume if e == ("gravity",) else None, more) for e, x, more in rows
        ]
        score = log_scores(evidence, 1000)
        return float(np.exp(score[2] - score[3]))

    assert odds(0.0) < 0.5 and odds(30.0) > 20.0
    assert odds(30.0, volume=-3.0) == odds(0.0, volume=-3.0)


def test_beside_a_free_curve_that_leaves_only_noise_a_law_is_not_excused_by_a_large_gap() -> None:
    """A tenth of the half chi-square counts at least, however small a share of the gap it is."""

    def odds(left: float) -> float:
        evidence = [
            Evidence(e, x, (0.0,) * 4)
            for e, x in (((), 1e6), (("gravity",), left), (("unknown_robot",), 1000.0))
        ]
        score = log_scores(evidence, 1000)
        return float(score[1] - score[2])

    assert odds(1000.0) - odds(1400.0) == pytest.approx(0.5 * WEIGHTS.exact_of_all * 400.0)


def test_an_effect_that_fits_any_noise_must_fit_better() -> None:
    plain, eager = ("sensor_lag",), ("sensor_resonance",)
    rest = (0.0,) * 4
    even = [Evidence(e, x, rest) for e, x in (((), 5000.0), (plain, 1000.0), (eager, 1000.0))]
    p = probabilities(even, 1000)
    assert p[2] / p[1] == pytest.approx(np.exp(-WEIGHTS.noise))


def test_the_credible_set_is_the_smallest_that_holds_95_percent() -> None:
    scored = [Scored(("a",), 0.6), Scored(("b",), 0.36), Scored((), 0.04)]
    assert credible_set(scored) == [("a",), ("b",)]


def test_a_reading_may_have_a_kink() -> None:
    clipped = UnknownSensor(*map(jnp.asarray, typical("unknown_sensor", beyond=-1.0, level_n=150.0)))
    for force, reading in ((100.0, 100.0), (150.0, 150.0), (400.0, 150.0)):
        f = jnp.asarray(force)
        assert clipped.sense((f, f), jnp.asarray(1e-4), jnp.zeros(4))[1] == pytest.approx(reading)


def test_where_a_free_curve_goes_astray_the_recalibrated_model_predicts() -> None:
    model = gap_model(("unknown_contact",), tuple(typical("unknown_contact")))
    near, far = np.array([0.1, 20.0]), np.array([60.0, 60.0])
    held, gone = predict(model, near, far)
    assert gone.diverges and not held.diverges
    instead = predict(model, near, far, "recalibrated")[1]
    assert not instead.diverges
    assert gone.peak_force == instead.peak_force
    assert np.array_equal(gone.contact_force, instead.contact_force)


def test_what_a_free_curve_does_after_contact_is_lost_says_nothing() -> None:
    # a push that grows with the cube of the stroke breaks the simulation down when the flange has left the part
    model = gap_model(("unknown_actuator",), tuple(typical("unknown_actuator", stroke_3_n=300.0)))
    (away,) = predict(model, np.array([0.1]), np.array([60.0]))
    assert not away.diverges
    assert away.time[-1] < 0.02
    assert np.isfinite([*away.force, *away.contact_force, away.peak_force_std]).all()


def test_the_force_up_to_which_a_free_curve_was_tried_is_of_the_first_contact(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    contact = np.array([[0.0, 60.0, 120.0, -1.0, 1e9, np.nan], [0.0, 40.0, 50.0, 45.0, 30.0, 20.0]])
    monkeypatch.setattr("acf_jax.diagnosis.forward.forward", lambda *_: Forces(contact, contact[:, None]))
    some, grid = np.zeros(2), Grid(1e-4, 5)
    assert reach_of(("unknown_contact",), some, some, some, grid) == 120.0
    assert reach_of(("gravity",), some, some, some, grid) == np.inf


def test_the_contact_force_of_a_sensor_with_wrong_gain_is_as_uncertain_as_the_rig() -> None:
    """What is known is the reading (1 + e) F: of the contact force that says as little as of the gain e."""
    model = gap_model(("sensor_scale",), (0.2,))
    v, where = model.corrected, (np.array([0.3]), np.array([60.0]))
    step = np.array([0.0, 0.0, 0.0, 8e3, -0.06])  # a stiffer contact that is read as less

    def with_rig(**changed: object) -> Prediction:
        return predict(model.model_copy(update={"corrected": v.model_copy(update=changed)}), *where)[0]

    here = with_rig(covariance=tuple(map(tuple, np.outer(step, step).tolist())))
    there = with_rig(theta=tuple(np.array(v.theta) + step))
    assert here.contact_peak_force_std == pytest.approx(
        there.contact_peak_force - here.contact_peak_force, rel=0.1
    )
    assert here.peak_force_std < 0.5 * here.contact_peak_force_std


def test_an_alternative_that_breaks_down_adds_no_spread() -> None:
    broken = made(("unknown_contact",), tuple(typical("unknown_contact")), 0.4)
    near, far = np.array([0.1, 20.0]), np.array([60.0, 60.0])
    alone, beside = predict(gap_model(), near, far), predict(gap_model(alternatives=(broken,)), near, far)
    assert beside[1].peak_force_std == pytest.approx(alone[1].peak_force_std)
    assert beside[0].peak_force_std > 1.1 * alone[0].peak_force_std


@pytest.mark.parametrize("delay", [1.5e-4, -1.5e-4])
def test_a_delay_of_the_reading_leaves_the_contact_force(delay: float) -> None:
    punctual = gap_model(("sensor_lag",), (5e-4, 0.8))
    late = punctual.model_copy(update={"corrected": punctual.corrected.model_copy(update={"delay_s": delay})})
    one, other = (predict(m, np.array([0.2]), np.array([60.0]), sample_rate=2e5)[0] for m in (punctual, late))
    inner = (one.time > 2e-4) & (one.time < one.time[-1] - 2e-4)
    expected = np.interp(one.time[inner] - delay, one.time, one.force)
    assert other.force[inner] == pytest.approx(expected, abs=0.01)
    assert other.force[0] == one.force[0] < 1.0  # at first contact a lagging sensor reads nothing yet
    assert other.contact_force == pytest.approx(one.contact_force)
    assert other.peak_time == pytest.approx(one.peak_time + delay, abs=5e-6)


def test_an_early_reading_ends_with_the_simulation() -> None:
    def early_by(delay: float) -> Prediction:
        model = gap_model(("sensor_lag",), (5e-4, 0.8))
        m, _, _, *more = model.corrected.theta
        # so stiff and damped a flange that contact is held to the end
        held = {"theta": (m, 2000.0, 8e4, *more), "delay_s": -delay}
        corrected = model.corrected.model_copy(update=held)
        return predict(model.model_copy(update={"corrected": corrected}), np.array([0.2]), np.array([60.0]))[
            0
        ]

    punctual, early = early_by(0.0), early_by(0.01)
    assert early.time[-1] == punctual.time[-1] == pytest.approx(0.06)
    assert early.force.max() <= punctual.force.max() * 1.01


@pytest.mark.parametrize(("effect", "delay"), [("sensor_lag", 2e-5), ("sensor_scale", 0.0), ("gravity", 0.0)])
def test_a_delay_of_all_triggers_belongs_to_a_lagging_sensor_alone(effect: str, delay: float) -> None:
    theta = np.array([2.0, 60.0, 800.0, 3e5, *(p.scale for p in every_effect()[effect].parameters())])
    common = np.array([0.1, 2e-5])
    fitted = SimpleNamespace(
        explanation=(effect,), physical=theta, common=common, covariance=np.eye(len(theta) + len(common))
    )
    written = variant(cast(Fit, fitted), 0.5)
    assert written.delay_s == delay
    assert written.theta == tuple(theta)


def test_a_free_curve_goes_on_straight_beyond_the_forces_that_were_tried() -> None:
    def curve(u: Array) -> Array:
        return 1e-3 * u**2

    u, reach = jnp.array([50.0, 100.0, 150.0, 200.0]), jnp.asarray(100.0)
    rising = continued(curve, u, reach, (0.2,), 5.0)
    assert rising[:2] == pytest.approx(np.array([2.5, 10.0]))
    assert rising[2:] == pytest.approx([10.0 + 0.18 * 50.0, 10.0 + 0.18 * 100.0])
    assert continued(curve, u, reach, (0.2,), 0.1)[3] == pytest.approx(20.0)
    falling = continued(lambda u: -10 * curve(u), u, reach, (0.2, 0.01), 5.0)
    assert falling[3] == pytest.approx(-100.0 - 100.0)
    assert continued(curve, u, jnp.asarray(jnp.inf), (0.2,), 5.0) == pytest.approx(curve(u))


@pytest.mark.parametrize("port", ["unknown_contact", "unknown_sensor"])
def test_the_reach_of_a_free_curve_changes_nothing_below_it(port: str) -> None:
    theta = np.array([2.0, 60.0, 800.0, 3e5, *(p.scale for p in ports()[port].parameters())])
    grid = Grid(1e-4, 100)
    v_e, f_p = np.array([0.05, 0.3]), np.array([60.0, 60.0])
    reach = reach_of((port,), theta, v_e[:1], f_p[:1], grid)
    free, held = (forward((port,), theta, v_e, f_p, grid, r).sensed for r in (np.inf, reach))
    assert held[0] == pytest.approx(free[0], rel=1e-12)
    assert abs(held[1] - free[1]).max() > 1.0
    assert reach_of(("gravity",), np.append(theta[:4], 5.0), v_e, f_p, grid) == np.inf


def test_fits_are_as_probable_as_their_explanations_are_said_to_be() -> None:
    names = [(), ("gravity",), ("unknown_actuator",), ("unknown_robot",)]
    fits = cast(list[Fit], [SimpleNamespace(explanation=name) for name in names])
    before = np.array([0.0, 0.98, 0.015, 0.005])
    stated = doubt(explanations(fits, before), 0.1)
    p = of_each_fit(fits, before, stated)
    assert dict(zip(names, p, strict=True))[("gravity",)] == pytest.approx(0.245)
    assert p[2:] == pytest.approx([0.755 * 0.75, 0.755 * 0.25])


def test_no_listed_probability_is_certain_once_the_small_ones_are_left_out() -> None:
    small = [Scored((name,), 8e-5) for name in list(every_effect())[1:13]]
    scored = [Scored((next(iter(every_effect())),), HIGHEST), Scored((), 0.0), Scored(UNKNOWN, 0.0), *small]
    listed = _explanations(SimpleNamespace(scored=scored))  # type: ignore[arg-type]
    p = [row["probability"] for row in listed]
    assert len(p) == 3 and sum(p) == pytest.approx(1.0)
    assert max(p) == pytest.approx(HIGHEST)


def test_no_explanation_is_certain_nor_are_the_ports_together() -> None:
    fits = [cast(Fit, SimpleNamespace(explanation=e)) for e in [(), *((name,) for name in ports())]]
    scored = explanations(fits, np.array([0.0004, 0.9, 0.0496, 0.03, 0.02]))
    assert [s.explanation for s in scored] == [("unknown",), ()]
    assert scored[0].probability == pytest.approx(HIGHEST)
    assert sum(s.probability for s in scored) == pytest.approx(1.0)
    doubted = doubt([Scored(("gravity",), 0.99), Scored((), 0.01)], 0.0)
    assert doubted[0].explanation == ("unknown",) and doubted[0].probability < 0.995
