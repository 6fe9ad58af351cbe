"""All explanations with their evidence: laws, one or several, and free curves, each with forms that are exact
and with forms that are a little wrong.

Which laws are fitted together is found by proposals: from the most probable laws one is added, dropped or swapped for
another, until no such explanation is more probable. This is done beside the largest discrepancy first: there large
effects are told from one another, and small ones are part of the discrepancy. Then beside the next smaller ones: what
was found becomes the start. The largest is that of inexact forms, or where even the best explanation misses by far
more, the one beside which that is most probable. Exact forms are weighed, but not searched: every trace shows the small
effects of a rig, and what the forms of large ones get wrong, by many times the noise, so that law after law would be
added to make up for it.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, combinations
from typing import NamedTuple

import numpy as np

from acf_jax.diagnosis.candidates import best_of_each, in_parallel
from acf_jax.diagnosis.proposals import HOPELESS, NEAR, proposed, without_each
from acf_jax.evidence.marginal import Marginal, marginal
from acf_jax.evidence.posterior import log_posterior
from acf_jax.inference.baseline import Ground
from acf_jax.inference.changes import changes
from acf_jax.inference.discrepancy import FORMS, SIZES, discrepancy
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import Explanation, is_free_curve, rests
from acf_jax.inference.small_effects import small_effects

SINGLES, SEVERAL = 6, 8  # explanations by one law, and by several, that are fitted beside a discrepancy
WHOLE = 4  # of those by several, whose parts are, too
BEHIND = HOPELESS / 2  # log probability by which an explanation may lie behind and still be a start
NEGLIGIBLE = 1e-4  # of the probability of the best: what is so improbable is tried with no other size
STATED = 1e-2  # the same, from which on it matters by which laws an explanation is stated
EXACT = 0.1  # log probability that an iteration has to gain
ROUNDS = 4  # of proposals beside each size at most: it bounds the time, since each adds a law or ends
NARROWING = sorted((s for s in SIZES if s <= FORMS), reverse=True)  # sizes of the discrepancy as searched
WIDENING = sorted(s for s in SIZES if s > FORMS)  # those that are taken where they are more probable


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
    weighed = _Weighed(observations, fits, effects, told)
    weighed.beside_all(_chosen(fits))
    for size in weighed.sizes:
        weighed.bring(size)
        _improve(weighed, effects, partial(weighed.best_laws, size))
        if weighed.is_wider_better(size):
            break
    weighed.complete()
    _improve(weighed, effects, weighed.leaders)
    weighed.complete()
    return list(weighed.plain.values()), weighed.with_changes()


def _improve(weighed: "_Weighed", effects: Sequence[str], leaders: Callable[[], Sequence[Marginal]]) -> None:
    """Proposals from leaders, until there are no new ones, `ROUNDS` times at most."""
    asked: set[tuple[Explanation, float]] = set()
    for _ in range(ROUNDS):
        new = [m for m in leaders() if (m.explanation, m.discrepancy) not in asked]
        asked |= {(m.explanation, m.discrepancy) for m in new}
        for leader in new:
            begun, known = weighed.ground(leader), weighed.known(leader.discrepancy)
            weighed.take(best_of_each(proposed(begun, effects, known)), leader.discrepancy)


class _End(NamedTuple):
    """Where a fit beside some size of the discrepancy ended; of the fit itself, which is large, nothing is kept."""

    evidence: Marginal
    theta: np.ndarray
    nuisance: np.ndarray
    program: Explanation


class _Weighed:
    """What is weighed so far."""

    def __init__(
        self,
        observations: Observations,
        fits: Sequence[Fit],
        effects: Sequence[str],
        told: Callable[[Sequence[Marginal]], None],
    ):
        self.plain: dict[Explanation, Fit] = {}
        self.ends: dict[tuple[Explanation, float], _End] = {}
        self.told = told
        self.observations = {0.0: observations}
        self.small = small_effects(observations, fits[0], effects)
        for size in NARROWING:
            self._add(size)
        self.sizes = list(NARROWING)
        self.take(fits, 0.0)

    @property
    def marginals(self) -> list[Marginal]:
        """The evidence of everything."""
        return [end.evidence for end in self.ends.values()]

    def take(self, found: Sequence[Fit], size: float) -> None:
        """Note fits beside a size, of each explanation the best."""
        sound = [f for f in found if np.isfinite(f.objective)]
        ends = [_End(self._evidence(f, size), f.theta, f.nuisance, f.program) for f in sound]
        for fitted, end in zip(sound, ends, strict=True):
            key = fitted.explanation, size
            if key not in self.ends or end.evidence.objective < self.ends[key].evidence.objective:
                self.ends[key] = end
                if not size:
                    self.plain[fitted.explanation] = fitted
        self.told([end.evidence for end in ends])

    def _add(self, size: float) -> None:
        exact = self.observations[0.0]
        self.observations[size] = replace(exact, discrepancy=discrepancy(exact, size, self.small))

    def _evidence(self, fitted: Fit, size: float) -> Marginal:
        noise, exact = self.observations[size].whiten, self.observations[0.0].whiten
        return marginal(fitted, size, noise.log_volume - exact.log_volume)

    def known(self, size: float) -> dict[Explanation, float]:
        """What is weighed beside a size, with its log evidence."""
        return {e: end.evidence.log_z for (e, beside), end in self.ends.items() if beside == size}

    def beside_all(self, explanations: Sequence[Explanation]) -> None:
        """Weigh fitted explanations beside each size, the largest first: who is hopeless there, is so beside all."""
        remaining = list(explanations)
        self._weigh(self.sizes[0], remaining)
        for wider in WIDENING:
            if not self._widen(wider):
                break
            self._weigh(wider, remaining)
        for size in self.sizes:
            self._weigh(size, remaining)
            near = self._near(size)
            remaining = [e for e in remaining if e in near]

    def _widen(self, wider: float) -> bool:
        """Go on to a wider size where the best explanation beside the widest one is more probable; whether it is."""
        widest = self.sizes[0]
        known = self.known(widest)
        best = max(known, key=lambda e: known[e])
        self._add(wider)
        fitted = self._fitted(wider, best, widest)
        if self._evidence(fitted, wider).log_z > self.ends[best, widest].evidence.log_z:
            self.sizes.insert(0, wider)
            self.take([fitted], wider)
            return True
        del self.observations[wider]
        return False

    def bring(self, size: float) -> None:
        """Weigh beside a size what is among the best beside the next wider one, from where that ended."""
        for wider in [beside for beside in self.sizes if beside > size][-1:]:
            best = sorted(self._near(wider), key=lambda e: -self.ends[e, wider].evidence.log_z)[:SEVERAL]
            self.take(in_parallel([partial(self._fitted, size, e, wider) for e in best]), size)

    def best_laws(self, size: float) -> list[Marginal]:
        """The most probable laws beside a size; none where all are hopeless there."""
        laws = [m for m in self.marginals if m.discrepancy == size and not is_free_curve(m.explanation)]
        return [laws[int(np.argmax(log_posterior(laws)))]] if laws else []

    def leaders(self) -> list[Marginal]:
        """The most probable laws where forms may be wrong, and what may still win.

        That is the most probable free curve, with or without laws, and the best laws that are not the leader's with
        one more or fewer: which of two that are much alike acts may show only beside others.
        """
        searched = [m for m in self.marginals if m.discrepancy]
        log_p = dict(zip(searched, log_posterior(searched).tolist(), strict=True))
        ranked = sorted(log_p, key=lambda m: -log_p[m])
        laws = [m for m in ranked if not is_free_curve(m.explanation)]
        own = set(laws[0].explanation)
        others = [m for m in laws if not (own <= set(m.explanation) or own >= set(m.explanation))]
        curves = [m for m in ranked if is_free_curve(m.explanation)]
        may_win = [m for m in (*others[:1], *curves[:1]) if log_p[m] > log_p[ranked[0]] - BEHIND]
        return [laws[0], *may_win]

    def ground(self, found: Marginal) -> Ground:
        """What was found, fitted again beside its discrepancy."""
        size = found.discrepancy
        return Ground.of(self.observations[size], self._fitted(size, found.explanation, size))

    def is_wider_better(self, size: float) -> bool:
        """Whether all beside a size is hopeless against what a wider one has: beside a narrower one it is more so."""
        wider = [m.log_z for m in self.marginals if m.discrepancy > size]
        there = [m.log_z for m in self.marginals if m.discrepancy == size]
        return max(there, default=-np.inf) < max(wider, default=-np.inf) - HOPELESS

    def complete(self) -> None:
        """Weigh beside every size, and alone, what is not negligible."""
        considerable = self._considerable(NEGLIGIBLE)
        for size in (*self.sizes, 0.0):
            self._weigh(size, considerable)

    def with_changes(self) -> list[Marginal]:
        """The evidence of everything; how large each of several laws is, where they are not negligible.

        An explanation whose fit breaks down without a discrepancy has no model, and is left out; so is what was found
        beside one size and is negligible, which is fitted beside no other.
        """
        several = (e for e in self._considerable(STATED) if len(e) > 1 and not is_free_curve(e))
        laws = [e for e in several if e in self.plain]
        self._take_apart(laws)
        whole = [e for e in laws if {*rests(e)} <= self.plain.keys()]
        tasks = [partial(changes, self.plain[e], [self.plain[rest] for rest in rests(e)]) for e in whole]
        of = dict(zip(whole, in_parallel(tasks), strict=True))
        sound = (m for m in self.marginals if m.explanation in self.plain)
        return [m._replace(changes=of.get(m.explanation, ())) for m in sound]

    def _take_apart(self, explanations: Sequence[Explanation]) -> None:
        """Fit explanations without each of their laws, with exact forms."""
        exact, known = self.observations[0.0], self.known(0.0)
        found = chain.from_iterable(without_each(exact, self.plain[e], known) for e in explanations)
        self.take(best_of_each(found), 0.0)

    def _considerable(self, share: float) -> list[Explanation]:
        """What has at least this share of the probability of the best, beside some size."""
        log_p = log_posterior(self.marginals)
        enough = log_p.max() + np.log(share)
        return sorted(
            {m.explanation for m, p in zip(self.marginals, log_p.tolist(), strict=True) if p > enough}
        )

    def _weigh(self, size: float, explanations: Sequence[Explanation]) -> None:
        """Those that are not weighed beside a size, from where each ended beside the nearest."""
        tasks, done = [], self.known(size)
        for e in (e for e in explanations if e not in done):
            there = (beside for known, beside in self.ends if known == e)
            tasks.append(partial(self._fitted, size, e, min(there, key=lambda beside: abs(beside - size))))
        self.take(in_parallel(tasks), size)

    def _fitted(self, size: float, explanation: Explanation, begun: float) -> Fit:
        """Begun where the fit beside another size ended."""
        end = self.ends[explanation, begun]
        return fit(
            self.observations[size],
            explanation,
            end.theta,
            end.nuisance,
            warm=True,
            iterations=NEAR,
            tolerance=EXACT / max(1.0, end.evidence.objective),
            program=end.program,
        )

    def _near(self, size: float) -> set[Explanation]:
        """Explanations that are not hopeless beside a size."""
        log_z = self.known(size)
        return {e for e, value in log_z.items() if value > max(log_z.values()) - HOPELESS}


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
