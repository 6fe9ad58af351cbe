"""Proposals of a search over explanations: a law added to some, dropped from them, or swapped for another."""

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from itertools import chain
from typing import NamedTuple

import numpy as np

from acf_jax.diagnosis.candidates import fit_more, in_parallel, promised, with_sought
from acf_jax.inference.baseline import Ground, one_more
from acf_jax.inference.fit import ITERATIONS, Fit, fit
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import Explanation, places, rests

NEAR = 20  # iterations of a fit that begins near its optimum
SHARED = 3  # laws from which on explanations share a program: pairs are met again, and there are thousands of triples
HOPELESS = 40.0  # log evidence by which an explanation lies so far behind that nothing like it is tried

Known = Mapping[Explanation, float]  # what is fitted already, with its log evidence


class Couple(NamedTuple):
    """What fits begin beside, the law that they are to get, from where, and what that promises."""

    ground: Ground
    name: str
    begins: Sequence[np.ndarray]
    gain: float  # in chi-square
    objective: float  # after it

    @property
    def explanation(self) -> Explanation:
        """With the law."""
        return one_more(self.ground.fitted.explanation, self.name, self.ground.instead_of)


def couples(ground: Ground, effects: Sequence[str]) -> list[Couple]:
    """Each effect that the fit of a ground does not have, and what it promises to first order."""
    names, left = [name for name in effects if name not in ground.fitted.explanation], ground.projector.left
    of_each = in_parallel([partial(promised, ground, name) for name in names])
    return [
        Couple(ground, name, [p.parameters for p in own], own[0].gain, left - 0.5 * own[0].gain)
        for name, own in zip(names, of_each, strict=True)
    ]


def fit_couples(wanted: Sequence[Couple], iterations: int = ITERATIONS, near: bool = False) -> list[Fit]:
    """The fits of couples; `near` as in `fit_more`.

    Those of many laws share one program, which has all of them: compiling takes longer than fitting.
    """
    several = [c for c in wanted if len(c.explanation) >= SHARED]
    laws = {name for c in several for name in (*c.ground.fitted.program, c.name)}
    program = tuple(sorted(laws))

    def fitted(couple: Couple) -> Fit:
        shared = program if len(couple.explanation) >= SHARED else None
        return fit_more(couple.ground, couple.name, couple.begins, iterations, near, shared)

    return in_parallel([partial(fitted, couple) for couple in wanted])


def proposed(leader: Ground, effects: Sequence[str], known: Known) -> list[Fit]:
    """The fits that are proposed from the fit of a ground, but for those known."""
    rests = without_each(leader.observations, leader.fitted, known)
    return [
        *rests,
        *fit_couples([*add(leader, effects, known), *swap(leader, effects, known)], NEAR, near=True),
    ]


def add(leader: Ground, effects: Sequence[str], known: Known) -> list[Couple]:
    """One law more: the one that promises most, be it little, since fits gain more than they promise."""
    return _best(couples(leader, effects), known)


def swap(leader: Ground, effects: Sequence[str], known: Known) -> list[Couple]:
    """Another law in place of each: the one that promises most where that is taken out.

    Of all together those that promise most would be in place of small laws: large ones have their imitators, too.
    """
    explanation = leader.fitted.explanation
    if len(explanation) == 1:
        return []  # every law is fitted alone
    replaced = [law for law in explanation if not _is_needed(law, explanation, known)]
    of_each = [_best(couples(leader.without(law), effects), known) for law in replaced]
    return list(chain.from_iterable(of_each))


def without(o: Observations, fitted: Fit, rest: Explanation) -> Fit:
    """The rest of a fit, carried on from where it is with some other law; no other program is compiled for it."""
    theta = np.append(fitted.physical[places(rest, fitted.explanation)], fitted.common)
    return with_sought(
        fit(o, rest, theta, fitted.nuisance, warm=True, iterations=NEAR, program=fitted.program)
    )


def without_each(o: Observations, fitted: Fit, known: Known) -> list[Fit]:
    """A fit without each of its laws, or without its free curve, but for what is known."""
    return in_parallel([partial(without, o, fitted, r) for r in rests(fitted.explanation) if r not in known])


def _is_needed(law: str, explanation: Explanation, known: Known) -> bool:
    """Whether beside fewer of the laws all that was tried in place of one is hopeless."""
    whole = set(explanation)
    for fewer in (e for e in known if law in e and len(e) > 1 and set(e) < whole):
        others = set(fewer) - {law}
        instead = [z for e, z in known.items() if len(e) == len(fewer) and law not in e and others < set(e)]
        if instead and max(instead) < known[fewer] - HOPELESS:
            return True
    return False


def _best(found: Iterable[Couple], known: Known) -> list[Couple]:
    """The one that promises most, of those that are not known."""
    return sorted((c for c in found if c.explanation not in known), key=lambda c: c.objective)[:1]
