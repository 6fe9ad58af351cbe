"""By when the robot has to stop, so that a design's force holds its limit with the stated probability."""

from types import SimpleNamespace

import numpy as np
import pytest

from acf_jax.contact.ended import Above, Ended
from acf_jax.contact.model import Sample, sample_forces
from acf_jax.contact.read import of_rig
from acf_jax.designs import stop
from acf_jax.designs.chance import held_share
from acf_jax.designs.solve import Design, design
from acf_jax.designs.task import make_task

LIMIT, LATE, DRAWS = 140.0, 0.05, 4096
RIG = {"m": 1.9, "d": 60.0, "k_f": 800.0, "k_c": 6e4}
STD = {"m": 0.02, "d": 0.2, "k_f": 0.3, "k_c": 0.05, "v_e": 0.005, "f_p": 0.01}


def drawn_forces(v: float, f_p: float, times: np.ndarray, draws: int) -> np.ndarray:
    """The largest contact force until the robot stops at each of some times, N, of draws of RIG.

    Swinging, m V'' + d V' + K V = k_C v with V = x'; carried along, F_P + k_F v t + d v.
    """
    random = np.random.default_rng(2024)
    best = RIG | {"v_e": v, "f_p": f_p}
    m, d, k_f, k_c, v_e, preload = (
        x * (1 + STD[name] * random.standard_normal(draws)) for name, x in best.items()
    )
    decay = d / (2 * m)
    rate = np.sqrt((k_f + k_c) / m - decay**2)
    settled = k_c * v_e / (k_f + k_c)
    cosine, sine = -settled, (preload / m - decay * settled) / rate
    largest, found, before = preload, [], 0.0
    for until in times:
        for t in np.linspace(before, until, 1 + int((until - before) / 2.5e-4))[1:]:
            c, s = np.exp(-decay * t) * np.cos(rate * t), np.exp(-decay * t) * np.sin(rate * t)
            swung = cosine * (decay * (1 - c) + rate * s) + sine * (rate * (1 - c) - decay * s)
            x = settled * t + swung / (decay**2 + rate**2)
            largest = np.maximum(largest, preload + k_c * (v_e * t - x))
        found.append(np.maximum(largest, preload + k_f * v_e * until + d * v_e))
        before = until
    return np.array(found)


@pytest.mark.parametrize("probability", [0.95, pytest.param(0.975, marks=pytest.mark.long)])
def test_until_the_stop_the_limit_holds_with_the_stated_probability(probability: float) -> None:
    """Where the first peak uses up what the probability leaves, later forces may break it in next to no draw."""
    limit = 120.0
    task = make_task(of_rig(RIG, STD), {"v_e": (0.0, 2.0)}, {"f_p": 60.0}, "fastest", limit, probability)
    found = design(task)
    assert isinstance(found, Design) and found.stop is not None and found.at_limit
    first = 0.02  # s; the first peak is over, and the robot has not come far enough for its spring to count
    times = np.array([first, found.stop.time, 1.25 * found.stop.time])
    peak, until, later = (drawn_forces(found.z[-2], 60.0, times, 40_000) <= limit).mean(1)
    error = np.sqrt(probability * (1 - probability) / found.draws)
    assert until >= probability - 3 * error
    assert peak - 2 * error < until < peak  # in no more draws than what the first peak has to spare
    assert later < probability - 3 * error  # and not needlessly early
    assert found.stop.travel == pytest.approx(found.stop.time * found.z[-2])


def test_what_its_energy_cannot_break_is_not_simulated(monkeypatch: pytest.MonkeyPatch) -> None:
    """An undamped flange without a spring meets its limit with the first peak, or never."""
    counted = {Above: 0, Ended: 0}

    def forces(model, sample, body):
        if isinstance(model.main.peak, Ended):
            counted[type(model.main.peak)] += len(sample.form)
        return sample_forces(model, sample, body)

    monkeypatch.setattr(stop, "sample_forces", forces)
    ideal = RIG | {"d": 0.0, "k_f": 0.0}
    task = make_task(of_rig(ideal, STD), {"v_e": (0.0, 2.0)}, {"f_p": 60.0}, "fastest", LIMIT, 0.95)
    found = design(task)
    assert isinstance(found, Design) and found.stop is not None and found.stop.time == np.inf
    assert counted[Above] > 0.9 * found.draws and counted[Ended] == 0


def asked(probability: float) -> SimpleNamespace:
    model = SimpleNamespace(main=SimpleNamespace(peak=None), is_certain=False)
    return SimpleNamespace(model=model, limit=LIMIT, probability=probability)


def of_draws(monkeypatch: pytest.MonkeyPatch, first: np.ndarray, ends: np.ndarray, beyond: float) -> None:
    """Draws whose first peak is `first`, and which break the limit by a share of it with every stop after `ends`."""

    def forces(model, sample, body):
        force, end = sample.of[0].T
        if not isinstance(model, tuple):
            return force, np.ones(len(force), bool)
        ending, law = model
        force = np.where(end < float(ending.stop_after), LIMIT * (1 + beyond), force)
        return force, np.full(len(force), law is Ended)  # of what it stays below nothing is known

    drawn = Sample((np.stack([first, ends], axis=1),), np.ones(len(first)))
    monkeypatch.setattr(stop, "draw_sample", lambda model, z, draws, seed: drawn)
    monkeypatch.setattr(stop, "sample_forces", forces)
    monkeypatch.setattr(stop, "ended", lambda model, ending, law: (ending, law))


@pytest.mark.parametrize("broken", [0, 0.02, 0.044])
def test_the_stop_is_the_latest_with_which_enough_draws_hold(monkeypatch, broken):
    """Found by halving, in the draws that it can still depend on, and among all of them."""
    random = np.random.default_rng(7)
    first = np.where(np.arange(DRAWS) < broken * DRAWS, 1.01 * LIMIT, 0.9 * LIMIT)
    ends = 0.1 * np.exp(0.5 * random.standard_normal(DRAWS))
    of_draws(monkeypatch, first, ends, 0.1)
    found = []
    for probability in (0.9, 0.95):
        needed = int(np.ceil(held_share(probability, DRAWS, stop.TO_SPARE) * DRAWS))
        latest = np.sort(ends[first <= LIMIT])[::-1][needed - 1]
        found.append(stop.needed_stop(asked(probability), np.array([1.0, 0.2, 60.0]), DRAWS, 0).time)
        assert found[-1] == pytest.approx(latest, rel=5e-4) and found[-1] <= latest
    assert found[1] < found[0]


@pytest.mark.parametrize(("beyond", "latest"), [(5e-4, np.inf), (2e-3, LATE)])
def test_what_two_simulations_differ_by_does_not_stop_the_robot(monkeypatch, beyond, latest):
    """A design touches its limit; the simulation until a stop has steps of its own, and a little higher a force."""
    of_draws(monkeypatch, np.full(DRAWS, LIMIT), np.full(DRAWS, LATE), beyond)
    found = stop.needed_stop(asked(0.95), np.array([1.0, 0.2, 60.0]), DRAWS, 0)
    assert found.time == (latest if np.isinf(latest) else pytest.approx(latest, rel=1e-3))


def test_no_stop_is_soon_enough_where_the_draws_break_the_limit_at_once(monkeypatch):
    of_draws(monkeypatch, np.full(DRAWS, LIMIT), np.zeros(DRAWS), 0.1)
    assert stop.needed_stop(asked(0.95), np.array([1.0, 0.2, 60.0]), DRAWS, 0) is None
