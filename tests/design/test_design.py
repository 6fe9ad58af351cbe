"""Designs against closed forms, dense grids and draws."""

from dataclasses import replace

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.stats import norm

from acf_jax.contact.body import WALL, Body
from acf_jax.contact.ending import Ending
from acf_jax.contact.model import Variant, draw_forces, forces, spread
from acf_jax.contact.peak import AbstractPeak, Branches, ClosedForm, ContactPeak
from acf_jax.contact.read import of_diagnosis, of_rig
from acf_jax.designs.landscape import landscape
from acf_jax.designs.remedy import Infeasible
from acf_jax.designs.solve import Design, design, sensitivities
from acf_jax.designs.task import make_task, upper_forces
from acf_jax.surrogate import load_surrogate
from tests.corrected import gap_model

IDEAL = {"m": 4.0, "d": 0.0, "k_f": 0.0, "k_c": 175561.0}
RIG = {"m": 4.0, "d": 60.0, "k_f": 2000.0, "k_c": 175561.0}
STD = {"m": 0.02, "k_c": 0.05, "v_e": 0.005, "f_p": 0.01}


def solved(*arguments: object, **options: int) -> Design:
    found = design(make_task(*arguments), **options)  # type: ignore[arg-type]
    assert isinstance(found, Design)
    assert found.upper <= found.task.limit
    return found


def test_highest_speed_is_the_papers_inverse() -> None:
    # d = k_F = 0: F_max^2 = F_P^2 + k_C m v^2
    found = solved(of_rig(IDEAL, {}), {"v_e": (0.0, 2.0)}, {"f_p": 100.0}, "fastest", 250.0, 0.95)
    exact = np.sqrt((250**2 - 100**2) / (IDEAL["m"] * IDEAL["k_c"]))
    assert found.z[-2] == pytest.approx(exact, rel=1e-12)
    assert found.goal_per_newton == pytest.approx(250 / (IDEAL["m"] * IDEAL["k_c"] * exact), rel=1e-10)
    assert found.at_limit and found.upper == pytest.approx(250.0, rel=1e-13)
    assert 0 <= found.slack < 1e-10 and found.residual is not None and found.residual < 1e-12


def test_highest_process_force_is_exact() -> None:
    found = solved(
        of_rig(IDEAL, {}), {"f_p": (0.0, 400.0)}, {"v_e": 0.2}, "highest_process_force", 250.0, 0.95
    )
    assert found.z[-1] == pytest.approx(np.sqrt(250**2 - IDEAL["m"] * IDEAL["k_c"] * 0.04), rel=1e-12)


@pytest.mark.parametrize(
    "goal, fixed",
    [
        ("fastest", {}),
        pytest.param("highest_process_force", {"v_e": 0.3}, marks=pytest.mark.long),
        ("widest_margin", {"v_e": 0.3}),
    ],
)
def test_no_point_of_a_dense_grid_is_better(goal: str, fixed: dict[str, float]) -> None:
    ranges = {"f_p": (80.0, 230.0), "k_c": (5e4, 3e5)} | ({} if fixed else {"v_e": (0.01, 1.0)})
    found = solved(of_rig(RIG, STD), ranges, fixed, goal, 250.0, 0.95, starts=8)
    axes = [np.linspace(low, high, 25) for low, high in ranges.values()]
    grid = np.stack([g.ravel() for g in np.meshgrid(*axes)], axis=-1)
    z = np.tile(found.z, (len(grid), 1))
    z[:, list(found.task.free)] = grid
    upper, _, exists = upper_forces(found.task.model, z, found.margin)
    allowed = z[exists & (upper <= 250.0)]
    if goal == "widest_margin":
        assert found.upper <= upper.min() * (1 + 1e-9)
    else:
        entry = {"fastest": -2, "highest_process_force": -1}[goal]
        assert allowed[:, entry].max() <= found.z[entry] * (1 + 1e-9)
    assert found.search.better == 0 and found.search.reached == found.search.starts


class Valley(AbstractPeak):
    """F = sqrt(F_P^2 + k m v^2)/cos(d - 3) + (k/k_0 - 1 - (d - 3))^2: best inside the ranges of d and k."""

    block = 64

    def __call__(self, z, body: Body) -> ContactPeak:
        m, d, _, k, v, f = z
        force = jnp.sqrt(f**2 + 1e4 * m * v**2) / jnp.cos(d - 3) + (k / 5e4 - 1 - (d - 3)) ** 2
        return ContactPeak(force, force > 0)

    def until(self, z, body: Body, ending: Ending) -> Branches:
        return self.branches(z, body)

    def credits_stiffness(self) -> bool:
        return True


@pytest.mark.parametrize("goal", ["fastest", "widest_margin"])
def test_an_optimum_within_the_ranges_is_found_to_the_last_digits(goal: str) -> None:
    model = of_rig(RIG, {})
    model = eqx.tree_at(lambda m: m.main.peak, model, Valley())
    ranges = {"d": (2.2, 4.0), "k_c": (2e4, 9e4)} | ({"v_e": (0.01, 5.0)} if goal == "fastest" else {})
    found = solved(model, ranges, {"v_e": 0.5, "f_p": 100.0}, goal, 250.0, 0.95, starts=8)
    assert found.z[[1, 3]] == pytest.approx([3.0, 5e4], rel=1e-9)  # SLSQP alone: 1e-6
    assert found.residual is not None and found.residual < 1e-11
    if goal == "fastest":
        assert found.z[-2] == pytest.approx(np.sqrt((250**2 - 100**2) / (1e4 * RIG["m"])), rel=1e-14)
        assert 0 <= found.slack < 1e-10 and found.search.reached == found.search.starts


def test_stated_probability_holds_among_draws_of_another_seed() -> None:
    found = solved(of_rig(RIG, STD), {"v_e": (0.0, 2.0)}, {"f_p": 100.0}, "fastest", 250.0, 0.9)
    force, _ = draw_forces(found.task.model, found.z, WALL, 40_000, seed=99)
    assert 0.9 - 0.003 <= (force <= 250.0).mean() <= 0.9 + 0.02
    assert 0.9 - 0.01 <= found.probability <= 0.9 + 0.02


@pytest.mark.parametrize("probability, draws", [(0.999, 256), (0.9999, 8192)])
def test_high_probabilities_hold_however_few_draws_are_asked_for(probability: float, draws: int) -> None:
    model = of_rig(IDEAL, STD)
    found = solved(model, {"v_e": (0.01, 1.0)}, {"f_p": 100.0}, "fastest", 250.0, probability, draws=draws)
    force, _ = draw_forces(model, found.z, WALL, 400_000, seed=99)
    # two standard errors to spare: in one seed of fifty a little more
    assert 0.25 < (force > 250).mean() / (1 - probability) < 1.1
    assert found.draws * (1 - probability) >= 19.9


def test_draws_that_are_too_few_are_refused_where_each_is_simulated() -> None:
    corrected = of_diagnosis(gap_model())
    task = make_task(corrected, {"v_e": (0.05, 0.35)}, {"f_p": 70.0}, "fastest", 110.0, 0.999)
    with pytest.raises(ValueError, match="needs at least 20000 draws"):
        design(task)


def test_fresh_draws_that_contradict_tighten_the_margin(monkeypatch: pytest.MonkeyPatch) -> None:
    task = make_task(of_rig(IDEAL, STD), {"v_e": (0.01, 1.0)}, {"f_p": 100.0}, "fastest", 250.0, 0.95)
    agreed = design(task)
    answers = iter([False, False, True])
    monkeypatch.setattr("acf_jax.designs.solve.is_kept", lambda *_: next(answers))
    found = design(task)
    assert isinstance(agreed, Design) and isinstance(found, Design)
    assert found.margin.factor > agreed.margin.factor and 0.9 < found.z[-2] / agreed.z[-2] < 1
    monkeypatch.setattr("acf_jax.designs.solve.is_kept", lambda *_: False)
    none = design(task)
    assert isinstance(none, Infeasible) and none.z[-2] == 0.01, "explained where it is the least loaded"


STUCK = {"m": 1.9, "d": 300.0, "k_f": 5000.0, "k_c": 6e4}  # its force soon rises without a first peak


def test_draws_without_a_peak_break_the_limit() -> None:
    model = of_rig(STUCK, {"d": 0.3, "k_f": 0.5})
    found = solved(model, {"v_e": (0.01, 1.0)}, {"f_p": 60.0}, "fastest", 500.0, 0.95)
    assert not found.at_limit and found.margin.reach > 1
    # by hand: among draws of another seed all but one in twenty have a peak there, and fewer a little beyond
    for faster, least, most in ((1.0, 0.945, 0.965), (1.5, 0.0, 0.945)):
        force, exists = draw_forces(model, found.z * np.r_[np.ones(4), faster, 1], WALL, 40_000, seed=99)
        assert least <= (exists & (force <= 500)).mean() <= most
    stuck = design(make_task(model, {"v_e": (0.5, 1.0)}, {"f_p": 60.0}, "fastest", 500.0, 0.95))
    assert isinstance(stuck, Infeasible) and stuck.has_peak and stuck.without_peak > 0.05
    for remedy in stuck.remedies:
        z = stuck.z.copy()
        z[model.names.index(remedy.name)] = remedy.needed
        force, exists = draw_forces(model, z, WALL, 40_000, seed=99)
        assert (exists & (force <= 500)).mean() >= 0.945
    assert {"v_e", "d", "f_p"} <= {r.name for r in stuck.remedies}


@pytest.mark.parametrize("more", [{}, {"k_c": (5e4, 7e4)}])
def test_what_a_low_end_without_a_peak_hides_is_found(more: dict[str, tuple[float, float]]) -> None:
    rig = {"m": 1.9, "d": 1000.0, "k_f": 0.0, "k_c": 6e4}
    ranges = {"f_p": (0.0, 400.0)} | more
    found = solved(of_rig(rig, {}), ranges, {"v_e": 0.1}, "highest_process_force", 300.0, 0.95, starts=8)
    grid = np.tile(found.z, (801, 1))
    grid[:, -1] = np.linspace(0, 400, 801)
    upper, _, exists = upper_forces(found.task.model, grid, found.margin)
    assert not exists[0] and grid[exists & (upper <= 300), -1].max() <= found.z[-1] <= 300
    assert found.at_limit and found.search.better == 0


def test_an_optimum_where_the_peak_ends_is_found_over_the_whole_box() -> None:
    # the limit is far away: what holds v_e back is the peak's end, which no derivative shows
    ranges = {"v_e": (0.01, 3.0), "f_p": (20.0, 60.0)}
    found = solved(of_rig(STUCK | {"d": 600.0}, {}), ranges, {}, "fastest", 5000.0, 0.95, starts=1)
    axes = np.meshgrid(*(np.linspace(low, high, 25) for low, high in ranges.values()))
    z = np.tile(found.z, (axes[0].size, 1))
    z[:, list(found.task.free)] = np.stack([a.ravel() for a in axes], axis=-1)
    upper, _, exists = upper_forces(found.task.model, z, found.margin)
    assert z[exists & (upper <= 5000), -2].max() <= found.z[-2] * (1 + 1e-3) and found.is_best
    assert not exists.all() and found.search.again > 0


def test_margin_is_shared_out_and_the_contact_costs_most() -> None:
    found = solved(of_rig(RIG, STD), {"v_e": (0.0, 2.0)}, {"f_p": 100.0}, "fastest", 250.0, 0.95)
    assert sum(row.margin for row in found.sensitivities) == pytest.approx(found.upper - found.force)
    assert found.sensitivities[0].name == "k_c"
    # sqrt(k_C m) is what the peak knows: 1 % of m and of k_C cost the same for small d and k_F
    per_percent = {row.name: row.per_percent for row in found.sensitivities}
    assert per_percent["m"] == pytest.approx(per_percent["k_c"], rel=0.01)


def test_what_the_model_leaves_open_costs_newtons_too() -> None:
    plain = of_rig(RIG, STD)
    other = Variant(ClosedForm(), plain.main.theta * [1.2, 1, 1, 1], np.zeros((4, 4)), plain.main.low, 0.25)
    model = replace(plain, others=(other,), form_error=0.02)
    z = model.at(0.2, 70.0)
    peak, own = spread(model, jnp.asarray(z), WALL)
    margins = {row.name: row.margin for row in sensitivities(model, z, own, margin=10.0)}
    assert sum(margins.values()) == pytest.approx(10.0)
    # independently: 2 % of the force, and weights of 0.8 and 0.2 one gap apart
    heavier, _ = forces(ClosedForm(), (z * [1.2, 1, 1, 1, 1, 1])[None], WALL)
    gap, newtons = float(heavier[0] - peak.force), 10.0 / float(own.std) ** 2
    assert margins["form of the model"] == pytest.approx((0.02 * float(peak.force)) ** 2 * newtons)
    assert margins["choice of explanation"] == pytest.approx(0.8 * 0.2 * gap**2 * newtons)


def test_infeasible_names_the_least_force_and_remedies_that_work() -> None:
    model = of_rig(RIG, STD)
    ranges = {"v_e": (0.5, 1.0), "f_p": (80.0, 120.0)}
    found = design(make_task(model, ranges, {}, "fastest", 250.0, 0.95), starts=8)
    assert isinstance(found, Infeasible)
    assert found.z[-2:] == pytest.approx([0.5, 80.0]) and found.upper > 250
    remedies = {r.name: r.needed for r in found.remedies}
    assert {"limit", "v_e", "k_c", "m"} <= set(remedies) and "f_p" not in remedies
    better = {"v_e": (remedies["v_e"], 1.0), "f_p": (80.0, 120.0)}
    again = design(make_task(model, better, {}, "fastest", 250.0 * (1 + 1e-3), 0.95), starts=8)
    assert isinstance(again, Design)


def test_a_goal_at_its_ranges_end_leaves_the_widest_margin() -> None:
    ranges = {"v_e": (0.05, 0.1), "k_c": (5e4, 3e5)}
    found = solved(of_rig(RIG, STD), ranges, {"f_p": 80.0}, "fastest", 250.0, 0.95, starts=8)
    assert found.z[-2] == 0.1 and found.z[3] == 5e4 and not found.at_limit


def test_a_model_without_a_peak_is_not_feasible() -> None:
    stuck = of_rig({"m": 4.0, "d": 1200.0, "k_f": 9000.0, "k_c": 2e4}, {})
    task = make_task(stuck, {"v_e": (0.5, 1.0), "f_p": (0.0, 20.0)}, {}, "fastest", 5000.0, 0.95)
    found = design(task, starts=8)
    assert isinstance(found, Infeasible) and not found.has_peak
    assert {r.name: r.needed > r.now for r in found.remedies} == {"d": False, "k_c": True}


@pytest.mark.long
def test_corrected_model_and_surrogate_are_designed_with_alike() -> None:
    corrected = of_diagnosis(gap_model())
    found = solved(corrected, {"v_e": (0.05, 0.35)}, {"f_p": 70.0}, "fastest", 110.0, 0.95, draws=400)
    force, _ = draw_forces(corrected, found.z, WALL, 2000, seed=5)
    assert (force <= 110.0).mean() > 0.93
    learned, exact = of_rig(RIG, {}, load_surrogate()), of_rig(RIG, {})
    v = solved(learned, {"v_e": (0.02, 1.0)}, {"f_p": 100.0}, "fastest", 250.0, 0.95).z[-2]
    # never faster than by the exact model, and slower by a millionth at most
    at, beyond = forces(exact.main.peak, np.array([exact.at(x, 100.0) for x in (v, v / (1 - 1e-6))]), WALL)[0]
    assert at <= 250.0 <= beyond


def test_landscape_shows_the_limit_where_the_design_is() -> None:
    found = solved(
        of_rig(RIG, STD), {"v_e": (0.05, 1.0), "f_p": (80.0, 120.0)}, {}, "fastest", 250.0, 0.95, starts=4
    )
    space = landscape(found, points=9)
    assert space.names == ("v_e", "f_p") and space.upper.shape == (9, 9)
    assert space.point == (found.z[-2], found.z[-1])
    assert (np.diff(space.upper, axis=1) > 0).all()


class Forked(AbstractPeak):
    """The larger of F_P + 100 v m/4 and F_P + 90 v d/60, N."""

    block = 64

    def __call__(self, z, body: Body) -> ContactPeak:
        return ContactPeak(self.branches(z, body).force.max(), jnp.asarray(True))

    def branches(self, z, body: Body) -> Branches:
        m, d, _, _, v, f = z
        return Branches(f + v * jnp.stack([25.0 * m, 1.5 * d]), jnp.asarray(True))

    def until(self, z, body: Body, ending: Ending) -> Branches:
        return self.branches(z, body)

    def credits_stiffness(self) -> bool:
        return True


def test_of_several_branches_each_margin_counts_by_its_own_spread() -> None:
    """One deviation from the best estimate the first is larger, two deviations from it the second."""
    model = eqx.tree_at(lambda m: m.main.peak, of_rig(RIG, {"m": 0.02, "d": 0.1}), Forked())
    found = solved(model, {"v_e": (0.0, 2.0)}, {"f_p": 10.0}, "fastest", 110.0, 0.95)
    # by hand: P(F <= 110) = Phi((100/v - 100)/2) Phi((100/v - 90)/9)
    share = norm.cdf((100 / found.z[-2] - 100) / 2) * norm.cdf((100 / found.z[-2] - 90) / 9)
    assert 0.95 <= share <= 0.96
