"""How visible a cause is: the traces with and without it, and the whitened distance between them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from acf_jax.worlds.interface import AbstractWorld, Array, Impact, Rig
from acf_jax.worlds.setup import Setup

Pair = tuple[Array, Array, Array]  # time s, force with the causes N, force without N


def signature(world: AbstractWorld, setup: Setup, causes: Sequence[Any]) -> list[Pair]:
    """Noise-free sensed force of each condition with and without the causes, on the same rig.

    Returns:
        One (time, with, without) a condition, each of shape (n,), from the first sample in contact to the
        loss of contact with the causes. The sample at time 0 is left out: whether it falls before or
        after the step of the force is the trigger's doing.
    """
    time = setup.time[setup.time > 0.0]
    pairs = []
    for impact in setup.conditions:
        with_causes = world.respond(setup.rig, causes, impact, time)
        without = world.respond(setup.rig, [], impact, with_causes.time, after_loss=np.inf)
        pairs.append((with_causes.time, with_causes.sensed, without.sensed))
    return pairs


class Tangents:
    """Whitened derivatives of the sensed force by all that a fit may adjust, without causes.

    They are taken over the longest recording; a cause's own recording uses the part that it needs.
    """

    def __init__(self, world: AbstractWorld, setup: Setup):
        self.setup = setup
        self.own: list[Array] = []  # by velocity, pretension and trigger of the trial, (n, 3) a condition
        self.common: list[Array] = []  # by m, d, k_F, k_C, (n, 4) a condition
        time = setup.time[setup.time > 0.0]
        trigger_std = max(setup.jitter, 0.5) * setup.interval / np.sqrt(3.0)
        for impact in setup.conditions:

            def force(rig: Rig = setup.rig, impact: Impact = impact) -> Array:
                return world.respond(rig, [], impact, time, after_loss=np.inf).sensed

            nominal = force()
            v_std, f_std = setup.spread * impact.v_e, setup.spread * impact.f_p
            own = [
                force(impact=Impact(impact.v_e + v_std, impact.f_p)) - nominal,
                force(impact=Impact(impact.v_e, impact.f_p + f_std)) - nominal,
                np.gradient(nominal, time) * trigger_std,
            ]
            common = []
            for name, (_, std) in zip(("m", "d", "k_f", "k_c"), setup.prior, strict=True):
                step = 0.05 * std
                moved = replace(setup.rig, **{name: getattr(setup.rig, name) + step})
                common.append((force(moved) - nominal) * (std / step))
            self.own.append(setup.noise.whiten(np.stack(own, axis=1)))
            self.common.append(setup.noise.whiten(np.stack(common, axis=1)))

    def distance(self, pairs: Sequence[Pair]) -> float:
        """Length of the difference of the pairs that no adjustment removes, see `distance`."""
        columns, targets = [np.eye(4)], [np.zeros(4)]
        for own, common, (_, with_causes, without) in zip(self.own, self.common, pairs, strict=True):
            n = with_causes.size
            # The unit rows are the priors, in standard deviations.
            basis, _ = np.linalg.qr(np.vstack([own[:n], np.eye(3)]))

            def off_own(rows: Array, basis: Array = basis) -> Array:
                padded = np.concatenate([rows, np.zeros((3, *rows.shape[1:]))])
                return np.asarray(padded - basis @ (basis.T @ padded))

            weight = np.sqrt(self.setup.repeats)
            columns.append(weight * off_own(common[:n]))
            targets.append(weight * off_own(self.setup.noise.whiten(with_causes - without)))
        design, target = np.concatenate(columns), np.concatenate(targets)
        theta, *_ = np.linalg.lstsq(design, target)
        return float(np.linalg.norm(target - design @ theta))


def distance(
    world: AbstractWorld, setup: Setup, causes: Sequence[Any], tangents: Tangents | None = None
) -> float:
    """Whitened distance of the causes from what nominal parameters and nuisances can imitate.

    d^2 = min over theta of |W (F_with - F_without - J theta)|^2 + |theta/std|^2, where theta holds the
    rig's four constants under their priors and, for each trial, velocity, pretension and trigger time.
    The best method there is confuses two explanations at distance d with probability Q(d/2).
    The minimum is linearised about the true rig, so a large distance is an upper bound.
    """
    return (tangents or Tangents(world, setup)).distance(signature(world, setup, causes))


def size_at_distance(
    world: AbstractWorld,
    setup: Setup,
    name: str,
    seed: int,
    target: float,
    tangents: Tangents | None = None,
) -> float:
    """The size, at most 1, at which the named cause is `target` away; within 5 % of it where it can be.

    Where the distance jumps (contact is lost or not) the size closest to the target is returned.
    """
    tangents = tangents or Tangents(world, setup)

    def excess(log_size: float) -> float:
        cause = world.draw(name, seed, setup.rig, float(np.exp(log_size)))
        return float(np.log(max(distance(world, setup, [cause], tangents), 1e-12) / target))

    tried = [(0.0, excess(0.0))]
    if tried[0][1] <= 0.0:
        return 1.0
    guess = -tried[0][1]  # the distance is about proportional to the size
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
