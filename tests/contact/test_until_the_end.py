"""The force until a contact has ended, against an integration of the two bodies' own equations."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from acf_jax.contact.body import Body
from acf_jax.contact.braking import Braking, stopping_time, stopping_travel
from acf_jax.contact.carried import carried_force
from acf_jax.contact.ended import ended
from acf_jax.contact.ending import OPEN, Ending, ending_faults
from acf_jax.contact.model import forces
from acf_jax.contact.peak import ClosedForm, Simulated
from acf_jax.contact.read import of_diagnosis, of_rig
from acf_jax.contact.stop import ending_conflict, latest_stop, stop_of, stop_words
from acf_jax.designs.task import Margin, upper_forces
from acf_jax.inference.forward import unpack
from acf_jax.model import Impact, Rig
from tests.corrected import gap_model

RIG = {"m": 1.9, "d": 20.0, "k_f": 3000.0, "k_c": 6e4}
CLAMPED, HAND = Body(1 / 75e3, 0.0), Body(1 / 75e3, 1 / 0.6)


def robot(v: float, begin: float, a: float, t: float) -> tuple[float, float]:
    """How far the robot has come, and how fast it still is, that brakes from `begin` on, or stops at once."""
    if t < begin:
        return v * t, v
    since = min(t - begin, v / a)
    lost = a * since if since else 0.0
    return v * (begin + since) - lost * since / 2, v - lost if since < v / a else 0.0


def integrated(
    rig: dict[str, float], v: float, f_p: float, body: Body, ending: Ending, after: float, pulls: bool
) -> tuple[float, float]:
    """The largest contact forces until the robot has stopped and from then on, N, for `after` s.

    With the flange's and the body's positions, not the paper's x; with `pulls` a contact that would be lost holds until
    the robot has stopped.
    """
    m, d, k_f, k_c = rig.values()
    k, stop = k_c / (1 + k_c * body.compliance), stop_of(ending, v).time
    begin, a = (ending.reaction, ending.deceleration) if ending.brakes else (stop, np.inf)

    def force(t: float, s: np.ndarray) -> float:
        f = k * (s[0] - s[2]) + f_p
        return f if pulls and t < stop else max(f, 0.0)

    def rates(t: float, s: np.ndarray) -> list[float]:
        f, (base, speed) = force(t, s), robot(v, begin, a, t)
        return [s[1], (d * (speed - s[1]) + k_f * (base - s[0]) - f) / m, s[3], f * body.mobility]

    state, largest = np.array([0.0, v, 0.0, 0.0]), [0.0, 0.0]
    for low, high, part in ((0.0, begin, 0), (begin, stop, 0), (stop, stop + after, 1)):
        if high > low:
            inside = np.linspace(low, high * (1 - 1e-12), 4001)  # the end of a part belongs to it
            found = solve_ivp(
                rates,
                (low, inside[-1]),
                state,
                "DOP853",
                inside,
                rtol=1e-10,
                atol=1e-13,
                max_step=(high - low) / 500,
            )
            state = found.y[:, -1]
            largest[part] = max(largest[part], *map(force, inside, found.y.T))
    return largest[0], largest[1]


ENDINGS = [
    Ending(stop_after=0.006),
    Ending(stop_after=0.08),
    Ending(travel=0.01),
    Ending(reaction=0.02, deceleration=8.0),
]


@pytest.mark.parametrize("body", [CLAMPED, HAND], ids=["clamped", "free"])
@pytest.mark.parametrize("ending", ENDINGS)
def test_the_force_until_all_is_at_rest_is_the_integrated_one(body: Body, ending: Ending) -> None:
    v, f_p = 0.4, 15.0
    expected = max(max(integrated(RIG, v, f_p, body, ending, 0.1, pulls)) for pulls in (False, True))
    if body is CLAMPED:
        expected = max(expected, f_p + RIG["k_f"] * stop_of(ending, v).travel + RIG["d"] * v)
    model = of_rig(RIG, {})
    found, exists = forces(ended(model, ending).main.peak, model.at(v, f_p)[None], body)
    assert exists.all() and found[0] == pytest.approx(expected, rel=1e-4)
    assert found[0] >= expected * (1 - 1e-7)


@pytest.mark.parametrize("ending", [
    Ending(stop_after=0.004), Ending(travel=0.0016), Ending(reaction=0.001, deceleration=150.0)
])  # fmt: skip
def test_a_flange_goes_on_when_its_robot_stops(ending: Ending) -> None:
    """The largest force comes after the stop: the flange's own mass has to be stopped, too."""
    until, after = integrated(RIG, 0.4, 15.0, CLAMPED, ending, 0.05, False)
    model = of_rig(RIG, {})
    found, _ = forces(ended(model, ending).main.peak, model.at(0.4, 15.0)[None], CLAMPED)
    assert after > 1.2 * until and found[0] == pytest.approx(after, rel=1e-4)
    assert found[0] >= after * (1 - 1e-7)


def test_a_flange_is_followed_until_its_energy_allows_no_more() -> None:
    """Undamped against a heavy body, it bounces long after the stop; the bound that ends this never lies too low."""
    rig, body = {"m": 0.5, "d": 0.0, "k_f": 300.0, "k_c": 3e4}, Body(1 / 3e4, 1 / 40.0)
    for time in (0.004, 0.02, 0.06):
        largest = max(integrated(rig, 0.5, 2.0, body, Ending(stop_after=time), 0.6, False))
        model = of_rig(rig, {})
        found = forces(ended(model, Ending(stop_after=time)).main.peak, model.at(0.5, 2.0)[None], body)[0][0]
        assert largest * (1 - 1e-7) <= found <= 1.05 * largest


def test_a_model_that_brakes_its_robot_counts_as_the_ending_says_too() -> None:
    """Its own law has the flange brake with the robot, as if it had no mass."""
    z, ending = [*RIG.values(), 100.0, 0.0, 1e-3, 0.4, 15.0], Ending(stop_after=0.004)
    law = of_diagnosis(gap_model(("robot_deceleration",), (100.0, 0.0, 1e-3))).main.peak
    until, after = integrated(RIG, 0.4, 15.0, CLAMPED, ending, 0.05, False)
    found = law.until(jnp.asarray(z), CLAMPED, ending)
    assert bool(found.exists) and float(found.force.max()) == pytest.approx(max(until, after), rel=1e-3)
    assert float(law.through(jnp.asarray(z), CLAMPED, ending, 0.0).force.max()) < 0.9 * after


def test_a_lost_contact_hits_again_harder() -> None:
    """Between two contacts the actuator's spring has been compressed by the robot's way."""
    model = of_rig(RIG | {"d": 1.0, "k_f": 400.0}, {})
    z, end = model.at(0.4, 0.0)[None], Ending(stop_after=0.15)
    both = forces(ended(model, end).main.peak, z, CLAMPED)[0][0]
    first = forces(model.main.peak, z, CLAMPED)[0][0]
    held = float(Simulated((), np.inf).through(jnp.asarray(z[0]), CLAMPED, end, 1.0).force.max())
    assert both > 1.02 * held > 1.02 * first


def test_a_corrected_models_force_is_followed_too() -> None:
    """Without an effect it is the paper's model, whose bounds it shares."""
    law, exact = of_diagnosis(gap_model((), ())).main.peak, ClosedForm()
    z = jnp.asarray(of_diagnosis(gap_model((), ())).at(0.3, 60.0))
    for t in (0.004, 0.03, 0.3):
        a, b = (x.until(z, CLAMPED, Ending(stop_after=t)) for x in (law, exact))
        assert bool(a.exists) and float(a.force.max()) == pytest.approx(float(b.force.max()), rel=1e-3)


def test_a_robot_stops_when_and_where_the_ending_says() -> None:
    assert stop_of(OPEN, 0.3) == (np.inf, np.inf) and stop_of(OPEN, 0.0).travel == 0
    assert stop_of(Ending(stop_after=0.02), 0.3) == pytest.approx((0.02, 0.006))
    assert stop_of(Ending(travel=0.006), 0.3) == pytest.approx((0.02, 0.006))
    assert stop_of(Ending(reaction=0.01, deceleration=3.0), 0.3) == pytest.approx((0.11, 0.003 + 0.015))
    braking = Braking(jnp.asarray(3.0), jnp.asarray(0.01))
    path = jax.vmap(lambda t: 0.3 * t + braking.carrier_displacement(Rig(1, 0, 0, 1), Impact(0.3, 0), t)[0])
    assert path(jnp.array([0.01, 0.06, 0.11, 5.0])) == pytest.approx([0.003, 0.01425, 0.018, 0.018])
    for f in (stopping_time, stopping_travel):
        assert np.isfinite(float(jax.grad(lambda v, f=f: f(Ending(travel=0.01), v))(0.3)))


def test_an_ending_that_cannot_be_is_told() -> None:
    assert not ending_faults(OPEN) and not ending_faults(Ending(reaction=0.0, deceleration=1.0))
    for ending, part in (
        (Ending(stop_after=-0.1), "stop_after must be positive"),
        (Ending(stop_after=float("nan")), "stop_after must be positive"),
        (Ending(stop_after=20.0), "ms, divide by 1000"),
        (Ending(travel=36.0), "mm, divide by 1000"),
        (Ending(deceleration=2.0), "deceleration and reaction belong together"),
        (Ending(stop_after=0.1, reaction=0.1, deceleration=2.0), "give one of them"),
    ):
        (fault,) = ending_faults(ending)
        assert part in fault
    assert "--travel" in ending_faults(Ending(travel=36.0), {"travel": "--travel"})[0]


def test_a_stroke_that_ends_first_and_a_robot_that_brakes_twice_are_conflicts() -> None:
    model = of_rig(RIG, {})
    assert not ending_conflict(model, Ending(stop_after=0.02, travel=0.01), 0.4)
    too_far = Ending(stop_after=0.02, travel=0.005)
    assert "travels 8 mm" in ending_conflict(model, too_far, 0.4)
    z = np.stack([model.at(v, 60.0) for v in (0.25, 0.26)])
    assert forces(ended(model, too_far).main.peak, z, CLAMPED)[1].tolist() == [True, False]
    braking = of_diagnosis(gap_model(("robot_deceleration",), (5.0, 0.0, 1e-3)))
    assert "brakes the robot itself" in ending_conflict(braking, Ending(reaction=0.1, deceleration=2.0), 0.4)
    assert not ending_conflict(braking, Ending(stop_after=0.02), 0.4)


@pytest.mark.parametrize(
    "effect, values, moving, resting",
    [
        (None, (), 0.0, 0.0),
        ("gravity", (-30.0,), 30.0, 30.0),
        ("gravity", (30.0,), 0.0, 0.0),  # what would take from the force does not count
        ("pretension_error", (0.25, 0.0, 3.0), 15.0, 15.0),
        ("pretension_error", (-0.4, 0.0, 3.0), 0.0, 0.0),  # the rest of the 60 N comes late
        ("coulomb_friction", (20.0, 0.1, 1e-3), 26.0, 0.0),
        ("force_regulation", (50.0, 200.0), 0.0, 0.0),
        ("end_stop", (1.0, 1.0), 0.0, 0.0),  # what the stop held, the actuator presses with
        ("pad_mass", (0.5, 300.0, 0.1), 0.0, 0.0),
    ],
)
def test_what_is_carried_along_and_what_stays(
    effect: str | None, values: tuple[float, ...], moving: float, resting: float
) -> None:
    effects = () if effect is None else (effect,)
    law = Simulated(effects, np.inf)
    z = np.array([*RIG.values(), *values, 0.4, 60.0])
    rig, built = unpack(effects, z[:-2])
    carried = carried_force(rig, Impact(z[-2], z[-1]), built, 0.01, 0.4)
    assert float(carried) == pytest.approx(60 + 3000 * 0.01 + 20 * 0.4 + moving)
    assert float(law.at_rest(z, 0.01)) == pytest.approx(60 + 3000 * 0.01 + resting)


def test_what_a_braking_robot_carries_is_as_uncertain_as_its_equation_says() -> None:
    """In the program that a design asks, at every speed: compiled, a force may differ from itself in its last digit."""
    m, d, k_f, k_c, reaction, a, f_p = 1.9, 60.0, 800.0, 6e4, 0.05, 1.5, 60.0
    rig = {"m": m, "d": d, "k_f": k_f, "k_c": k_c}
    std = {"m": 0.02, "d": 0.2, "k_f": 0.3, "k_c": 0.05, "v_e": 0.005, "f_p": 0.01}
    model, v = ended(of_rig(rig, std), Ending(reaction=reaction, deceleration=a)), np.linspace(0.05, 0.6, 64)
    x = v * reaction + v**2 / (2 * a)
    parts = [0.2 * d * v, 0.3 * k_f * x, 0.005 * v * (d + k_f * (reaction + v / a)), 0.01 * f_p + 0 * v]
    expected = f_p + k_f * x + d * v + 100 * np.linalg.norm(parts, axis=0)
    upper, _, exists = upper_forces(model, np.array([model.at(one, f_p) for one in v]), Margin(100.0))
    assert exists.all()
    assert upper == pytest.approx(expected, rel=1e-9)


def test_the_latest_stop_is_on_the_right_side() -> None:
    assert latest_stop(lambda t: True) == np.inf and latest_stop(lambda t: False) is None
    found = latest_stop(lambda t: t <= 0.0211)
    assert found is not None and 0.0211 * (1 - 1e-3) < found <= 0.0211
    assert stop_words(stop_of(Ending(stop_after=0.02119), 0.7)) == "21.1 ms or 14.8 mm"
