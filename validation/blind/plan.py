"""Which causes, at which sizes, a blind run shall have."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from validation.worlds import AbstractWorld

LIFELIKE = 1 / 3  # of the data sets; the others have one cause or two and nothing besides
SHARES = {
    kind: (1 - LIFELIKE) * share
    for kind, share in {"none": 0.25, "single": 0.4, "pair": 0.1, "beyond": 0.15, "withheld": 0.1}.items()
} | {"lifelike": LIFELIKE}
# What is large on a lifelike rig: so many effects of the library, or a cause beyond it.
LARGE = {"one": 0.3, "two": 0.2, "three": 0.1, "beyond": 0.2, "none": 0.2}
# Whitened distances: barely visible, visible, clear.
WEAK, VISIBLE, CLEAR = (2.0, 6.0), (6.0, 60.0), (60.0, 600.0)


@dataclass(frozen=True)
class Order:
    """One case to make: the arguments of `make_case` or, of a lifelike rig, of `make_lifelike`."""

    kind: str  # of SHARES
    seed: int
    effects: tuple[str, ...]
    target: float | None
    coloured: bool | None
    world: str = ""

    @property
    def without(self) -> str:
        """The effect that the diagnosis shall not know."""
        return self.effects[0] if self.kind == "withheld" else ""


def draw_plan(seed: int, cases: int, worlds: Sequence[AbstractWorld]) -> list[Order]:
    """The orders of a run over several worlds, which take turns; see `draw_orders`."""
    per_world = [
        [replace(order, world=world.name) for order in draw_orders(seed + 7919 * k, n, world)]
        for k, (world, n) in enumerate(zip(worlds, _even(cases, len(worlds)), strict=True))
    ]
    return [orders[i] for i in range(max(map(len, per_world))) for orders in per_world if i < len(orders)]


def draw_orders(seed: int, cases: int, world: AbstractWorld) -> list[Order]:
    """The orders of one world, shuffled; every effect comes as often as every other, within one.

    A third are lifelike rigs: 30 % of these with one large effect, 20 % with two, 10 % with three, 20 % with a cause
    beyond the library and 20 % with small effects alone. Of the others a quarter has no cause (half of these with
    coloured noise), two fifths one effect of the library, a tenth a pair of them, 15 % a cause beyond the library, and
    in a tenth the effect is withheld from the diagnosis. Distances of single effects spread evenly over barely visible,
    visible and clear; all others are visible or clear.
    """
    rng = np.random.default_rng(seed)
    library, beyond = list(world.causes("library")), list(world.causes("beyond"))
    counts = _counts(cases, SHARES, "single")

    def cycle(choices: list[tuple[str, ...]], n: int) -> list[tuple[str, ...]]:
        """`n` choices, each as often as every other within one, in random order of each round."""
        rounds = [rng.permutation(len(choices)) for _ in range(n // len(choices) + 1)]
        return [choices[i] for i in np.concatenate(rounds)[:n]]

    def targets(chosen: list[tuple[str, ...]], ranges: tuple[tuple[float, float], ...]) -> list[float]:
        """A distance each; an effect that comes again takes the next range."""
        first = {names: int(rng.integers(len(ranges))) for names in sorted(set(chosen))}
        turns = [first[names] + chosen[:i].count(names) for i, names in enumerate(chosen)]
        return [float(np.exp(rng.uniform(*np.log(ranges[turn % len(ranges)])))) for turn in turns]

    alone: list[tuple[str, ...]] = [(name,) for name in library]
    pairs: list[tuple[str, ...]] = list(combinations(library, 2))
    foreign: list[tuple[str, ...]] = [(name,) for name in beyond]
    drawn = [Order("none", 0, (), None, i % 2 == 1) for i in range(counts["none"])]
    kinds: list[tuple[list[tuple[str, ...]], str, tuple[tuple[float, float], ...]]] = [
        (alone, "single", (WEAK, VISIBLE, CLEAR)),
        (pairs, "pair", (VISIBLE, CLEAR)),
        (foreign, "beyond", (VISIBLE, CLEAR)),
        (alone, "withheld", (VISIBLE, CLEAR)),
    ]
    for choices, kind, ranges in kinds:
        chosen = cycle(choices, counts[kind])
        drawn += [
            Order(kind, 0, names, target, None)
            for names, target in zip(chosen, targets(chosen, ranges), strict=True)
        ]
    large: dict[str, list[tuple[str, ...]]] = {
        "one": alone,
        "two": pairs,
        "three": list(combinations(library, 3)),
        "beyond": foreign,
        "none": [()],
    }
    for number, n in _counts(counts["lifelike"], LARGE, "one").items():
        drawn += [Order("lifelike", 0, names, None, None) for names in cycle(large[number], n)]
    seeds = rng.integers(2**31, size=len(drawn))
    return [replace(drawn[i], seed=int(seeds[i])) for i in rng.permutation(len(drawn))]


def _counts(total: int, shares: dict[str, float], rest: str) -> dict[str, int]:
    """How many of each kind; what rounding leaves or takes is the matter of one of them."""
    counts = {kind: round(total * share) for kind, share in shares.items()}
    counts[rest] += total - sum(counts.values())
    return counts


def _even(total: int, parts: int) -> list[int]:
    return [total // parts + (k < total % parts) for k in range(parts)]
