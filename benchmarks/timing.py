"""Fair timing on a machine that others use too: interleaved repeats, median with minimum and maximum."""

import statistics
import time
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple


class Timing(NamedTuple):
    """Seconds of one call."""

    median: float
    low: float
    high: float


def interleave(
    calls: Mapping[str, Callable[[], Any]], repeats: int, rest: float = 0.02
) -> dict[str, list[float]]:
    """Seconds of each call, `repeats` times in turn, so that a slow moment of the machine meets all alike.

    One call of each goes first, unmeasured. `rest` seconds between calls let the threads of the previous
    one fall asleep: idle OpenMP threads spin for a while and would slow the next.
    """
    for call in calls.values():
        call()
    seconds: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(repeats):
        for name, call in calls.items():
            time.sleep(rest)
            start = time.perf_counter()
            call()
            seconds[name].append(time.perf_counter() - start)
    return seconds


def summarise(seconds: list[float]) -> Timing:
    """Median, minimum and maximum."""
    return Timing(statistics.median(seconds), min(seconds), max(seconds))


def median_ratio(slower: list[float], faster: list[float]) -> float:
    """Median over the rounds of how many times faster: both of a pair saw the same moment of the machine."""
    return statistics.median(a / b for a, b in zip(slower, faster, strict=True))
