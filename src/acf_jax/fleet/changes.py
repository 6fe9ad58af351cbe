"""What changed about a rig since earlier runs: its cause, or a parameter beyond what its uncertainty allows."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from acf_jax.evidence.posterior import UNKNOWN
from acf_jax.fleet.record import Change, Fleet, Rig
from acf_jax.report.words import name_of

CAUSE = "cause"
FALSE_ALARM = 0.05  # probability of any false alarm among all the trends of a run


class Trend(NamedTuple):
    """A parameter of one rig over the runs that had data of their own and the same explanation."""

    rig: str
    parameter: str
    unit: str
    run: np.ndarray  # number of the run
    value: np.ndarray
    std: np.ndarray
    sigmas: float  # the slope over the runs, in its standard deviations


def find_changes(runs: Sequence[Fleet]) -> tuple[list[Change], list[Trend]]:
    """Changes of the last of `runs`, the greatest first, and every trend behind them.

    A cause has changed where each of two data sets rules out the first explanation of the other: of two that the data
    cannot tell apart now one comes first and now the other, and better data may leave one. A cause outside the library
    is another one at another component. A parameter has changed where the slope of the weighted straight line through
    its values is further from zero than chance would bring any of all trends in one of twenty runs (Bonferroni). Every
    run has the same prior, which pulls all values towards one: the true slope is rather steeper. Two explanations
    have no parameter in common that means the same, so values are compared within one.
    """
    by_name = [{rig.rig: rig for rig in run.rigs if not rig.fault} for run in runs]
    histories = [_history(by_name, name) for name in by_name[-1]]
    causes = [
        Change(rig=after.rig, what=CAUSE, before=_named(before), after=_named(after))
        for history in histories
        if len(history) > 1
        and not _stands(before := history[-2][1], after := history[-1][1])
        and not _stands(after, before)
    ]
    trends = [trend for history in histories for trend in _trends(history)]
    trends.sort(key=lambda trend: -abs(trend.sigmas))
    limit = threshold(len(trends))
    changed = [
        Change(
            rig=t.rig, what=t.parameter, sigmas=float(f"{t.sigmas:.3g}"),
            before=_measured(t, 0), after=_measured(t, -1),
        )
        for t in trends if abs(t.sigmas) > limit
    ]  # fmt: skip
    return causes + changed, trends


def threshold(trends: int) -> float:
    """How many standard deviations the largest of so many trends without any cause stays below, 19 times of 20."""
    return float(-ndtri(FALSE_ALARM / 2 / max(1, trends)))


def _history(runs: Sequence[dict[str, Rig]], name: str) -> list[tuple[int, Rig]]:
    """The diagnoses of a rig with the numbers of their runs; data that were diagnosed again count once."""
    history: list[tuple[int, Rig]] = []
    for number, run in enumerate(runs):
        if name in run:
            if history and history[-1][1].data == run[name].data:
                number, _ = history.pop()
            history.append((number, run[name]))
    return history


def _stands(leader: Rig, rig: Rig) -> bool:
    """Whether the data of `rig` leave the first explanation of `leader` standing.

    Where there is no gap, what stands beside it is too weak to matter: no data rule that out, and it is no cause.
    """
    if leader.first == rig.first == UNKNOWN:
        return leader.component in (rig.component, *rig.components)
    return leader.first == rig.first or (rig.verdict != "no_gap" and leader.first in rig.credible)


def _trends(history: Sequence[tuple[int, Rig]]) -> list[Trend]:
    rig = history[-1][1]
    alike = [(number, r) for number, r in history if _explanation(r) == _explanation(rig)]
    trends = []
    for name, estimate in rig.parameters.items():
        known = [(n, p) for n, r in alike if (p := r.parameters.get(name)) and p.std and not p.at_bound]
        if len(known) > 1 and known[-1][1] is estimate:
            run = np.array([number for number, _ in known])
            value = np.array([p.value for _, p in known])
            std = np.array([p.std for _, p in known], float)
            trends.append(Trend(rig.rig, name, estimate.unit, run, value, std, _slope(run, value, std)))
    return trends


def _slope(run: np.ndarray, value: np.ndarray, std: np.ndarray) -> float:
    """Slope of the weighted straight line over its standard deviation; of two values, their difference over its own."""
    weight = std**-2
    lever = run - (weight * run).sum() / weight.sum()
    return float((weight * lever * value).sum() / np.sqrt((weight * lever**2).sum()))


def _explanation(rig: Rig) -> tuple[tuple[str, ...], str | None]:
    """The first explanation; where it is outside the library, with its component."""
    return rig.first, rig.component if rig.first == UNKNOWN else None


def _named(rig: Rig) -> str:
    effects, component = _explanation(rig)
    try:
        return name_of(effects) + (f" at the {component}" if component else "")
    except KeyError:  # an effect of another version
        return " and ".join(effects)


def _measured(trend: Trend, index: int) -> str:
    unit = "" if trend.unit == "1" else f" {trend.unit}"
    return f"{trend.value[index]:.4g} ± {trend.std[index]:.2g}{unit}"
