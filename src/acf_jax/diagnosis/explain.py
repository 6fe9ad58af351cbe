"""All explanations with their evidence: laws in any number and free curves, each with forms that are exact
and with forms that are a little wrong.

Which laws are fitted together is found by proposals: from the most probable laws one is added, dropped or swapped for
another, until no such explanation is more probable.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, combinations

import numpy as np

from acf_jax.diagnosis.candidates import best_of_each, go_on, in_parallel
from acf_jax.diagnosis.proposals import NEAR, PROPOSALS
from acf_jax.evidence.marginal import Marginal, marginal
from acf_jax.evidence.posterior import log_posterior
from acf_jax.inference.baseline import Ground
from acf_jax.inference.discrepancy import SIZES, discrepancy
from acf_jax.inference.fit import Fit
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import Explanation, is_free_curve

SINGLES, SEVERAL = 6, 8  # explanations by one law, and by several, that are fitted beside a discrepancy
WHOLE = 4  # of those by several, whose parts are, too
BEHIND = 20.0  # log probability by which an explanation may lie behind and still be a start
HOPELESS = 2 * BEHIND  # the same beside one size of the discrepancy, from which on no other size is tried
EXACT = 0.1  # log probability that an iteration has to gain
ROUNDS = 4  # of proposals at most: it bounds the time, not what is found, since each adds a law or ends


def explain(
    observations: Observations,
    fits: Sequence[Fit],
    effects: Sequence[str],
    told: Callable[[Sequence[Marginal]], None] = lambda marginals: None,
) -> tuple[list[Fit], list[Marginal]]:
    """The fits of all explanations, and the evidence of each alone and beside a discrepancy of each size.

    **Arguments:** `fits`: the recalibrated model first. `effects`: that proposals may take.
    `told`: given the evidence as soon as it is there.

    **Returns:** the given fits and those that proposals add; the evidence of these, and of the most promising ones
    beside each size of the discrepancy.
    """
    weighed = _Weighed(observations, fits, told)
    weighed.beside_all(_chosen(fits))
    asked: set[Explanation] = set()
    for _ in range(ROUNDS):
        new = [m for m in weighed.leaders() if m.explanation not in asked]
        if not new:
            break
        asked |= {m.explanation for m in new}
        for leader in new:
            ground = weighed.ground(leader)
            found = chain.from_iterable(propose(ground, effects, weighed.plain) for propose in PROPOSALS)
            weighed.take(best_of_each(found), leader.discrepancy)
    return list(weighed.plain.values()), weighed.marginals


class _Weighed:
    """What is weighed so far. Of fits beside a discrepancy only their evidence is kept: they are large."""

    def __init__(
        self,
        observations: Observations,
        fits: Sequence[Fit],
        told: Callable[[Sequence[Marginal]], None],
    ):
        self.plain = {f.explanation: f for f in fits}
        self.marginals: list[Marginal] = []
        self.told = told
        self._note([marginal(f) for f in fits])
        self.observations = {0.0: observations} | {
            size: replace(observations, discrepancy=discrepancy(observations, size)) for size in SIZES
        }

    def beside_all(self, explanations: Sequence[Explanation]) -> None:
        """Weigh fitted explanations beside each size, the largest first: who is hopeless there, is so beside all."""
        remaining = [self.plain[e] for e in explanations]
        for size in sorted(SIZES, reverse=True):
            self._weigh(size, remaining)
            near = self._near(size)
            remaining = [f for f in remaining if f.explanation in near]

    def take(self, found: Sequence[Fit], size: float) -> None:
        """What proposals found beside one size; those that are near the best there are weighed beside all."""
        self._note([marginal(f, size) for f in found])
        near = self._near(size)
        promising = [f for f in found if f.explanation in near]
        if size:
            plain = in_parallel([partial(self._fitted, 0.0, f) for f in promising])
            sound = [f for f in plain if np.isfinite(f.objective)]
            self._note([marginal(f) for f in sound])
        else:
            sound = promising
        self.plain |= {f.explanation: f for f in sound}
        for other in SIZES:
            if other != size:
                self._weigh(other, sound)

    def leaders(self) -> list[Marginal]:
        """From what the search goes on: the most probable laws, and what may still win.

        That is the most probable free curve, with or without laws, and the best laws that are not the leader's with
        one more or fewer: which of two that are much alike acts may show only beside others.
        """
        known = [m for m in self.marginals if m.explanation in self.plain]
        log_p = dict(zip(known, log_posterior(known), strict=True))
        ranked = sorted(known, key=lambda m: -log_p[m])
        laws = [m for m in ranked if not is_free_curve(m.explanation)]
        own = set(laws[0].explanation)
        others = [m for m in laws if not (own <= set(m.explanation) or own >= set(m.explanation))]
        curves = [m for m in ranked if is_free_curve(m.explanation)]
        may_win = [m for m in (*others[:1], *curves[:1]) if log_p[m] > log_p[ranked[0]] - BEHIND]
        return [laws[0], *may_win]

    def ground(self, found: Marginal) -> Ground:
        """What was found, fitted again beside its discrepancy."""
        again = self._fitted(found.discrepancy, self.plain[found.explanation])
        return Ground.of(self.observations[found.discrepancy], again)

    def _weigh(self, size: float, fits: Sequence[Fit]) -> None:
        found = in_parallel([partial(self._weighed, size, f) for f in fits])
        self._note([m for m in found if np.isfinite(m.objective)])

    def _note(self, marginals: Sequence[Marginal]) -> None:
        self.marginals += marginals
        self.told(marginals)

    def _weighed(self, size: float, fitted: Fit) -> Marginal:
        return marginal(self._fitted(size, fitted), size)

    def _fitted(self, size: float, fitted: Fit) -> Fit:
        tolerance = EXACT / max(1.0, fitted.objective)
        return go_on(self.observations[size], fitted, warm=True, iterations=NEAR, tolerance=tolerance)

    def _near(self, size: float) -> set[Explanation]:
        """Explanations that are not hopeless beside a size."""
        there = [m for m in self.marginals if m.discrepancy == size]
        best = max(m.log_z for m in there)
        return {m.explanation for m in there if m.log_z > best - HOPELESS}


def _chosen(fits: Sequence[Fit]) -> list[Explanation]:
    """No law, the free curves, the best single laws, the best several, and the parts of the best of these."""
    known = {f.explanation for f in fits}
    best = [f.explanation for f in sorted(fits, key=lambda f: f.objective) if f.explanation]
    curves = [e for e in best if is_free_curve(e)]
    singles = [e for e in best if len(e) == 1 and e not in curves][:SINGLES]
    several = [e for e in best if len(e) > 1][:SEVERAL]
    parts = chain.from_iterable(combinations(e, k) for e in several[:WHOLE] for k in range(1, len(e)))
    wanted = [(), *curves, *singles, *several, *(e for e in parts if e in known)]
    return list(dict.fromkeys(wanted))
