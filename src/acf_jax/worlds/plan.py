"""Which causes, at which sizes, a series of cases shall have."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from acf_jax.worlds.interface import AbstractWorld

SHARES = {"none": 0.25, "single": 0.5, "pair": 0.1, "beyond": 0.15}
# Whitened distances: barely visible, visible, clear.
WEAK, VISIBLE, CLEAR = (2.0, 6.0), (6.0, 60.0), (60.0, 600.0)


@dataclass(frozen=True)
class Order:
    """One case to make: the arguments of `make_case`."""

    seed: int
    effects: tuple[str, ...]
    target: float | None
    coloured: bool | None


def draw_plan(seed: int, cases: int, world: AbstractWorld) -> list[Order]:
    """The orders of a series, shuffled; every effect comes as often as every other, within one.

    A quarter has no cause (half of these with coloured noise), half has one effect of the library, a tenth
    a pair of them, the rest a cause beyond the library. Distances of single effects spread evenly over
    barely visible, visible and clear; pairs and causes beyond the library are visible or clear.
    """
    rng = np.random.default_rng(seed)
    library, beyond = list(world.causes("library")), list(world.causes("beyond"))
    counts = {kind: round(cases * share) for kind, share in SHARES.items()}
    counts["single"] += cases - sum(counts.values())

    def cycle(choices: list[tuple[str, ...]], n: int) -> list[tuple[str, ...]]:
        """`n` choices, each as often as every other within one, in random order of each round."""
        rounds = [rng.permutation(len(choices)) for _ in range(n // len(choices) + 1)]
        return [choices[i] for i in np.concatenate(rounds)[:n]]

    def targets(chosen: list[tuple[str, ...]], ranges: tuple[tuple[float, float], ...]) -> list[float]:
        """A distance each; an effect that comes again takes the next range."""
        first = {names: int(rng.integers(len(ranges))) for names in sorted(set(chosen))}
        turns = [first[names] + chosen[:i].count(names) for i, names in enumerate(chosen)]
        return [float(np.exp(rng.uniform(*np.log(ranges[turn % len(ranges)])))) for turn in turns]

    pairs: list[tuple[str, ...]] = list(combinations(library, 2))
    drawn: list[tuple[tuple[str, ...], float | None, bool | None]] = [
        ((), None, i % 2 == 1) for i in range(counts["none"])
    ]
    kinds: list[tuple[list[tuple[str, ...]], str, tuple[tuple[float, float], ...]]] = [
        ([(name,) for name in library], "single", (WEAK, VISIBLE, CLEAR)),
        (pairs, "pair", (VISIBLE, CLEAR)),
        ([(name,) for name in beyond], "beyond", (VISIBLE, CLEAR)),
    ]
    for choices, kind, ranges in kinds:
        chosen = cycle(choices, counts[kind])
        drawn += [
            (names, target, None) for names, target in zip(chosen, targets(chosen, ranges), strict=True)
        ]
    seeds = rng.integers(2**31, size=len(drawn))
    return [Order(int(seeds[i]), *drawn[i]) for i in rng.permutation(len(drawn))]
