"""Data sets drawn from the library's own prior, to train a classifier on: every effect, free curves, nothing at all.

Rigs, campaigns, the kinds of causes and the small effects of a third of the rigs are drawn as blind runs draw them. But
the force is our simulator's: a law's strengths share a total as its prior has it, shapes come from their priors, an
unknown cause is a free curve. Each cause is simulated alone, at a size at which it is large; what it changes of the
force is scaled to the share that it shall have, and causes that act together are added.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from acf_jax.effects import library
from acf_jax.evidence.posterior import UNKNOWN
from acf_jax.inference.forward import SAMPLES, Grid, forward, step_for
from acf_jax.inference.free_curves import free_curves
from acf_jax.inference.observations import ONSET
from acf_jax.inference.parameters import PRIOR_WIDTH, every_effect
from benchmarks.peers_diagnosis.features import SPAN
from benchmarks.peers_diagnosis.traces import Traces
from validation.blind.plan import LARGE as LARGE_KINDS
from validation.blind.plan import LIFELIKE, SHARES
from validation.worlds.lifelike import (
    AMPLITUDE,
    CAUGHT,
    DECAY,
    FEWEST_SMALL,
    FREQUENCY,
    LARGE,
    MOST_SMALL,
    RINGING,
    SMALL,
    SPREAD,
)
from validation.worlds.paper import contact_force, until_lost
from validation.worlds.setup import Ring, Setup, draw_setup

Explanation = tuple[str, ...]
KINDS = {kind: share for kind, share in SHARES.items() if kind != "lifelike"}
NUMBER = {"single": 1, "one": 1, "pair": 2, "two": 2, "three": 3}  # of laws that are large, by kind
FOREIGN = ("beyond", "withheld")
ALONE = (0.002, 0.15)  # shares of the force of a cause without small ones beside it
LAWS, CURVES = 8, 1  # drawn for each rig
SETS = 10  # that combine them
TRIES = 3  # sizes tried until a cause changes its share
FACTOR = 3.0  # by which the share may be missed, as it is scaled anyway


class Drawn(NamedTuple):
    """A set, and what is large in it."""

    traces: Traces
    explanation: Explanation


class Change(NamedTuple):
    """What a cause does to the force."""

    cause: str
    share: float  # of the force
    force: np.ndarray  # (conditions, samples) N, the difference


def draw(seed: int, rigs: int) -> Iterator[Drawn]:
    """Sets of so many rigs, a few of each."""
    rng = np.random.default_rng(seed)
    for _ in range(rigs):
        setup = draw_setup(rng, bool(rng.random() < 0.3))
        time = np.arange(0.0, SPAN * 1.1 * setup.rig.half_period, step_for(*_constants(setup)) / 2)
        laws = rng.choice(list(library()), LAWS, replace=False).tolist()
        curves = rng.choice(list(free_curves()), CURVES, replace=False).tolist()
        changes = [_change(rng, setup, name, time) for name in (*laws, *curves)]
        of_laws = [c for c in changes[:LAWS] if c]
        of_curves = [c for c in changes[LAWS:] if c]
        for _ in range(SETS):
            yield from _combine(rng, setup, of_laws, of_curves, time)


def _constants(setup: Setup) -> tuple[float, float, float, float]:
    return setup.rig.m, setup.rig.d, setup.rig.k_f, setup.rig.k_c


def _labels(setup: Setup) -> tuple[np.ndarray, np.ndarray]:
    v_e, f_p = np.array(setup.conditions).T
    return v_e, f_p


def without(setup: Setup, time: np.ndarray) -> np.ndarray:
    """The paper's force of each condition, N, (conditions, samples), as if contact were never lost."""
    v_e, f_p = _labels(setup)
    return np.asarray(contact_force(setup.rig, v_e[:, None], f_p[:, None], time[None]))


def direction(rng: np.random.Generator, cause: str) -> tuple[np.ndarray, np.ndarray]:
    """A cause's parameters at a total strength of 1, and which of them are strengths."""
    known = every_effect()[cause].parameters()
    strong = np.array([not p.shape for p in known])
    acting = rng.random(strong.sum()) < 0.5
    acting[rng.integers(acting.size)] = True
    parts = iter(rng.dirichlet(np.ones(acting.size)) * acting)
    values = []
    for p in known:
        if p.shape:
            spread = np.log(p.high / p.low) / 4
            values.append(float(np.clip(p.scale * np.exp(spread * rng.standard_normal()), p.low, p.high)))
        else:
            sign = rng.choice([-1.0, 1.0]) if p.low < 0 else 1.0
            values.append(sign * PRIOR_WIDTH * p.scale * next(parts))
    return np.array(values), strong


def _change(rng: np.random.Generator, setup: Setup, cause: str, time: np.ndarray) -> Change | None:
    """What a cause of a drawn form changes, at a size at which it is large; None where none was found."""
    base, (v_e, f_p) = without(setup, time), _labels(setup)
    inside = until_lost(base) > 0
    h = min(step_for(*_constants(setup)), every_effect()[cause].longest_step)
    grid = Grid(h, min(int(np.ceil(time[-1] / h)), SAMPLES - 1), pull=1.0)
    values, strong = direction(rng, cause)
    known = every_effect()[cause].parameters()
    low, high = (np.array([getattr(p, end) for p in known]) for end in ("low", "high"))
    size, target = 0.1, float(np.exp(rng.uniform(*np.log(LARGE))))
    for _ in range(TRIES):
        theta = np.concatenate(
            [_constants(setup), np.clip(np.where(strong, size * values, values), low, high)]
        )
        found = forward((cause,), theta, v_e, f_p, grid)
        at = np.arange(grid.steps + 1) * grid.h
        force = np.array([np.interp(time, at, row) for row in found.sensed])
        if not np.isfinite(force).all() or force[inside].max() > CAUGHT * base[inside].max():
            size /= 10
            continue
        change = force - base
        share = float(np.sqrt((change[inside] ** 2).sum() / (base[inside] ** 2).sum()))
        if 1 / FACTOR < share / target < FACTOR:
            return Change(cause, share, change)
        size *= float(np.clip(target / max(share, 1e-9), 1e-2, 1e2))
    return None


def _combine(
    rng: np.random.Generator, setup: Setup, laws: list[Change], curves: list[Change], time: np.ndarray
) -> Iterator[Drawn]:
    """A set of a drawn kind, where there are causes enough for it."""
    is_lifelike = rng.random() < LIFELIKE
    shares = LARGE_KINDS if is_lifelike else KINDS
    kind = str(rng.choice(list(shares), p=np.array(list(shares.values())) / sum(shares.values())))
    order, count = rng.permutation(len(laws)), NUMBER.get(kind, 0)
    beside = int(rng.integers(FEWEST_SMALL, MOST_SMALL + 1)) if is_lifelike else 0
    if len(laws) < count + min(beside, FEWEST_SMALL) or (kind in FOREIGN and not curves):
        return
    large = [laws[i] for i in order[:count]] + (curves if kind in FOREIGN else [])
    small = [laws[i] for i in order[count : count + beside]]
    force = without(setup, time)
    for change in large:
        low, high = LARGE if is_lifelike else ALONE
        force = force + change.force * float(np.exp(rng.uniform(np.log(low), np.log(high)))) / change.share
    for change in small:
        force = force + change.force * float(rng.uniform(*SMALL)) / change.share
    explanation = UNKNOWN if kind in FOREIGN else tuple(sorted(c.cause for c in large))
    if is_lifelike:
        ring = Ring(
            float(rng.uniform(*FREQUENCY)),
            float(rng.uniform(*DECAY)) * setup.rig.half_period,
            float(rng.uniform(*AMPLITUDE)),
        )
        setup = replace(
            setup,
            repeats=max(setup.repeats, 2),
            spread=round(float(rng.uniform(*SPREAD)), 4),
            ring=ring if rng.random() < RINGING else None,
        )
    yield Drawn(record(rng, setup, time, until_lost(force)), explanation)


def record(rng: np.random.Generator, setup: Setup, time: np.ndarray, force: np.ndarray) -> Traces:
    """The campaign's trials of known forces (conditions, samples): scatter, trigger, noise, sampling.

    What scatter of speed and pretension changes is taken from the paper's model.
    """
    which = np.repeat(np.arange(len(force)), setup.repeats)
    v_e, f_p = (label[which] for label in _labels(setup))
    scatter = 1 + setup.spread * rng.standard_normal((2, which.size))
    acting = v_e * (scatter[0] - 1), f_p * (scatter[1] - 1)
    moved = contact_force(setup.rig, acting[0][:, None], acting[1][:, None], time[None])
    at = np.arange(1, int(time[-1] / setup.interval)) * setup.interval
    rows, used = [], []
    for k, i in enumerate(which):
        true = np.where(force[i] > 0, force[i] + moved[k], 0.0)
        late = setup.late(rng)
        reading = np.interp(at + late, time, true)
        reading += setup.noise.draw(rng, at.size)
        if setup.ring:
            reading += setup.ring.draw(rng, at + late, float(true.max()))
        rows.append(np.round(reading / setup.quantum) * setup.quantum)
        end = time[np.argmin(true > 0)] if (true <= 0).any() else np.inf
        used.append((at > ONSET * setup.interval) & (at + late < end - setup.interval))
    value, std = np.array(setup.prior).T
    memory = setup.noise.memory
    return Traces(
        v_e,
        f_p,
        np.tile(at, (which.size, 1)),
        np.array(rows),
        np.array(used),
        np.full(which.size, setup.interval),
        setup.noise.std,
        (1 + memory) / (1 - memory),
        (setup.spread, setup.spread),
        value,
        std,
    )
