"""Where fits of a port begin."""

from collections.abc import Callable, Mapping, Sequence


def beginning(starts: Sequence[Mapping[str, float]]) -> Callable[..., tuple[float, ...]]:
    """What gives a parameter its starts: `of(name, usual)` is its value at each, `usual` where that names none."""

    def of(name: str, usual: float = 0.0) -> tuple[float, ...]:
        return tuple(start.get(name, usual) for start in starts)

    return of
