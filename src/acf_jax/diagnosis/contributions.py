"""What the recalibrated model's gap is made of: cause by cause, what no law explains, and what differs between repeats.

All of it is told on conditions that no fit saw. With T the mean square of what the recalibrated model misses there, L
that of the corrected model and F that of what no model can predict, the effects explain T - L together, the background
is L - F, the scatter F. Several effects share their part by what each adds to the prediction, averaged over the orders
of adding (Shapley, 'A value for n-person games', 1953), as if they acted on one another in pairs.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from acf_jax.diagnosis.candidates import best, in_parallel
from acf_jax.diagnosis.heldout import HeldOut
from acf_jax.diagnosis.shrinkage import ENDS, resample
from acf_jax.evidence.posterior import Scored
from acf_jax.inference.baseline import Ground
from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import RIG, Explanation, component_of, is_free_curve, places, rests

BACKGROUND, SCATTER = "background", "scatter"
ENOUGH = 1e-3  # share of the objective that an iteration has to gain: shares of the gap need no more digits
RESAMPLES = 1000  # of the bootstrap: the ends of an interval are known to a few hundredths of its width


@dataclass(frozen=True)
class Contribution:
    """One part of the gap."""

    name: str  # of an effect, or BACKGROUND or SCATTER
    share: float  # of the mean square force error; those of all parts add up to 1
    ci95: tuple[float, float]
    force_rms_n: float
    peak_n: float  # RMS over conditions
    of_condition: tuple[float, ...]  # N RMS, force, in the order of condition numbers
    component: dict[str, float] | None = None  # where the background acts


def contributions(
    observations: Observations,
    fits: Sequence[Fit],
    corrected: Fit,
    held: dict[str, HeldOut],
    left_elsewhere: np.ndarray | None,
    scored: Sequence[Scored],
    component: dict[str, float],
    effects: Sequence[str],
    seed: int,
) -> tuple[Contribution, ...]:
    """The effects of the first explanation, the background, the scatter.

    **Arguments:** `fits`: the recalibrated model first. `held`: predictions of held-out conditions by `recalibrated`
    and `corrected`. `left_elsewhere`: draws of what the second leaves of the gap of the first, in mean squares; None
    where there is none. `scored`: what effects of the corrected model explain, which the first explanation does
    not name, is shared by those that it names; an effect's interval begins at zero as far as explanations without it
    are probable. `component`: where an unknown cause acts, told by the free curves. `effects`: those that may act on
    this rig.

    **Returns:** nothing where there are no traces, where all trials have one condition, or where the recalibrated model
    misses nothing.
    """
    o = observations
    used, groups = o.traced, np.unique(o.condition)
    if not used.any() or len(groups) < 2:
        return ()
    named = [name for name in corrected.explanation if name in scored[0].explanation]
    after = held["corrected"] if named else held["recalibrated"]

    def sums(values: np.ndarray) -> np.ndarray:
        return np.array([values[used & (o.condition == g)[:, None]].sum() for g in groups])

    before, left, floor = (
        sums(v) for v in (held["recalibrated"].residual ** 2, after.residual**2, after.floor)
    )
    samples = sums(np.ones_like(o.force))
    if before.sum() <= 0:
        return ()
    changes = _changes(o, fits, corrected, named) if named else []
    gap = held["recalibrated"].residual
    by_effect = np.array([sums(change * gap) for change in changes]).reshape(len(named), len(groups))
    drawn = np.concatenate([np.arange(len(groups))[None], resample(len(groups), seed, RESAMPLES)])
    of_before, of_left, of_floor, of_effects = (
        v[..., drawn].sum(-1) for v in (before, left, floor, by_effect)
    )
    if left_elsewhere is not None:
        ratio = np.random.default_rng(seed).choice(left_elsewhere, RESAMPLES)
        of_left[1:] = of_floor[1:] + ratio * np.maximum(of_before - of_floor, 0.0)[1:]
    shares = _shares(of_before, of_left, of_floor, of_effects)
    alone = _shares(before, left, floor, by_effect)
    peaks = _peaks(o, after, changes)
    rms = np.sqrt(alone * before / np.maximum(samples, 1))
    result = []
    for k, name in enumerate((*named, BACKGROUND, SCATTER)):
        absent = 1 - sum(s.probability for s in scored if name in s.explanation) if name in named else 0.0
        low, high = _interval(shares[k, 1:], absent)
        value = float(shares[k, 0])
        force = float(np.sqrt(value * before.sum() / samples.sum()))
        where = _component(o, corrected, component, effects) if name == BACKGROUND else None
        result.append(
            Contribution(
                name,
                value,
                (min(low, value), max(high, value)),
                force,
                peaks[k],
                tuple(map(float, rms[k])),
                where,
            )
        )
    return tuple(result)


def _shares(before: np.ndarray, left: np.ndarray, floor: np.ndarray, by_effect: np.ndarray) -> np.ndarray:
    """(effects + 2, n) of n sums of squares; an effect that makes the prediction worse takes no part."""
    part = np.maximum(by_effect, 0.0)
    total = part.sum(0)
    part = np.where(total > 0, part / np.where(total > 0, total, 1.0), 1 / max(len(by_effect), 1))
    left = np.minimum(left, before) if len(by_effect) else before
    scatter = np.minimum(floor, left)
    return np.asarray(
        np.vstack([part * (before - left), left - scatter, scatter]) / np.maximum(before, 1e-300)
    )


def _interval(draws: np.ndarray, absent: float) -> tuple[float, float]:
    """95 % interval of a share that is zero with the probability `absent`, and else one of the draws."""
    there = max(1 - absent, 1e-9)
    low = float(np.quantile(draws, (ENDS[0] - absent) / there)) if absent < ENDS[0] else 0.0
    return low, float(np.quantile(draws, max((ENDS[1] - absent) / there, 0.0)))


def _changes(o: Observations, fits: Sequence[Fit], corrected: Fit, named: Sequence[str]) -> list[np.ndarray]:
    """(trials, n) N, of each of some effects by what it changes the prediction: the mean of added first and last.

    That is its Shapley value as long as effects act on one another in pairs.
    """
    effects = corrected.explanation
    without = {name: rest for name, rest in zip(effects, rests(effects), strict=True) if name in named}
    known = {f.explanation: f for f in fits} | {effects: corrected}
    wanted = {(), effects, *without.values(), *((name,) for name in named)}
    missing = sorted(wanted - known.keys())
    found = in_parallel([partial(_without_others, o, corrected, s) for s in missing])
    known |= dict(zip(missing, found, strict=True))
    force = {s: known[s].as_commanded() for s in wanted}
    return [(force[(name,)] - force[()] + force[effects] - force[rest]) / 2 for name, rest in without.items()]


def _without_others(o: Observations, corrected: Fit, effects: Explanation) -> Fit:
    """A fit of some of a fit's effects, from its parameters and from its rig's prior."""
    kept = corrected.physical[places(effects, corrected.explanation)]
    begins = kept, np.concatenate([o.prior.values, kept[len(RIG) :]])
    again = partial(fit, o, effects, tolerance=ENOUGH, program=corrected.program)
    return best(again(np.append(begin, corrected.common), corrected.nuisance) for begin in begins)


def _peaks(o: Observations, after: HeldOut, changes: Sequence[np.ndarray]) -> list[float]:
    """N RMS over trials at the measured peak: by each effect, by the background, by scatter."""
    traces = np.flatnonzero(o.traced.any(1))
    top = np.where(o.traced, o.force, -np.inf)[traces].argmax(1)
    at = (traces, top)
    scatter = float(after.floor[at].mean())
    left = max(float((after.residual[at] ** 2).mean()) - scatter, 0.0)
    return [float(np.sqrt((c[at] ** 2).mean())) for c in changes] + [
        float(np.sqrt(left)),
        float(np.sqrt(scatter)),
    ]


def _component(
    o: Observations, corrected: Fit, unknown: dict[str, float], effects: Sequence[str]
) -> dict[str, float]:
    """Where the background acts: by what the effects of each component promise to explain of it at most."""
    if is_free_curve(corrected.explanation):
        total = sum(unknown.values())
        return {name: p / total for name, p in unknown.items()} if total > 0 else dict(unknown)
    ground = Ground.of(o, corrected)
    others = [name for name in effects if name not in corrected.explanation]
    promised = in_parallel([partial(ground.promise, name) for name in others])
    gains = {component_of(name): 0.0 for name in effects}
    for name, promise in zip(others, promised, strict=True):
        where = component_of(name)
        gains[where] = max(gains[where], promise.gain)
    total = sum(gains.values())
    shares = {name: gain / total if total > 0 else 1 / len(gains) for name, gain in gains.items()}
    return {name: shares.get(name, 0.0) for name in unknown}
