"""Whether one trial agrees with the others, without a model of the rig.

At a fixed time the force of a linear rig is linear in contact velocity and pretension (paper, Eqs. 5 to 8),
and that of a mildly nonlinear one is a low polynomial. So each trial is compared with what a polynomial in
the condition, fitted to the other trials at the same time after contact, says it should be.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acf_jax.dataset.phase import ImpactPhase
from acf_jax.dataset.trials import Array, Trial

Indices = NDArray[np.intp]

# Scores and trigger offsets, s, of the trials with these indices, shape (M,), should their force be that
# expected, shape (times, M).
Misfit = Callable[[Array, Indices], tuple[Array, Array]]

_POINTS = 80  # times at which trials are compared
FAR = 0.04  # of the peak: a fault of one trace is at least so much
_CLEAR = 0.08  # share of the peak by which a faulty trial misses, at least
_CLEAR_LABEL = 0.015  # the same where another condition of the set explains the trial
_RATIO = 6.0  # and against the median of the other trials


@dataclass(frozen=True)
class Agreement:
    """How a trial agrees with the others."""

    score: float  # RMS misfit over peak, beyond what noise, trigger and spread of the condition allow
    trigger_offset: float | None  # s, against the other trials; > 0: its impact comes late
    fault: str | None
    is_label: bool = False  # whether the fault is its label: another condition of the set explains the trial


def compare(
    trials: Sequence[Trial], phases: Sequence[ImpactPhase | None], noise_std: float, spread: float
) -> list[Agreement]:
    """Compare every trial with the others by traces, or by peaks where there are none.

    **Arguments:** `trials`: the trials, those faulty by themselves left out. `phases`: their impact phases; None
    for a trial without a trace. `noise_std`: noise of one sample, N. `spread`: relative standard deviation of
    velocity and pretension, trial to trial.
    """
    result = [Agreement(0.0, None, None) for _ in trials]
    traced = [i for i, phase in enumerate(phases) if phase is not None]
    others = [i for i, phase in enumerate(phases) if phase is None]
    for members, judge in ((traced, _by_traces), (others, _by_peaks)):
        if len(members) >= 5:
            judged = judge([trials[i] for i in members], [phases[i] for i in members], noise_std, spread)
            for i, agreement in zip(members, judged, strict=True):
                result[i] = agreement
    return result


def show_the_same(
    one: Trial, other: Trial, phases: tuple[ImpactPhase, ImpactPhase], noise_std: float, spread: float
) -> bool:
    """Whether the trace of a repeat has the shape of a trial's own: nowhere far off it.

    Far is what a single trace may show as a fault, and beyond noise, trigger and spread of the condition.
    """
    time, force = _in_contact(one, phases[0])
    time_there, there = _in_contact(other, phases[1])
    reach = 1.5 * max(float(np.median(np.diff(t))) if t.size > 1 else 0.0 for t in (time, time_there))
    low, high = np.searchsorted(time_there, time - reach), np.searchsorted(time_there, time + reach, "right")
    top = float(np.nanmax(force, initial=0.0))
    allowed = FAR * top + 4.0 * (spread * top + noise_std)
    compared = [(f, there[a:b]) for f, a, b in zip(force, low, high, strict=True) if b > a and np.isfinite(f)]
    return bool(compared) and all(x.min() - allowed <= f <= x.max() + allowed for f, x in compared)


def _in_contact(trial: Trial, phase: ImpactPhase) -> tuple[Array, Array]:
    """Times, s, and forces, N, from first contact on, what the unloaded sensor reads taken off."""
    assert trial.trace is not None
    part = slice(phase.start, max(phase.stop + 3, phase.start + 1))
    return trial.trace.time[part], trial.trace.force[part] - phase.offset


def _by_traces(
    trials: list[Trial], phases: list[ImpactPhase | None], noise_std: float, spread: float
) -> list[Agreement]:
    grid, force = _on_grid(trials, phases)
    slope = np.gradient(force, grid, axis=0) if grid.size > 1 else np.zeros_like(force)
    peaks = np.array([phase.height for phase in phases if phase])
    steps = np.array([t.trace.step for t in trials if t.trace])

    def misfit(expected: Array, index: Indices) -> tuple[Array, Array]:
        rest, changing, step = force[:, index] - expected, slope[:, index], steps[index]
        late = np.array([_delay(*of_one) for of_one in zip(rest.T, changing.T, expected.T, strict=True)])
        rest = rest + np.clip(late[:, 0], -1.5 * step, 1.5 * step) * np.nan_to_num(changing)
        allowed = 3.0 * noise_std + 4.0 * spread * np.abs(expected)
        beyond = np.maximum(np.abs(rest) - allowed, 0.0) / peaks[index]
        known = (late[:, 1] < 0.2 * step) & (np.abs(late[:, 0]) < 3.0 * step)
        return _rms(beyond), np.where(known, late[:, 0], np.nan)

    return _judge(trials, force, misfit)


def _by_peaks(
    trials: list[Trial], phases: list[ImpactPhase | None], noise_std: float, spread: float
) -> list[Agreement]:
    peaks = np.array([trial.peak_force or 0.0 for trial in trials])

    def misfit(expected: Array, index: Indices) -> tuple[Array, Array]:
        own = peaks[index]
        rest = np.abs(own - np.sqrt(np.maximum(expected[0], 0.0)))
        beyond = np.maximum(rest - 3.0 * noise_std - 4.0 * spread * own, 0.0)
        return beyond / np.maximum(own, np.median(peaks)), np.full(own.shape, np.nan)

    # F_max^2 is near F_P^2 + k_C m v^2: a polynomial in the squares, where F_max is none.
    return _judge(trials, (peaks**2)[None], misfit, squared=True)


def _judge(trials: list[Trial], values: Array, misfit: Misfit, squared: bool = False) -> list[Agreement]:
    """Set the worst trial aside and fit the others again, as long as the worst stands out."""
    conditions = np.array([trial.condition for trial in trials])
    basis = _basis(conditions**2 if squared else conditions)
    if basis is None:
        return [Agreement(0.0, None, None) for _ in trials]
    everyone = np.arange(len(trials))
    places = np.unique(conditions, axis=0, return_index=True)[1]
    weights = np.ones(len(trials))
    likely: dict[int, int | None] = {}
    fitted = _left_out(basis, values, weights)
    scores, late = misfit(fitted, everyone)
    for _ in range(max(len(trials) // 5, 1)):
        worst = _worst(basis, values, weights, misfit, scores, fitted)
        weights[worst] = 0.0
        fitted = _left_out(basis, values, weights)
        without = misfit(fitted, everyone)
        own = float(np.nan_to_num(without[0][worst]))
        other, place = _elsewhere(fitted, misfit, worst, places)
        mistaken = own > _CLEAR_LABEL and other < 0.2 * own and other < 0.005
        if not (mistaken or own > _limit(without[0], weights)):
            break
        scores, late = without
        likely[worst] = place if mistaken else None
    agreements = []
    for i in range(len(trials)):
        fault = None
        if i in likely:
            alike = likely[i]
            hint = "cable or sensor?"
            if alike is not None:
                velocity, pretension = trials[alike].condition
                hint = f"wrong label? it looks like a trial at {velocity:g} m/s and {pretension:g} N"
            fault = f"it differs from the other trials by {100.0 * scores[i]:.0f} % of its peak ({hint})"
        offset = float(late[i]) if np.isfinite(late[i]) and np.isfinite(scores[i]) else None
        is_label = likely.get(i) is not None
        agreements.append(Agreement(float(np.nan_to_num(scores[i])), offset, fault, is_label))
    return agreements


def _worst(basis: Array, values: Array, weights: Array, misfit: Misfit, scores: Array, fitted: Array) -> int:
    """Of the few trials that differ most, the one without which the others agree best.

    A faulty trial of much leverage spoils what is expected of its neighbours, so the largest score may be
    theirs; so it may where a force is far too large, for a score is a share of the trial's own peak.
    """
    known = (weights > 0.0) & np.isfinite(scores)
    away = np.nan_to_num(np.abs(values - fitted)).sum(0)
    most = [np.argsort(-np.where(known, by, -1.0), kind="stable")[:4] for by in (scores, away)]
    candidates = list(dict.fromkeys(np.concatenate(most).tolist()))
    rest = []
    for i in candidates:
        without = weights.copy()
        without[i] = 0.0
        left, _late = misfit(_left_out(basis, values, without), np.arange(len(weights)))
        rest.append(float(np.nansum(np.minimum(left * without, 1.0))))
    return int(candidates[int(np.argmin(rest))])


def _elsewhere(fitted: Array, misfit: Misfit, index: int, places: Indices) -> tuple[float, int]:
    """The score of trial `index`, set aside, at the best of the conditions at `places`, and which that is."""
    fits = misfit(fitted[:, places], np.full(places.size, index))[0]
    found = [(float(fit), int(j)) for fit, j in zip(fits, places, strict=True) if np.isfinite(fit)]
    return min(found, default=(float(np.inf), index))


def _limit(scores: Array, weights: Array) -> float:
    """The score above which a trial is faulty, set by those that are kept."""
    others = scores[(weights > 0.0) & np.isfinite(scores)]
    return max(_CLEAR, _RATIO * float(np.median(others))) if others.size >= 3 else np.inf


def _basis(conditions: Array) -> Array | None:
    """Columns of a polynomial in velocity and pretension that the conditions can carry, shape (trials, P)."""
    distinct = len(np.unique(conditions, axis=0))
    v, p = (conditions / np.maximum(conditions.max(0), 1e-12)).T
    columns: list[Array] = []
    for candidate in (v, p, v * v, v * p, np.ones_like(v)):
        trial = np.stack([*columns, candidate], axis=1)
        if len(columns) < distinct - 2 and np.linalg.matrix_rank(trial, tol=1e-6) == trial.shape[1]:
            columns.append(candidate)
    return np.stack(columns, axis=1) if len(columns) >= 2 else None


def _left_out(basis: Array, values: Array, weights: Array) -> Array:
    """What the other trials say about each, shape (times, trials); NaN where they say too little."""
    present = np.isfinite(values) * weights
    normal = np.einsum("gi,ia,ib->gab", present, basis, basis)
    ridge = 1e-9 * np.eye(basis.shape[1]) * (1.0 + np.trace(normal, axis1=1, axis2=2)[:, None, None])
    inverse = np.linalg.inv(normal + ridge)
    filled = np.nan_to_num(values)
    coefficients = np.einsum("gab,gi,ib,gi->ga", inverse, present, basis, filled)
    fitted = coefficients @ basis.T
    leverage = np.einsum("ia,gab,ib->gi", basis, inverse, basis)
    own = present * leverage
    with np.errstate(divide="ignore", invalid="ignore"):
        expected = np.where(present > 0.0, (fitted - own * filled) / (1.0 - own), fitted)
    enough = present.sum(1, keepdims=True) - present >= basis.shape[1] + 1
    return np.where(enough & (np.where(present > 0.0, own, leverage) < 0.75), expected, np.nan)


def _on_grid(trials: list[Trial], phases: list[ImpactPhase | None]) -> tuple[Array, Array]:
    """Common times, s, shape (G,), and each trial's force in contact there, N, shape (G, trials).

    Without what the unloaded sensor reads, and without what is cut off: that is a lower bound only.
    """
    contacts = [(t.trace, p) for t, p in zip(trials, phases, strict=True) if t.trace and p]
    ends = np.array([trace.time[phase.stop - 1] for trace, phase in contacts])
    step = max(trace.step for trace, _ in contacts)
    grid = np.linspace(2.0 * step, max(float(np.quantile(ends, 0.9)), 3.0 * step), _POINTS)
    force = np.full((grid.size, len(contacts)), np.nan)
    for i, (trace, phase) in enumerate(contacts):
        held = grid <= ends[i]
        part = slice(phase.start, phase.stop)
        readings = trace.force[part]
        if phase.cut_off is not None:
            readings = np.where(readings < phase.cut_off, readings, np.nan)
        force[held, i] = np.interp(grid[held], trace.time[part], readings) - phase.offset
    return grid, force


def _delay(rest: Array, slope: Array, expected: Array) -> tuple[float, float]:
    """By how much a trial comes late, s, and the standard deviation of that, its size fitted as well."""
    held = np.isfinite(rest + slope + expected)
    if held.sum() < 10:
        return 0.0, np.inf
    columns = np.stack([-slope[held], expected[held]], axis=1)
    normal = columns.T @ columns
    if np.linalg.cond(normal) > 1e10:
        return 0.0, np.inf
    inverse = np.linalg.inv(normal)
    solution = inverse @ columns.T @ rest[held]
    left = rest[held] - columns @ solution
    # Neighbouring grid points share their misfit: count one in five as independent.
    return float(solution[0]), float(np.sqrt(5.0 * np.mean(left**2) * inverse[0, 0]))


def _rms(values: Array) -> Array:
    """RMS over the first axis, NaN left out; NaN where fewer than five values are left."""
    counts = np.isfinite(values).sum(0)
    total = np.nansum(values**2, axis=0)
    return np.where(counts >= 5, np.sqrt(total / np.maximum(counts, 1)), np.nan)
