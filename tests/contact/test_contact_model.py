"""The true contact force of every model, the body behind it, and its uncertainty, against independent truth."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array
from scipy.integrate import solve_ivp

from acf_jax.contact.body import WALL, Body
from acf_jax.contact.model import Variant, deviations, draw_forces, forces, root_of, spread
from acf_jax.contact.peak import ClosedForm, ContactPeak
from acf_jax.contact.read import of_diagnosis, of_rig
from acf_jax.effects import library
from acf_jax.predict import predict
from acf_jax.surrogate import load_surrogate
from tests.corrected import gap_model, variant

RIG = {"m": 1.9, "d": 60.0, "k_f": 800.0, "k_c": 6e4}
STD = {"m": 0.02, "d": 0.1, "k_c": 0.05, "v_e": 0.005, "f_p": 0.01}
HAND = Body(1 / 75e3, 1 / 0.6)


def recoiling(rig: dict[str, float], v: float, f_p: float, body: Body) -> float:
    """Peak contact force of flange, pad, body spring and free body mass, each with its own equation, by DOP853."""
    m, d, k_f, k_c = rig.values()
    k = 1 / (1 / k_c + body.compliance)

    def force(t: float, y: np.ndarray) -> float:
        return k * (v * t - y[0] - y[2]) + f_p

    def rates(t: float, y: np.ndarray) -> list[float]:
        f = force(t, y)
        return [y[1], (f - d * y[1] - k_f * y[0]) / m, y[3], f * body.mobility]

    t = np.linspace(0, 4 / np.sqrt(k / m), 8001)  # more than half a period of the slowest case
    solution = solve_ivp(rates, (0, t[-1]), np.zeros(4), "DOP853", t, rtol=1e-11, atol=1e-14)
    f = np.array([force(t, y) for t, y in zip(solution.t, solution.y.T, strict=True)])
    top = int(np.flatnonzero(np.diff(f) < 0)[0])
    return float(f[top])


def test_against_a_body_without_friction_is_the_two_body_solution() -> None:
    rig = RIG | {"d": 0.0, "k_f": 0.0}
    model = of_rig(rig, {})
    found = float(forces(model.main.peak, model.at(0.3, 60.0)[None], HAND)[0][0])
    assert found == pytest.approx(recoiling(rig, 0.3, 60.0, HAND), rel=1e-6)


@pytest.mark.parametrize("seed", range(20))
def test_reduced_mass_never_understates_the_force_against_a_body(seed: int) -> None:
    random = np.random.default_rng(seed)
    m, k_c = random.uniform(0.5, 8), 10 ** random.uniform(4, 5.5)
    k_body, m_body = random.uniform(1e4, 1.5e5), 10 ** random.uniform(-0.3, 1.9)
    k, mu = 1 / (1 / k_c + 1 / k_body), 1 / (1 / m + 1 / m_body)
    d, k_f = random.uniform(0, 0.5) * np.sqrt(mu * k), random.uniform(0, 0.03) * k
    rig = {"m": m, "d": d, "k_f": k_f, "k_c": k_c}
    body = Body(1 / k_body, 1 / m_body)
    v, f_p = random.uniform(0.02, 1.0), random.uniform(0, 150)
    model = of_rig(rig, {})
    found, exists = forces(model.main.peak, model.at(v, f_p)[None], body)
    assert exists[0] and found[0] >= recoiling(rig, v, f_p, body) * (1 - 1e-7)


@pytest.mark.parametrize("effects", [(), ("gravity",), ("contact_damping",), ("sensor_scale",)])
def test_corrected_model_gives_the_contact_force_that_predict_gives(effects: tuple[str, ...]) -> None:
    of_effect = {"gravity": (-8.0,), "contact_damping": (20.0, 3e4, 100.0), "sensor_scale": (0.1,)}
    values = of_effect[effects[0]] if effects else ()
    assert not effects or len(values) == len(library()[effects[0]].parameters())
    gap = gap_model(effects, values)
    model, v, f_p = of_diagnosis(gap), np.array([0.1, 0.3]), np.array([60.0, 80.0])
    found, exists = forces(model.main.peak, np.array([model.at(*x) for x in zip(v, f_p, strict=True)]), WALL)
    assert exists.all()
    assert found == pytest.approx([p.contact_peak_force for p in predict(gap, v, f_p)], rel=1e-9)


def test_a_sensors_error_leaves_the_contact_force_alone() -> None:
    plain, scaled = of_diagnosis(gap_model((), ())), of_diagnosis(gap_model(("sensor_scale",), (0.3,)))
    a, b = (forces(m.main.peak, m.at(0.2, 70.0)[None], WALL)[0][0] for m in (plain, scaled))
    assert a == pytest.approx(b, rel=1e-12)


def test_an_ambiguous_diagnosis_says_how_many_explanations_count() -> None:
    other = variant(("coulomb_friction",), (8.0,), 0.1)
    models = [gap_model(), gap_model(alternatives=(other,))]
    doubts = [of_diagnosis(m.model_copy(update={"verdict": "ambiguous"})).doubt for m in models]
    assert doubts == [
        "the diagnosis is ambiguous: the first explanation alone counts here",
        "the diagnosis is ambiguous: 2 explanations stand",
    ]
    assert of_diagnosis(models[0]).doubt == ""


def test_simulated_body_recoils_as_the_equations_say() -> None:
    rig = dict(zip(("m", "d", "k_f", "k_c"), (1.9, 60.0, 800.0, 8e4), strict=True))
    model = of_diagnosis(gap_model((), ()))
    found = float(forces(model.main.peak, model.at(0.3, 60.0)[None], HAND)[0][0])
    assert found == pytest.approx(recoiling(rig, 0.3, 60.0, HAND), rel=1e-4)


def test_a_nonlinear_pad_does_not_credit_the_bodys_stiffness() -> None:
    model = of_diagnosis(gap_model(("contact_damping",), (20.0, 3e4, 100.0)))
    z = model.at(0.3, 60.0)[None]
    stiff, soft = (forces(model.main.peak, z, Body(1 / k, 0.0))[0][0] for k in (1e9, 1e4))
    assert stiff == soft and not model.main.peak.credits_stiffness()


@pytest.mark.parametrize("which", ["rig", "diagnosis"])
def test_spread_agrees_with_draws(which: str) -> None:
    if which == "rig":
        model, draws = of_rig(RIG, STD), 20_000
    else:
        other = variant((), (), 0.3)
        model, draws = of_diagnosis(gap_model(alternatives=(other,), form_error=0.02)), 2000
    z = model.at(0.2, 70.0)
    peak, own = jax.jit(lambda z: spread(model, z, WALL))(z)
    force, exists = draw_forces(model, z, WALL, draws)
    assert exists.all()
    assert force.std() == pytest.approx(float(own.std), rel=0.06)
    assert float(own.parameters.sum() + own.form + own.explanations) == pytest.approx(float(own.std) ** 2)
    assert abs(force.mean() - float(peak.force)) < 0.4 * float(own.std)


def test_no_uncertainty_is_no_spread_with_finite_derivatives() -> None:
    model = of_rig(RIG, {})
    slope = jax.jit(jax.jacfwd(lambda z: spread(model, z, WALL)[1].std))(model.at(0.2, 70.0))
    assert np.array_equal(slope, np.zeros(6))


class Steep(ClosedForm):
    """F_P + sqrt(d), N: without a finite slope at d = 0."""

    def __call__(self, z: Array, body: Body) -> ContactPeak:
        return ContactPeak(z[-1] + jnp.sqrt(z[1]), jnp.asarray(True))


def test_a_spread_that_is_not_known_does_not_pass_for_none() -> None:
    model = eqx.tree_at(lambda m: m.main.peak, of_rig(RIG | {"d": 0.0}, STD), Steep())
    assert bool(model.main.peak(jnp.asarray(model.at(0.2, 70.0)), WALL).exists)
    assert not bool(spread(model, jnp.asarray(model.at(0.2, 70.0)), WALL)[0].exists)


def test_surrogate_is_never_below_the_exact_peak() -> None:
    exact, learned = of_rig(RIG, {}), of_rig(RIG, {}, load_surrogate())
    z = np.array([exact.at(v, f) for v in (0.02, 0.2, 0.9) for f in (10.0, 200.0)])
    a, b = forces(exact.main.peak, z, WALL)[0], forces(learned.main.peak, z, WALL)[0]
    assert (b >= a).all() and b == pytest.approx(a, rel=1e-6)
    assert not forces(learned.main.peak, exact.at(3.0, 100.0)[None], WALL)[1].any()


def test_a_contact_too_stiff_for_the_simulations_step_has_no_peak() -> None:
    law = of_diagnosis(gap_model((), ())).main.peak
    z = np.array([[1.9, 60.0, 800.0, k_c, 0.2, 70.0] for k_c in (1e7, 1e9)])
    found, exists = forces(law, z, WALL)
    exact, _ = forces(of_rig(RIG, {}).main.peak, z, WALL)
    assert exists.tolist() == [True, False]
    assert found[0] == pytest.approx(exact[0], rel=1e-3) and found[1] < 0.99 * exact[1]


def test_a_force_that_a_strong_damper_lets_rise_has_no_peak() -> None:
    """A step longer than the damper's decay took the first jump for a peak: 92 N, where the force goes on rising."""
    law = of_diagnosis(gap_model((), ())).main.peak
    z = np.array([[0.5, d, 0.0, 1e5, 0.2, 80.0] for d in (30.0, 2e4)])
    _, exists = forces(law, z, WALL)
    assert exists.tolist() == [True, False]


def test_draws_keep_what_is_known_of_small_numbers_beside_large_ones() -> None:
    """A stiffness and a time in SI units: of the covariance itself an eigenvalue decomposition keeps the stiffness."""
    scale, correlation = (
        np.array([5e7, 1e-7, 0.0]),
        np.array([[1.0, 0.6, 0.0], [0.6, 1.0, 0.0], [0.0, 0.0, 0.0]]),
    )
    root = root_of(correlation * np.outer(scale, scale))
    assert root.shape == (3, 2)
    assert root[:2] @ root[:2].T / np.outer(scale[:2], scale[:2]) == pytest.approx(correlation[:2, :2])


def test_draws_at_a_bound_are_those_of_the_law_cut_off_there() -> None:
    """Of two standard normal numbers with correlation r, the first of them above zero: |x| and r |x| + ..."""
    r = 0.95
    at_bound = Variant(
        ClosedForm(), np.zeros(2), np.array([[1.0, r], [r, 1.0]]), np.array([0.0, -np.inf]), 1.0
    )
    x, y = deviations(at_bound, 100_000, np.random.default_rng(0)).T
    assert x.min() >= 0 and x.mean() == pytest.approx(np.sqrt(2 / np.pi), rel=0.01)
    assert y.mean() == pytest.approx(r * np.sqrt(2 / np.pi), rel=0.01)
    assert y.std() == pytest.approx(np.sqrt(1 - r**2 * 2 / np.pi), rel=0.01)
    assert (y - r * x).std() == pytest.approx(np.sqrt(1 - r**2), rel=0.01)


def test_a_parameter_far_from_the_fitted_one_is_an_extrapolation() -> None:
    model = of_diagnosis(gap_model())
    z = model.at(0.2, 60.0)
    near, far = (
        z * np.r_[1, 1, 1, 1.02, np.ones(3)],
        z * np.r_[1, 1, 1, 0.5, 2.0, 1, 1],
    )  # k_c is known to 1.25 %
    assert model.notes(z) == model.notes(near) == []
    assert model.notes(far) == [
        "k_c = 4e+04 N/m was not tried, the trials' own is 8e+04: the model extrapolates",
        "gravity.force_n = -16 N was not tried, the trials' own is -8: the model extrapolates",
    ]
    assert (
        of_rig(RIG, STD, tried=model.tried).is_extrapolated(np.r_[2 * model.main.theta[:4], 0.2, 60.0]) == []
    )
