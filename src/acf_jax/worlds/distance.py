"""How visible a cause is: the traces with and without it, and the whitened distance between them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from acf_jax.worlds.interface import AbstractWorld, Array, Impact, Rig
from acf_jax.worlds.setup import Setup

NAMES = ("m", "d", "k_f", "k_c")
ADJUSTMENTS = 12  # of the imitating rig, at most
LEAST = 0.02  # share of its true value below which no constant of the imitating rig goes
Pair = tuple[Array, Array, Array]  # time s, force with the causes N, force without N


def signature(world: AbstractWorld, setup: Setup, causes: Sequence[Any]) -> list[Pair]:
    """Noise-free sensed force of each condition with and without the causes, on the same rig.

    **Returns:** one (time, with, without) a condition, each of shape (n,), from the first sample in contact to the
    loss of contact with the causes. The sample at time 0 is left out: whether it falls before or after the step of
    the force is the trigger's doing.
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
        self.world, self.setup = world, setup
        self.own: list[Array] = []  # by velocity, pretension and trigger of the trial, (n, 3) a condition
        self.common: list[Array] = []  # by m, d, k_F, k_C, (n, 4) a condition
        time = setup.time[setup.time > 0.0]
        self.trigger_std = max(setup.jitter, 0.5) * setup.interval / np.sqrt(3.0)
        for impact in setup.conditions:

            def force(rig: Rig = setup.rig, impact: Impact = impact) -> Array:
                return world.respond(rig, [], impact, time, after_loss=np.inf).sensed

            nominal = force()
            v_std, f_std = setup.spread * impact.v_e, setup.spread * impact.f_p
            own = [
                force(impact=Impact(impact.v_e + v_std, impact.f_p)) - nominal,
                force(impact=Impact(impact.v_e, impact.f_p + f_std)) - nominal,
                np.gradient(nominal, time) * self.trigger_std,
            ]
            common = []
            for name, (_, std) in zip(NAMES, setup.prior, strict=True):
                step = 0.05 * std
                moved = replace(setup.rig, **{name: getattr(setup.rig, name) + step})
                common.append((force(moved) - nominal) * (std / step))
            self.own.append(setup.noise.whiten(np.stack(own, axis=1)))
            self.common.append(setup.noise.whiten(np.stack(common, axis=1)))

    def distance(self, pairs: Sequence[Pair]) -> float:
        """What no adjustment removes of the difference of the pairs, see `distance`."""
        theta, own = np.zeros(4), np.zeros((len(pairs), 3))
        low = np.array([(LEAST - 1) * getattr(self.setup.rig, n) for n in NAMES])
        low /= [std for _, std in self.setup.prior]
        best = np.inf
        for _ in range(ADJUSTMENTS):
            left = [f - self._adjusted(c, theta, own[c], f.size) for c, (_, f, _) in enumerate(pairs)]
            white = [self.setup.noise.whiten(r) for r in left]
            repeats = self.setup.repeats
            squared = repeats * (sum(float(r @ r) for r in white) + float((own**2).sum())) + float(
                theta @ theta
            )
            if squared > 0.98 * best:
                return float(np.sqrt(min(best, squared)))
            best = squared
            # one step of Gauss-Newton with the derivatives at the true rig; a trial's own part is eliminated
            normal, gradient, parts = np.eye(4), -theta, []
            for residual, k, j, o in zip(white, self.own, self.common, own, strict=True):
                k, j = k[: residual.size], j[: residual.size]
                inverse = np.linalg.inv(k.T @ k + np.eye(3))
                on_own = k.T @ residual - o
                normal += repeats * (j.T @ j - j.T @ k @ inverse @ k.T @ j)
                gradient += repeats * (j.T @ residual - j.T @ k @ inverse @ on_own)
                parts.append((inverse, on_own, k.T @ j))
            step = _within(normal, gradient, theta, low)
            theta = theta + step
            own = own + np.stack([inverse @ (on_own - cross @ step) for inverse, on_own, cross in parts])
        return float(np.sqrt(best))

    def _adjusted(self, c: int, theta: Array, own: Array, n: int) -> Array:
        """Force of condition c without causes, at adjusted parameters in standard deviations, (n,)."""
        setup = self.setup
        impact = setup.conditions[c]
        values = {
            name: getattr(setup.rig, name) + u * std
            for name, u, (_, std) in zip(NAMES, theta, setup.prior, strict=True)
        }
        moved = Impact(impact.v_e * (1 + setup.spread * own[0]), impact.f_p * (1 + setup.spread * own[1]))
        time = setup.time[setup.time > 0.0][:n]
        force = self.world.respond(Rig(**values), [], moved, time, after_loss=np.inf).sensed
        return np.asarray(force + np.gradient(force, time) * own[2] * self.trigger_std)

    def gram(self, signals: Sequence[Sequence[Array]]) -> Array:
        """Inner products (k, k) of what no adjustment removes from k signals, each one array (n,) a condition, N.

        Of a condition the part counts that all of the signals have.
        """
        columns, targets = [np.eye(4)], [np.zeros((4, len(signals)))]
        for c, (own, common) in enumerate(zip(self.own, self.common, strict=True)):
            here = np.stack([s[c][: min(len(t[c]) for t in signals)] for s in signals], axis=1)
            n = len(here)
            # The unit rows are the priors, in standard deviations.
            basis, _ = np.linalg.qr(np.vstack([own[:n], np.eye(3)]))

            def off_own(rows: Array, basis: Array = basis) -> Array:
                padded = np.concatenate([rows, np.zeros((3, rows.shape[1]))])
                return np.asarray(padded - basis @ (basis.T @ padded))

            weight = np.sqrt(self.setup.repeats)
            columns.append(weight * off_own(common[:n]))
            targets.append(weight * off_own(self.setup.noise.whiten(here)))
        design, target = np.concatenate(columns), np.concatenate(targets)
        theta, *_ = np.linalg.lstsq(design, target)
        left = target - design @ theta
        return np.asarray(left.T @ left)


def _within(normal: Array, gradient: Array, theta: Array, low: Array) -> Array:
    """The Gauss-Newton step that leaves no parameter below its bound: those that would fall are held there."""
    step = np.linalg.solve(normal, gradient)
    held = np.zeros(theta.size, bool)
    while (falling := ~held & (theta + step < low)).any():
        held |= falling
        step[held] = (low - theta)[held]
        free = ~held
        rest = gradient[free] - normal[np.ix_(free, held)] @ step[held]
        step[free] = np.linalg.solve(normal[np.ix_(free, free)], rest)
    return step


def distance(
    world: AbstractWorld, setup: Setup, causes: Sequence[Any], tangents: Tangents | None = None
) -> float:
    """Whitened distance of the causes from what nominal parameters and nuisances can imitate.

    d^2 = min over theta of |W (F_with - F_without - J theta)|^2 + |theta/std|^2, where theta holds the
    rig's four constants under their priors and, for each trial, velocity, pretension and trigger time.
    The best method there is confuses two explanations at distance d with probability Q(d/2).
    The minimum is found by Gauss-Newton steps that keep the derivatives at the true rig; it is an upper bound.

    **Arguments:** `world`: the engine. `setup`: the rig, the conditions and the noise. `causes`: of that world, acting
    together. `tangents`: those of the setup, where they are known already.
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

    **Arguments:** `world`: the engine. `setup`: the rig, the conditions and the noise. `name`: of a cause of that
    world. `seed`: of what the cause draws. `target`: a `distance`. `tangents`: those of the setup, where they are known
    already.
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
