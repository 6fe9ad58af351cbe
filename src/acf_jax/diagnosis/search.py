"""Which explanations are fitted: every single effect and free curve, then more effects together by forward search."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain

import numpy as np

from acf_jax.dataset import Trace
from acf_jax.diagnosis import candidates
from acf_jax.diagnosis.candidates import best_first, best_of_each
from acf_jax.diagnosis.proposals import Couple, couples, fit_couples
from acf_jax.inference.baseline import Ground
from acf_jax.inference.fit import Fit
from acf_jax.inference.noise_colour import colour, noise_level
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import RIG, Explanation, is_free_curve
from acf_jax.inference.scatter import with_scatter

# Each of these bounds the time that fits take, none the probability of what is fitted. Where single effects explain the
# data to a tenth, a free curve no better, and the rig as stated, pairs are tried beside the best; else beside many.
LEADERS = 3  # explanations from which the forward search goes on
UNEXPLAINED = 1.1  # chi-square of a sample above which single effects leave something
FAR = 1.5  # the same above which a fit leaves much
LEFT_BEHIND = 30.0  # chi-square by which a free curve beats every single effect where these leave something
STRAINED = 15.0  # squared prior std by which the rig of the best single effect hides something
PAIRS = 8  # that are fitted
BEGINNINGS = 6  # single effects from which pairs are tried where little is explained,
TRIED = 6  # and how many of those besides the best effect's
FURTHER = 2  # effects that are tried beside each single one where the best of those pairs still leaves much
HOPELESS = 4.0  # times the best misfit, from which on a glance is all that an explanation gets
WORTH_ONE_MORE = 6.0  # chi-square that one more effect has to promise before it is fitted


def fit_alone(
    observations: Observations,
    recalibrated: Fit,
    causes: Sequence[str],
    told: Callable[[Sequence[Fit]], None] = lambda fits: None,
) -> list[Fit]:
    """Every effect and free curve alone beside the recalibrated model.

    `causes`: the names of both. `told` is given fits as soon as they are there.
    """
    ground = Ground.of(observations, recalibrated)

    def glances(name: str) -> list[Fit]:
        found = candidates.glances(ground, name)
        told(found)
        return found

    wanted = [partial(glances, name) for (name,) in candidates.singles(causes)]
    return candidates.exchange_modes(
        observations, _carried_on(observations, candidates.in_parallel(wanted), told)
    )


def fit_together(
    observations: Observations,
    recalibrated: Fit,
    fits: Sequence[Fit],
    told: Callable[[Sequence[Fit]], None] = lambda fits: None,
) -> list[Fit]:
    """The fits of `fit_alone`, and the pairs that forward search finds from them."""
    alone = best_first(f for f in fits if not is_free_curve(f.explanation))
    better = 2 * (alone[0].objective - min(f.objective for f in fits))  # of a free curve than of any effect
    hidden = float((alone[0].u[: len(RIG)] ** 2).sum()) > STRAINED
    if _left(observations, alone) > UNEXPLAINED or better > LEFT_BEHIND or hidden:
        ground = Ground.of(observations, recalibrated)
        of_curves = [partial(candidates.fit_further, ground, f) for f in fits if is_free_curve(f.explanation)]
        fits = [*(f for f in fits if not is_free_curve(f.explanation)), *candidates.in_parallel(of_curves)]
        more = _try_all(observations, alone)
    else:
        near = [f for f in alone[:LEADERS] if _left(observations, [f]) < FAR]
        more = _grow(observations, near, [f.explanation[0] for f in alone])
    told(more)
    # a simulation that broke down at every start explains nothing
    return [f for f in (*fits, *more) if np.isfinite(f.objective)]


def settled(
    observations: Observations, fits: Sequence[Fit], approaches: Sequence[Trace]
) -> tuple[Observations, list[Fit]]:
    """The observations as the best fit of all shows noise and rings, and all fits as they are with these.

    The colour of the noise is told where the best fit leaves nothing else; not so where the noise is what repeats
    differ by, of which the samples before contact say nothing. Rings that the best fit has no need of are none.
    """
    best = candidates.best(fits)
    known = observations.noise
    if observations.peak_only.all() or known.source == "repeats":
        return observations, list(fits)
    left_more = 2 * best.objective > noise_level(observations.n_used, known.doubt)
    if left_more and not observations.rings:
        return observations, list(fits)
    noise = known if left_more else colour(observations, best, approaches)
    found = with_scatter(replace(observations, noise=noise), best)
    is_same = (noise.share, noise.correlation_time) == (known.share, known.correlation_time)
    if is_same and len(found.rings) >= len(observations.rings):
        return observations, list(fits)
    return found, candidates.in_parallel([partial(candidates.go_on, found, f, warm=True) for f in fits])


def _grow(observations: Observations, leaders: Sequence[Fit], effects: Sequence[str]) -> list[Fit]:
    """The leaders with one more effect: of all such pairs those that promise to fit best."""
    found = [c for leader in leaders for c in couples(Ground.of(observations, leader), effects)]
    wanted: dict[Explanation, Couple] = {}
    for couple in sorted(found, key=lambda c: c.objective):
        if couple.gain > WORTH_ONE_MORE and len(wanted) < PAIRS:
            wanted.setdefault(couple.explanation, couple)
    return fit_couples(list(wanted.values()))


def _try_all(observations: Observations, alone: Sequence[Fit]) -> list[Fit]:
    """The pairs that fit best after a glance: the best effect with each other one, and promising others.

    Far from the data a promise to first order says little, and from which of two effects a fit begins may decide it.
    """
    names = [f.explanation[0] for f in alone]
    known_couples: dict[Explanation, list[Couple]] = {}

    def couples_of(leaders: Sequence[Fit]) -> list[list[Couple]]:
        for leader in leaders:
            if leader.explanation not in known_couples:
                known_couples[leader.explanation] = couples(Ground.of(observations, leader), names)
        return [known_couples[f.explanation] for f in leaders]

    def promising(found: Iterable[Couple], most: int) -> list[Couple]:
        return sorted(found, key=lambda c: c.objective)[:most]

    of_first, *of_next = couples_of(alone[:BEGINNINGS])
    tried = [*of_first, *promising(chain(*of_next), TRIED)]
    best = _glance(tried)
    # an effect of the best pair may stand in for one much like it
    members = [f for f in alone if best and f.explanation[0] in best[0].explanation]
    known = {glance.explanation for glance in best}
    swaps = [
        c for c in chain(*couples_of(members)) if c.name in names[:LEADERS] and c.explanation not in known
    ]
    best = best_of_each([*best, *_glance(swaps)])
    if best and _left(observations, best) > FAR:
        done = {(c.ground.fitted.explanation, c.name) for c in (*tried, *swaps)}
        of_each = chain(*(promising(own, FURTHER) for own in couples_of(alone)))
        others = [c for c in of_each if (c.ground.fitted.explanation, c.name) not in done]
        best = best_of_each([*best, *_glance(others)])
    chosen = best[:PAIRS]  # the best first, so that those near it come before the others
    return _carried_on(observations, [[glance] for glance in chosen])


def _carried_on(
    observations: Observations,
    glances: Iterable[Sequence[Fit]],
    told: Callable[[Sequence[Fit]], None] = lambda fits: None,
) -> list[Fit]:
    """Of each explanation the best of its glances carried on to their ends, or as it is where all are hopeless."""
    of_each = [best_first(own) for own in glances]
    enough = HOPELESS * min((own[0].objective for own in of_each if own), default=np.inf)

    def end(own: Sequence[Fit]) -> Fit:
        near = [glance for glance in own if glance.objective < enough]
        if not near:
            return own[0]
        found = candidates.best(candidates.go_on(observations, glance) for glance in near)
        told([found])
        return found

    return candidates.in_parallel([partial(end, own) for own in of_each if own])


def _glance(wanted: Sequence[Couple]) -> list[Fit]:
    """Fits of a few iterations, the best of each explanation, the best first."""
    return best_of_each(fit_couples(wanted, candidates.GLANCE))


def _left(observations: Observations, fits: Iterable[Fit]) -> float:
    """Chi-square of a sample that the best of these fits leaves."""
    return 2 * min(f.objective for f in fits) / observations.n_used
