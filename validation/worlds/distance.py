"""How visible a cause is: the traces with and without it, and the whitened distance between them."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from validation.worlds.imitation import Imitation, Trace
from validation.worlds.interface import AbstractWorld, Array
from validation.worlds.setup import Setup

Pair = tuple[Array, Array, Array]  # time s, force with the causes N, force without N


def sensed(world: AbstractWorld, setup: Setup, causes: Sequence[Any]) -> list[Trace]:
    """Noise-free sensed force of each condition, from the first sample in contact to the loss of contact.

    The sample at time 0 is left out: whether it falls before or after the step of the force is the trigger's doing.
    """
    time = setup.time[setup.time > 0.0]
    answers = [world.respond(setup.rig, causes, impact, time) for impact in setup.conditions]
    return [(answer.time, answer.sensed) for answer in answers]


def signature(world: AbstractWorld, setup: Setup, causes: Sequence[Any]) -> list[Pair]:
    """Noise-free sensed force of each condition with and without the causes, on the same rig.

    **Returns:** one (time, with, without) a condition, each of shape (n,), from the first sample in contact to the
    loss of contact with the causes.
    """
    return [
        (time, force, world.respond(setup.rig, [], impact, time, after_loss=np.inf).sensed)
        for impact, (time, force) in zip(setup.conditions, sensed(world, setup, causes), strict=True)
    ]


def distance(world: AbstractWorld, setup: Setup, causes: Sequence[Any]) -> float:
    """Whitened distance of the causes from what nominal parameters and nuisances can imitate.

    d^2 = min over theta of |W (F_with - F_without(theta))|^2 + |theta/std|^2, where theta holds the
    rig's four constants under their priors, the delay that all triggers share and, for each trial, velocity, pretension
    and trigger time.
    The best method there is confuses two explanations at distance d with probability Q(d/2).
    The minimum is found by Gauss-Newton steps.

    **Arguments:** `world`: the engine. `setup`: the rig, the conditions and the noise. `causes`: of that world, acting
    together.
    """
    return float(np.sqrt(Imitation(setup, sensed(world, setup, causes)).best()[1]))


def size_at_distance(world: AbstractWorld, setup: Setup, name: str, seed: int, target: float) -> float:
    """The size, at most 1, at which the named cause is `target` away; see `size_at`.

    **Arguments:** `world`: the engine. `setup`: the rig, the conditions and the noise. `name`: of a cause of that
    world. `seed`: of what the cause draws. `target`: a `distance`.
    """
    return size_at(lambda size: distance(world, setup, [world.draw(name, seed, setup.rig, size)]), target)


def size_at(measure: Callable[[float], float], target: float) -> float:
    """The size, at most 1, at which what a cause does is `target`; within 5 % of it where it can be.

    Where the measure jumps (contact is lost or not) the size closest to the target is returned.

    **Arguments:** `measure`: of a size, about proportional to it. `target`: above 0.
    """

    def excess(log_size: float) -> float:
        return float(np.log(max(measure(float(np.exp(log_size))), 1e-12) / target))

    tried = [(0.0, excess(0.0))]
    if tried[0][1] <= 0.0:
        return 1.0
    guess = -tried[0][1]
    for _ in range(8):
        tried.append((guess, excess(guess)))
        below = max((t for t in tried if t[1] <= 0.0), default=None)
        above = min(t for t in tried if t[1] > 0.0)
        if min(abs(e) for _, e in tried) < 0.05:
            break
        if below is None:
            guess = above[0] - max(above[1], 0.5)
        else:  # regula falsi, kept off the ends of the bracket so that it closes from both sides
            share = float(np.clip(-below[1] / (above[1] - below[1]), 0.1, 0.9))
            guess = below[0] + share * (above[0] - below[0])
    return float(np.exp(min(tried, key=lambda t: abs(t[1]))[0]))
