"""Lifelike rigs: up to three large effects or a foreign cause, among small ones that every rig has.

How large is told by what an effect does to the force: the RMS of what it changes by itself over the RMS of the force.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from acf_jax.errors import InputError
from validation.worlds.case import Case, check_effects, record_case
from validation.worlds.distance import size_at
from validation.worlds.interface import AbstractCause, AbstractWorld, Array, find_world
from validation.worlds.paper import contact_force, until_lost
from validation.worlds.setup import Ring, Setup, draw_setup

MOST = 3  # large effects
LARGE, SMALL = (0.03, 0.15), (0.003, 0.015)  # shares of the force
FEWEST_SMALL, MOST_SMALL = 4, 6
SPREAD = (0.004, 0.015)  # of velocity and pretension from trial to trial, as robots reach them
RINGING = 0.4  # share of the rigs
FREQUENCY = (300.0, 1000.0)  # Hz, of a ring; the slowest recording takes four samples of its period
DECAY, AMPLITUDE = (0.2, 1.0), (0.005, 0.03)  # of a ring: half periods of the rig, share of the peak
IMPACT = 1.3  # half periods: pretension and damping lengthen the impact
EVERY = 3  # one condition in so many, from the hardest on, tells the share
CAUGHT = 2.0  # times the nominal peak: what a flange that never swings back reads; large effects together stay below
RIGS = 50  # tried until each cause can be as large as it shall be


class Sized(NamedTuple):
    """A cause, and what it came to."""

    cause: AbstractCause
    size: float
    share: float


def make_lifelike(
    seed: int, effects: Sequence[str] = (), world: str = "scipy", coloured: bool | None = None
) -> Case:
    """Draw a lifelike rig with these large effects and record a campaign; equal arguments make equal cases.

    Besides come four to six small effects of the library, more spread from trial to trial, at least two trials of each
    condition and, in two fifths of the rigs, a ring of each trial.

    **Arguments:** `seed`: of everything drawn. `effects`: names of the large causes of the world: up to three of its
    library or one beyond it; none at all for small effects alone. `world`, `coloured`: as of `make_case`.

    **Returns:** the case, with `shares` of all its causes, and the small ones as its `background`.

    **Raises:** `InputError` where the world or an effect of it does not exist, an effect is named twice, or there are
    too many.
    """
    engine = find_world(world)
    check_effects(engine, effects)
    library = list(engine.causes("library"))
    if len(effects) > (MOST if set(effects) <= set(library) else 1):
        raise InputError(
            f"effects: {', '.join(effects)} are too many large ones; name up to {MOST} of the library, or one beyond it"
        )
    rng = np.random.default_rng(seed)
    for _ in range(RIGS):
        setup = _draw_setup(rng, coloured)
        others = [name for name in library if name not in effects]
        small = rng.choice(others, rng.integers(FEWEST_SMALL, MOST_SMALL + 1), replace=False).tolist()
        if sized := _size_all(rng, engine, setup, effects, small):
            causes = {name: one.cause for name, one in sized.items()}
            sizes = {name: one.size for name, one in sized.items()}
            case = record_case(seed, rng, engine, setup, causes, sizes)
            if not is_caught(case):
                shares = {name: one.share for name, one in sized.items()}
                return replace(case, shares=shares, background=tuple(small))
    raise InputError(
        f"seed {seed}: no rig was found on which {', '.join(effects)} is large; take another seed"
    )


def is_caught(case: Case) -> bool:
    """Whether a trial or held-out impact ends otherwise than its rig would: held, the robot pushing on.

    An air spring or a stop can do so beyond some speed. What it changes of the force is no small share then, although
    it is one on other impacts.
    """
    trials = [*case.trials, *case.held_out]
    v_e, f_p = np.array([trial.impact for trial in trials]).T[:, :, None]
    nominal = until_lost(contact_force(case.setup.rig, v_e, f_p, case.setup.time[case.setup.time >= 0.0]))
    return any(trial.peak > CAUGHT * peak for trial, peak in zip(trials, nominal.max(axis=1), strict=True))


def _draw_setup(rng: np.random.Generator, coloured: bool | None) -> Setup:
    drawn = bool(rng.random() < 0.2)
    setup = draw_setup(rng, drawn if coloured is None else coloured)
    ring = Ring(
        frequency=float(rng.uniform(*FREQUENCY)),
        decay=float(rng.uniform(*DECAY)) * setup.rig.half_period,
        share=float(rng.uniform(*AMPLITUDE)),
    )
    return replace(
        setup,
        repeats=int(rng.choice([2, 3], p=[0.8, 0.2])),
        spread=round(float(rng.uniform(*SPREAD)), 4),
        ring=ring if rng.random() < RINGING else None,
    )


def _size_all(
    rng: np.random.Generator, world: AbstractWorld, setup: Setup, large: Sequence[str], small: Sequence[str]
) -> dict[str, Sized]:
    """Causes of the size that each shall have; empty where one cannot have it, as a stop that no impact reaches."""
    sized = {}
    for name in [*large, *small]:
        low, high = LARGE if name in large else SMALL
        target = float(
            np.exp(rng.uniform(np.log(low), np.log(high))) if name in large else rng.uniform(low, high)
        )
        sized[name] = size_by_share(world, setup, name, int(rng.integers(2**31)), target)
        if not low <= sized[name].share <= high:
            return {}
    return sized


def size_by_share(world: AbstractWorld, setup: Setup, name: str, seed: int, target: float) -> Sized:
    """The named cause at the size, at most 1, at which it changes this share of the force by itself.

    Within 5 % of the target where it can be: see `size_at`.
    """
    without = _forces(world, setup, [])

    def share(size: float) -> float:
        return share_of_force(_forces(world, setup, [world.draw(name, seed, setup.rig, size)]), without)

    size = size_at(share, target)
    return Sized(world.draw(name, seed, setup.rig, size), size, share(size))


def share_of_force(force: Sequence[Array], without: Sequence[Array]) -> float:
    """RMS of what a cause changes over the RMS of the force without it, as long as both are recorded.

    `force`, `without`: N, one array (n,) a condition.
    """
    pairs = [(f[: w.size], w[: f.size]) for f, w in zip(force, without, strict=True)]
    changed = sum(float(((f - w) ** 2).sum()) for f, w in pairs)
    return float(np.sqrt(changed / sum(float((w**2).sum()) for _, w in pairs)))


def _forces(world: AbstractWorld, setup: Setup, causes: Sequence[AbstractCause]) -> list[Array]:
    """Noise-free sensed force over the impact, N, of a part of the conditions."""
    time = setup.time[(setup.time > 0.0) & (setup.time <= IMPACT * setup.rig.half_period)]
    return [
        world.respond(setup.rig, causes, impact, time, after_loss=np.inf).sensed
        for impact in setup.conditions[::-EVERY]
    ]
