"""Fitting the candidate explanations: single effects and free curves, and one more effect beside a fit."""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TypeVar

import numpy as np

from acf_jax.effects import AbstractOscillator, library
from acf_jax.inference.baseline import Ground, Promise, one_more, with_one_more
from acf_jax.inference.fit import ITERATIONS, TOLERANCE, Fit, fit
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import (
    RIG,
    Explanation,
    begin,
    classes,
    is_free_curve,
    parameters,
    starts,
)

LITTLE = 2.0  # chi-square of a sample below which the recalibrated model leaves little
HINT = 2.0  # chi-square that a start beside the recalibrated model has to promise
# frequencies that fits begin from, of those that promise most: samples alone do not tell them apart
VALLEYS = 3
GLANCE = 6  # iterations after which fits that begin apart are compared
ROUGHLY = 1e-4  # tolerance of a free curve's fit: a little more of chi-square says nothing of it
WORKERS = 2  # a fit keeps one core busy; compilation and simulation run outside Python's lock

Result = TypeVar("Result")


def fit_nominal(observations: Observations) -> Fit:
    """The paper's model with its own parameters refitted."""
    return fit(observations, (), begin(observations.prior.values))


def unfitted(observations: Observations) -> Fit:
    """The paper's model at the rig's prior values."""
    return fit(observations, (), begin(observations.prior.values), warm=True, iterations=0)


def fit_single(ground: Ground, name: str) -> Fit:
    """One effect or free curve added to the paper's model, whose fit is the `ground`: glances, carried on."""
    return best(go_on(ground.observations, glance) for glance in glances(ground, name))


def glances(ground: Ground, name: str) -> list[Fit]:
    """Short fits of one effect or free curve added to the paper's model, whose fit is the `ground`.

    Of an effect the best of its starts; each of a free curve, and where frequencies are ambiguous: how well these do
    shows late.

    An effect's own starts begin at the rig's prior, and more at the recalibrated model with what explains most of
    what it leaves, scaled and as it was looked for, where that is none of the starts. Where it leaves little, the
    answer is a small step from it: there all starts begin at the recalibrated model, and only the strongest at the
    prior, too. Where it leaves much, its rig has taken up what the effect does, and what was looked for begins at the
    prior as well. A free curve begins with its first start at the prior and with the one that promises most at the
    recalibrated model, so that it never explains less than that.
    """
    begins, promises = starts(name, ground.observations.measures), promised(ground, name)
    if name in library():
        found: list[list[float]] = []
        for promise in (p for p in promises if p.gain > HINT):
            for start in (promise.parameters.tolist(), promise.start):
                if start not in (*begins, *found):  # what is scaled is often what explains most as it is
                    found = [*found, start]
        if _leaves_little(ground):
            far, near = begins[-1:], [*begins, *found]
        else:
            far, near = [*begins, *found], found
        fits = _glances_from(ground, name, far, near)
        return fits if len(promises) > 1 else [best(fits)]
    return _glances_from(ground, name, begins[:1], [promises[0].start])


def promised(ground: Ground, name: str) -> list[Promise]:
    """What fits with an effect may begin with: what promises most, and other frequencies that promise something."""
    first, *others = ground.promises(name)
    return [first, *(p for p in others[: VALLEYS - 1] if p.gain > HINT)]


def fit_further(ground: Ground, fitted: Fit) -> Fit:
    """The fit of a free curve, or a better one from its other starts, where it has any.

    Where a kink lies, or how fast a ripple is, parts the valleys of its misfit. So fits from every start get a glance,
    at the recalibrated model where that leaves little and else at the prior, and the best is carried on.
    """
    (name,) = fitted.explanation
    begins = starts(name, ground.observations.measures)
    far, near = ([], begins) if _leaves_little(ground) else (begins, [])
    ahead = best(_glances_from(ground, name, far, near))
    return best([fitted, go_on(ground.observations, ahead)])


def _leaves_little(ground: Ground) -> bool:
    return 2 * ground.fitted.objective < LITTLE * ground.observations.n_used


def _glances_from(
    ground: Ground, name: str, far: Sequence[Sequence[float]], near: Sequence[Sequence[float]]
) -> list[Fit]:
    """Short fits of one effect or free curve from starts at the prior (`far`) and the recalibrated rig (`near`)."""
    observations, nominal = ground.observations, ground.fitted
    at_prior = [begin(observations.prior.values, start) for start in far]
    at_nominal = [np.concatenate([nominal.theta[: len(RIG)], start, nominal.common]) for start in near]
    fit_it = partial(fit, observations, (name,), iterations=GLANCE, tolerance=_tolerance((name,)))
    return [fit_it(theta) for theta in at_prior] + [
        fit_it(theta, nominal.nuisance, warm=True) for theta in at_nominal
    ]


def _tolerance(explanation: Explanation) -> float:
    return ROUGHLY if is_free_curve(explanation) else TOLERANCE


def exchange_modes(observations: Observations, fits: Sequence[Fit]) -> list[Fit]:
    """The fits, those of a single oscillator begun anew at the modes where others ended, too.

    Near the sampling rate the misfit has many valleys, and which of them a fit ends in hangs on the law.
    """
    of_mode = {f.explanation: f for f in fits if _is_oscillator(f.explanation)}
    begins = [(e, other) for e in of_mode for other in of_mode.values() if other.explanation != e]
    found = in_parallel([partial(_begun_at_mode_of, observations, e, other) for e, other in begins])
    better = [f for f in found if f.objective < of_mode[f.explanation].objective]
    ended = in_parallel([partial(go_on, observations, f, warm=True) for f in better])
    return [best([f, *(e for e in ended if e.explanation == f.explanation)]) for f in fits]


def _is_oscillator(explanation: Explanation) -> bool:
    return len(explanation) == 1 and issubclass(classes(explanation)[0], AbstractOscillator)


def _begun_at_mode_of(observations: Observations, explanation: Explanation, other: Fit) -> Fit:
    """A glance from the rig and the mode where another oscillator's fit ended."""
    (mine,), (law,) = classes(explanation), classes(other.explanation)
    assert issubclass(mine, AbstractOscillator) and issubclass(law, AbstractOscillator)
    omega, zeta = map(float, law(*other.physical[len(RIG) :]).mode())
    if not np.isfinite([omega, zeta]).all():  # the other one has no strength, so no mode
        return other
    theta = np.concatenate([other.theta[: len(RIG)], mine.of_mode(omega, zeta), other.common])
    return fit(observations, explanation, theta, other.nuisance, warm=True, iterations=GLANCE)


def fit_more(
    ground: Ground,
    name: str,
    begins: Sequence[np.ndarray],
    iterations: int = ITERATIONS,
    near: bool = False,
    program: Explanation | None = None,
) -> Fit:
    """A fit with one more effect, begun where that promises something and at its strong start.

    `begins`: `Promise.parameters` of each promise. `near`: the fit leaves so little that what was promised is near the
    answer: it begins there alone.
    """
    observations, fitted = ground.observations, ground.fitted
    explanation = one_more(fitted.explanation, name, ground.instead_of)
    strong = np.array(starts(name, observations.measures)[-1])
    thetas = with_one_more(fitted, name, begins if near else [strong, *begins], ground.instead_of)
    found = best(
        fit(observations, explanation, theta, fitted.nuisance, near, iterations, program=program)
        for theta in thetas
    )
    return found if iterations == GLANCE else with_sought(found)


def with_sought(fitted: Fit) -> Fit:
    """The fit, or a better one where a law of it has a strength that is sought, as of a second mode.

    Whether that is needed shows once the rest is fitted: at many values of its shape the misfit has a valley.
    """
    found = fitted
    for name, p in parameters(fitted.explanation):
        if p.over:
            shape, looks = p.over
            law = name.split(".")[0]
            promise = Ground.of(found.observations, found).sought(name, f"{law}.{shape}", looks)
            if promise.gain > HINT:
                found = best([found, _from(found, promise.parameters)])
    return found


def _from(fitted: Fit, theta: np.ndarray) -> Fit:
    """A fit begun near the end of another one."""
    o = fitted.observations
    return fit(o, fitted.explanation, theta, fitted.nuisance, warm=True, program=fitted.program)


def go_on(observations: Observations, fitted: Fit, warm: bool = False) -> Fit:
    """A fit carried on that was ended early, or (`warm`) that ended under another noise."""
    found = fit(
        observations,
        fitted.explanation,
        fitted.theta,
        fitted.nuisance,
        warm=warm,
        tolerance=_tolerance(fitted.explanation),
        program=fitted.program,
    )
    return with_sought(found)


def best(fits: Iterable[Fit]) -> Fit:
    """The fit with the lowest objective; of equals the first."""
    return min(fits, key=lambda f: f.objective)


def best_first(fits: Iterable[Fit]) -> list[Fit]:
    """The fits that did not break down, the best first."""
    return sorted((f for f in fits if np.isfinite(f.objective)), key=lambda f: f.objective)


def best_of_each(fits: Iterable[Fit]) -> list[Fit]:
    """The best fit of each explanation, the best first."""
    found: dict[Explanation, Fit] = {}
    for one in best_first(fits):
        found.setdefault(one.explanation, one)
    return list(found.values())


def in_parallel(tasks: Sequence[Callable[[], Result]]) -> list[Result]:
    """Run tasks on all workers, results in the order of the tasks."""
    with ThreadPoolExecutor(WORKERS) as pool:
        return list(pool.map(lambda task: task(), tasks))


def singles(causes: Sequence[str]) -> list[Explanation]:
    """Every effect and free curve alone; what takes longest comes first, so that no core waits for the last."""
    alone: list[Explanation] = [(name,) for name in causes]
    return sorted(alone, key=lambda explanation: -len(parameters(explanation)))
