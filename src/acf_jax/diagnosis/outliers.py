"""Which trials are not to be believed although the look at the data found no fault: the fits say."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from acf_jax.diagnosis.candidates import best
from acf_jax.diagnosis.search import FAR
from acf_jax.inference.discrepancy import FORMS, discrepancy
from acf_jax.inference.fit import Fit, after_a_step, fit
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import is_free_curve

OUTLIER = 5.0  # a trial is left out where its misfit is this many times that of the others, and beyond chance
BEGINNING = 0.5  # of the time to its peak: what a trial shows there is no limit that it alone has gone beyond
ALONE = 2.0  # leaving out any other trial makes less than so much of a difference


def outliers(observations: Observations, fits: Sequence[Fit]) -> dict[str, str]:
    """Trials to leave out, with the reason: nothing fits because of one, or the best explanation does not fit them."""
    if len(observations.names) < 5:
        return {}
    fits = [f for f in fits if np.isfinite(f.objective)]
    ahead = best(fits)
    leaves_much = 2 * ahead.objective > FAR * observations.n_used
    found = _bends_every_fit(observations, fits) if leaves_much else {}
    return found or _misfits(observations, ahead)


def _misfits(observations: Observations, fitted: Fit) -> dict[str, str]:
    """Trials that the best explanation does not fit while it fits the others, nor does it beside inexact forms.

    What forms get wrong is largest where trials are fastest or hardest: that alone makes no fault of a trial.
    """
    ratio, chosen = _far_off(fitted)
    if chosen.size:
        o = replace(observations, discrepancy=discrepancy(observations, FORMS))
        beside = fit(o, fitted.explanation, fitted.theta, fitted.nuisance, warm=True, program=fitted.program)
        chosen = np.intersect1d(chosen, _far_off(beside)[1])
    usual = float(np.median(ratio))
    if len(chosen) > max(1, len(ratio) // 10):
        return {}
    # what every trial of a condition shows is physics, not a fault; so may be what one beyond all others does
    groups = [np.flatnonzero(observations.condition == observations.condition[i]) for i in chosen]
    physics = [
        (len(g) > 1 and np.isin(g, chosen).all()) or _may_be_a_limit(observations, int(i))
        for i, g in zip(chosen, groups, strict=True)
    ]
    return {
        observations.names[i]: "its misfit to the best explanation is"
        f" {ratio[i] / usual:.0f} times that of the others"
        for i in chosen[~np.array(physics, bool)]
    }


def _far_off(fitted: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Chi-square of a sample (trials,), and the trials, by index, where it is far above that of the others."""
    samples = np.maximum(fitted.observations.used.sum(1), 1)
    ratio = fitted.chi2 / samples
    usual = float(np.median(ratio))
    beyond = fitted.chi2 - usual * samples > 40 + 8 * usual * np.sqrt(2 * samples)
    return ratio, np.flatnonzero(beyond & (ratio > OUTLIER * usual))


def _bends_every_fit(observations: Observations, fits: Sequence[Fit]) -> dict[str, str]:
    """The one trial without which a single effect, or none, would fit all others far better.

    A wrong label or a loose cable among few trials bends every fit towards itself and then stands out in none. What it
    does to a fit is told to first order, as by deletion diagnostics of linear regression. A limit that this trial alone
    has gone beyond does so, too, but the trial begins like the others.
    """
    simple = [f for f in fits if len(f.explanation) < 2 and not is_free_curve(f.explanation)]
    whole, without = zip(*map(without_each, simple), strict=True)
    ratio = np.array(whole)[:, None] / np.array(without)
    k, i = np.unravel_index(int(ratio.argmax()), ratio.shape)
    others = np.delete(ratio[k], i)
    if ratio[k, i] < OUTLIER or others.max() > ALONE:
        return {}
    if _may_be_a_limit(observations, int(i)) and _begins_like_the_others(observations, simple[k], int(i)):
        return {}
    return {observations.names[i]: f"without it the others agree with a model {ratio[k, i]:.0f} times better"}


def _may_be_a_limit(observations: Observations, i: int) -> bool:
    """Whether trial `i` alone may have gone beyond a limit.

    No other condition as fast has as high and as low an F_P, and no repeat presses harder: a cable or a label that is
    wrong there makes a force too low.
    """
    o = observations
    repeats = o.condition == o.condition[i]
    f_p = o.f_p[(o.v_e >= o.v_e[i]) & ~repeats]
    is_hardest = not ((f_p >= o.f_p[i]).any() and (f_p <= o.f_p[i]).any())
    peaks = np.where(o.used, o.force, -np.inf).max(axis=1)
    return bool(is_hardest and peaks[i] == peaks[repeats].max())


def _begins_like_the_others(observations: Observations, fitted: Fit, i: int) -> bool:
    """Whether an explanation that is fitted to the others and to the beginning of trial `i` fits that beginning."""
    force, time = observations.force[i], observations.time[i]
    peak = time[np.where(observations.used[i], force, -np.inf).argmax()]
    begins = np.ones_like(observations.used)
    begins[i] = time < BEGINNING * peak
    used = observations.used & begins
    censored = None if observations.censored is None else observations.censored & begins
    again = fit(
        replace(observations, used=used, censored=censored),
        fitted.explanation,
        fitted.theta,
        program=fitted.program,
    )
    ratio = again.chi2 / np.maximum(used.sum(1), 1)
    return bool(ratio[i] < OUTLIER * np.median(ratio))


def without_each(fitted: Fit) -> tuple[float, np.ndarray]:
    """Chi-square of all trials after one more step of a fit, and (trials,) of the others without each of them."""
    everyone, about = np.arange(len(fitted.nuisance)), fitted.linearised()
    others = [after_a_step(fitted, about, np.delete(everyone, i)) for i in everyone]
    return after_a_step(fitted, about, everyone), np.array(others)
