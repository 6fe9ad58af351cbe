"""Proposals of a search over explanations: a law added to some, dropped from them, or swapped for another."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import chain
from typing import NamedTuple

import numpy as np

from acf_jax.diagnosis.candidates import fit_more, in_parallel, promised
from acf_jax.inference.baseline import Ground
from acf_jax.inference.fit import ITERATIONS, Fit, fit
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import Explanation, places, rests

NEAR = 20  # iterations of a fit that begins near its optimum


class Couple(NamedTuple):
    """A fit, the law it is to get besides and from where, and what that promises."""

    leader: Fit
    name: str
    begins: Sequence[np.ndarray]
    gain: float  # in chi-square
    objective: float  # after it

    @property
    def explanation(self) -> Explanation:
        """Of both together."""
        return tuple(sorted((*self.leader.explanation, self.name)))


class Leader(NamedTuple):
    """What proposals start from."""

    ground: Ground
    rests: Sequence[Fit]  # without each of its laws, or its free curve

    @classmethod
    def of(cls, ground: Ground) -> "Leader":
        """The fit of a ground, and what is left of it without each of its laws, fitted again."""
        return cls(ground, without_each(ground.observations, ground.fitted, ()))


def couples(ground: Ground, effects: Sequence[str]) -> list[Couple]:
    """The fit of a ground with each effect that it does not have, and what that promises to first order."""
    leader = ground.fitted
    names = [name for name in effects if name not in leader.explanation]
    of_each = in_parallel([partial(promised, ground, name) for name in names])
    return [
        Couple(leader, name, [p.parameters for p in own], own[0].gain, leader.objective - 0.5 * own[0].gain)
        for name, own in zip(names, of_each, strict=True)
    ]


def fit_couples(
    o: Observations, wanted: Iterable[Couple], iterations: int = ITERATIONS, near: bool = False
) -> list[Fit]:
    """The fits of couples; `near` as in `fit_more`."""
    return in_parallel([partial(fit_more, o, c.leader, c.name, c.begins, iterations, near) for c in wanted])


def add(leader: Leader, effects: Sequence[str], known: Iterable[Explanation]) -> list[Fit]:
    """The fit with one more law: the one that promises most, be it little, since fits gain more than they promise."""
    ground = leader.ground
    return fit_couples(ground.observations, _best(couples(ground, effects), known), NEAR, near=True)


def drop(leader: Leader, effects: Sequence[str], known: Iterable[Explanation]) -> list[Fit]:
    """The fit without each of its laws, or of its free curve."""
    return list(leader.rests)


def swap(leader: Leader, effects: Sequence[str], known: Iterable[Explanation]) -> list[Fit]:
    """The fit with another law in place of each of its own: the one that promises most, to what is left without that.

    Of all together those that promise most would be in place of small laws: large ones have their imitators, too.
    """
    ground = leader.ground
    if len(ground.fitted.explanation) == 1:
        return []  # every law is fitted alone
    of_each = [_best(couples(ground.beside(rest), effects), known) for rest in leader.rests]
    return fit_couples(ground.observations, chain.from_iterable(of_each), NEAR, near=True)


Proposal = Callable[[Leader, Sequence[str], Iterable[Explanation]], list[Fit]]
PROPOSALS: tuple[Proposal, ...] = (add, drop, swap)


def without(o: Observations, fitted: Fit, rest: Explanation) -> Fit:
    """The rest of a fit, carried on from where it is with some other law; no other program is compiled for it."""
    theta = np.append(fitted.physical[places(rest, fitted.explanation)], fitted.common)
    return fit(o, rest, theta, fitted.nuisance, warm=True, iterations=NEAR, program=fitted.program)


def without_each(o: Observations, fitted: Fit, known: Iterable[Explanation]) -> list[Fit]:
    """A fit without each of its laws, but for what is known."""
    done = set(known)
    return in_parallel([partial(without, o, fitted, r) for r in rests(fitted.explanation) if r not in done])


def _best(found: Iterable[Couple], known: Iterable[Explanation]) -> list[Couple]:
    """The one that promises most, of those that are not known."""
    done = set(known)
    return sorted((c for c in found if c.explanation not in done), key=lambda c: c.objective)[:1]
