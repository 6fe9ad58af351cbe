"""Whether data can be trusted: one line that leads, and what limits an answer from them, each with its remedy."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from acf_jax.dataset.look import TrialQuality
from acf_jax.dataset.noise import Noise
from acf_jax.dataset.trials import GapDataset

MISSED = 0.02  # of a peak, that sampling may miss without a word
MISSED_BY_ADVICE = 0.005  # of a peak, at the rate that is advised
FEWEST, FEWEST_CONDITIONS = 5, 4  # below which trials cannot be compared with each other
SHOWN = 3  # reasons in one line
APART = 0.05  # relative, below which two speeds tell no more than one, whatever their stated spread
RATE, SATURATION, OFFSET = "sampling rate", "saturation", "offset"


class Limit(NamedTuple):
    """Something that limits what the data can tell."""

    word: str  # in the headline
    line: str  # what is the case; what to do about it


class Trust(NamedTuple):
    """What the data are, and what limits them."""

    about: str  # their extent
    limits: tuple[Limit, ...]

    @property
    def headline(self) -> str:
        """Whether the data can be trusted, in one line."""
        if not self.limits:
            return f"Data: nothing speaks against them; {self.about}."
        words = list(dict.fromkeys(limit.word for limit in self.limits))
        return f"Data: limited by {', '.join(words)}; {self.about}."

    @property
    def lines(self) -> tuple[str, ...]:
        """What limits the data, each once."""
        return tuple(dict.fromkeys(limit.line for limit in self.limits))


def left_out(excluded: Mapping[str, str], of: int) -> list[Limit]:
    """The trials that are left out, with the first reasons."""
    if not excluded:
        return []
    count = len(excluded)
    reasons = [f"{name}: {why}" for name, why in list(excluded.items())[:SHOWN]]
    more = f"; and {count - SHOWN} more" if count > SHOWN else ""
    what = f"{count} of {of} trials {'are' if count > 1 else 'is'} left out"
    return [Limit("trials left out", f"{what} ({'; '.join(reasons)}{more})")]


def rate_limit(trials: Sequence[TrialQuality]) -> Limit | None:
    """Sampling that may have missed the top of a peak; what it misses falls with the square of the rate."""
    whole = [(t, t.phase) for t in trials if t.phase and t.phase.cut_off is None and t.phase.height > 0]
    share, worst = max(
        ((p.missed_peak / p.height, t) for t, p in whole), key=lambda pair: pair[0], default=(0, None)
    )
    if worst is None or worst.sample_rate is None or share <= MISSED:
        return None
    rate = worst.sample_rate * (share / MISSED_BY_ADVICE) ** 0.5
    return Limit(
        RATE,
        f"at {worst.sample_rate:.0f} Hz the sampled peak may be up to {100 * share:.0f} % too low (trial {worst.name});"
        f" the force changes from sample to sample: judge by traces, sample at {_rounded_up(rate):,.0f} Hz or faster",
    )


def offset_limit(trials: Sequence[TrialQuality], noise: Noise) -> Limit | None:
    """A sensor that does not read nothing while nothing is touched."""
    if not noise.samples or not any(t.approach for t in trials):
        return None
    alike = max(1.0, noise.samples_per_independent(1.0 / (trials[0].sample_rate or 1.0)))
    if abs(noise.offset) <= 4.0 * noise.std * (alike / noise.samples) ** 0.5 + 0.1 * noise.std:
        return None
    return Limit(OFFSET, f"the sensor reads {noise.offset:+.3g} N before contact; zero it before each trial")


def design_limits(dataset: GapDataset, used: Sequence[int]) -> list[Limit]:
    """What the choice of trials keeps from being told, of those that are used."""
    found = []
    trials = [dataset.trials[i] for i in used]
    groups = [dataset.condition_of[i] for i in used]
    conditions = len(set(groups))
    if not trials:
        return []
    if all(t.trace is None for t in trials):
        line = "peaks without traces tell few causes apart; record the force over time, at 5 kHz or faster"
        found.append(Limit("no traces", line))
    speeds, pretensions = extent(dataset, used)
    if len(speeds) == 1:
        line = f"all trials touch at {speeds[0]:.3g} m/s, one speed only; add trials at two other speeds"
        found.append(Limit("one speed", line))
    if len(pretensions) == 1:
        line = f"all trials have a pretension of {pretensions[0]:.3g} N; add trials at another one"
        found.append(Limit("one pretension", line))
    if len(trials) < FEWEST or conditions < FEWEST_CONDITIONS:
        line = (
            f"{len(trials)} trials at {_count(conditions, 'condition')} are few: a faulty one cannot be told;"
            " ten conditions with two repeats each are good"
        )
        found.append(Limit("few trials", line))
    if len(trials) == conditions:
        line = "no condition is repeated, so scatter between trials cannot be told; repeat each once"
        found.append(Limit("no repeats", line))
    return found


def extent(dataset: GapDataset, used: Sequence[int]) -> tuple[list[float], list[float]]:
    """The speeds (m/s) and the pretensions (N) of trials that differ by more than their spread."""
    spread = dataset.measurement
    trials = [dataset.trials[i] for i in used]
    return (
        _levels([t.contact_velocity for t in trials], spread.contact_velocity_rel_std),
        _levels([t.pretension for t in trials], spread.pretension_rel_std),
    )


def about(dataset: GapDataset, used: Sequence[int], trials: Sequence[TrialQuality]) -> str:
    """How many trials there are, what they cover, and how fast their force was sampled."""
    speeds, pretensions = extent(dataset, used)
    conditions = len({dataset.condition_of[i] for i in used})
    rates = [rate for i in used if (rate := trials[i].sample_rate)]
    parts = [
        f"{_count(len(used), 'trial')} at {_count(conditions, 'condition')}",
        _count(len(speeds), "speed"),
        _count(len(pretensions), "pretension"),
    ]
    if rates:
        parts.append(f"sampled at {1e-3 * float(np.median(rates)):.3g} kHz")
    return ", ".join(parts)


def _levels(values: Sequence[float], spread: float) -> list[float]:
    """The lowest of each group of values that lie within a twentieth, or three standard deviations, of each other."""
    levels: list[float] = []
    for value in sorted(values):
        if not levels or value > levels[-1] * (1.0 + max(APART, 3.0 * spread)):
            levels.append(value)
    return levels


def _rounded_up(value: float) -> float:
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * np.ceil(value / power))


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
