"""What the free curves can imitate: laws of the library, as if these were withheld."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from acf_jax.inference.forward import Forces, Grid, forward, reach_of
from acf_jax.inference.free_curves import free_curves
from acf_jax.inference.free_curves._common import continued
from acf_jax.inference.free_curves.unknown_robot import _sine
from acf_jax.inference.free_curves.unknown_sensor import UnknownSensor
from tests.typical import typical

RIG = [2.0, 60.0, 800.0, 3e5]
GRID = Grid(5e-5, 400)
V_E, F_P = np.array([0.05, 0.3]), np.array([60.0, 40.0])
HZ = 60.0
OMEGA = 2 * np.pi * HZ


def sensed(name: str, **values: float) -> np.ndarray:
    """The readings, N, with an effect or free curve whose strengths are zero and shapes typical where not given."""
    return forward((name,), np.array([*RIG, *typical(name, **values)]), V_E, F_P, GRID).sensed


def test_the_sine_of_a_ripple_is_one() -> None:
    """Over what a ripple of 1 kHz passes in 0.3 s, with its slope."""
    x = np.linspace(-2000.0, 2000.0, 40_001)
    np.testing.assert_allclose(_sine(jnp.asarray(x)), np.sin(x), atol=1e-9)
    np.testing.assert_allclose(jax.vmap(jax.grad(_sine))(x), np.cos(x), atol=1e-9)


@pytest.mark.parametrize(
    ("law", "curve"),
    [
        (
            ("sensor_lag", {"time_constant_s": 1 / OMEGA, "damping_ratio": 0.8}),
            ("unknown_sensor", {"lagging": 1.0, "frequency_hz": HZ, "damping_ratio": 0.8}),
        ),
        (
            ("sensor_resonance", {"share": 0.6, "frequency_hz": 300.0, "damping_ratio": 0.05}),
            ("unknown_sensor", {"lagging": 0.6, "frequency_hz": 300.0, "damping_ratio": 0.05}),
        ),
        (
            ("pad_mass", {"mass_kg": 0.3, "frequency_hz": 150.0, "damping_ratio": 0.05}),
            ("unknown_contact", {"pad_kg": 0.3, "frequency_hz": 150.0, "damping_ratio": 0.05}),
        ),
        (
            ("end_stop", {"share": 0.7, "opposing_share": 0.4}),
            ("unknown_actuator", {"held_share": 0.7, "pretension_share": -0.4}),
        ),
        (
            ("robot_compliance", {"inverse_mass_per_kg": 0.05, "frequency_hz": HZ, "damping_ratio": 0.2}),
            (
                "unknown_robot",
                {"yield_m": 100 * 0.05 / OMEGA**2, "frequency_hz": HZ, "damping_ratio": 0.2},
            ),
        ),
    ],
    ids=lambda side: side[0],
)
def test_a_free_curve_imitates_a_law_at_its_component(
    law: tuple[str, dict[str, float]], curve: tuple[str, dict[str, float]]
) -> None:
    by_law, by_curve = sensed(law[0], **law[1]), sensed(curve[0], **curve[1])
    assert np.abs(by_law - sensed(curve[0])).max() > 1.0  # the law does something
    np.testing.assert_allclose(by_curve, by_law, atol=1e-6)


def test_a_pad_that_flows_at_once_carries_no_more_than_its_level() -> None:
    flowing = sensed("unknown_contact", flow_per_s=5e3, level_n=100.0, hardening=0.01)
    assert sensed("unknown_contact").max() > 200.0
    assert 99.0 < flowing.max() < 125.0


def test_a_robot_gives_way_freely_within_its_play() -> None:
    """M u'' = -F_C until it has moved across the gap, then the drive holds it."""
    mass, stiffness, gap = 6.0, 6e6, 3e-5
    undamped = {"damping_ratio": 1e-9}
    robot = {"yield_m": 100 / stiffness, "frequency_hz": np.sqrt(stiffness / mass) / (2 * np.pi), **undamped}
    free, loose, tight = (
        sensed("unknown_robot", **robot, play_n=stiffness * play) for play in (1.0, gap, 0.0)
    )
    soft = {"yield_m": 100 / (mass * OMEGA**2), "frequency_hz": HZ, "play_n": 1e9, **undamped}
    np.testing.assert_allclose(free, sensed("unknown_robot", **soft), atol=1e-6)  # the mass alone counts
    crossed = int((np.abs(loose - free).max(0) > 1e-6).argmax())
    assert crossed > 10 and np.abs(loose - tight)[:, :crossed].max() > 1.0
    assert loose.max() > free.max() + 1.0


def test_a_sensor_clips() -> None:
    clipped = sensed("unknown_sensor", beyond=-1.0, level_n=120.0)
    np.testing.assert_allclose(clipped, np.minimum(sensed("unknown_sensor"), 120.0), atol=1e-9)


def test_a_robot_with_play_yields_up_to_a_level_only() -> None:
    quick = {"frequency_hz": 500.0, "damping_ratio": 1.0}
    play = {"yield_m": 1e-4, "yield_beyond_m": -1e-4, "level_n": 50.0, **quick}
    rigid, yielding, with_play = (
        sensed("unknown_robot", **shape) for shape in (quick, {"yield_m": 1e-4, **quick}, play)
    )
    lost = [float((rigid - other).max()) for other in (yielding, with_play)]
    assert lost[0] > 2 * lost[1] > 1.0


def test_a_reading_may_have_a_kink() -> None:
    clipped = UnknownSensor(*map(jnp.asarray, typical("unknown_sensor", beyond=-1.0, level_n=150.0)))
    for force, reading in ((100.0, 100.0), (150.0, 150.0), (400.0, 150.0)):
        f = jnp.asarray(force)
        assert clipped.sense((f, f), jnp.asarray(1e-4), jnp.zeros(4))[1] == pytest.approx(reading)


def test_the_force_up_to_which_a_free_curve_was_tried_is_of_the_first_contact(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    contact = np.array([[0.0, 60.0, 120.0, -1.0, 1e9, np.nan], [0.0, 40.0, 50.0, 45.0, 30.0, 20.0]])
    monkeypatch.setattr("acf_jax.inference.forward.forward", lambda *_: Forces(contact, contact[:, None]))
    some, grid = np.zeros(2), Grid(1e-4, 5)
    assert reach_of(("unknown_contact",), some, some, some, grid) == 120.0
    assert reach_of(("gravity",), some, some, some, grid) == np.inf


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


@pytest.mark.parametrize("curve", ["unknown_contact", "unknown_sensor"])
def test_the_reach_of_a_free_curve_changes_nothing_below_it(curve: str) -> None:
    theta = np.array([2.0, 60.0, 800.0, 3e5, *(p.scale for p in free_curves()[curve].parameters())])
    grid = Grid(1e-4, 100)
    v_e, f_p = np.array([0.05, 0.3]), np.array([60.0, 60.0])
    reach = reach_of((curve,), theta, v_e[:1], f_p[:1], grid)
    free, held = (forward((curve,), theta, v_e, f_p, grid, r).sensed for r in (np.inf, reach))
    assert held[0] == pytest.approx(free[0], rel=1e-12)
    assert abs(held[1] - free[1]).max() > 1.0
    assert reach_of(("gravity",), np.append(theta[:4], 5.0), v_e, f_p, grid) == np.inf
