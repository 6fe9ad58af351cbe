"""Labelled samples: points of the parameter box, and the model's peak force there."""

from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from acf_jax.model import Impact, Peak, Rig, find_peaks
from acf_jax.surrogate.box import UNITS
from acf_jax.training.config import Config, Ranges, Samples

# Each purpose draws its own scramble of the design, so that no sample serves two.
PURPOSES = ("train", "held_out", "test", "held_out_edges", "test_edges")


class Labelled(NamedTuple):
    """All samples drawn, and their labels; those without a peak are flagged, and used by no one."""

    rig: Rig
    impact: Impact
    peak: Peak

    @property
    def has_peak(self) -> np.ndarray:
        return np.asarray(self.peak.has_peak)

    @property
    def f_max(self) -> np.ndarray:
        """Peak force of the samples that have one, N."""
        return np.asarray(self.peak.f_max)[self.has_peak]

    def sizes(self) -> dict[str, int]:
        """How many samples have a peak, and how many were set apart."""
        return {"with_peak": int(self.has_peak.sum()), "without_peak": int((~self.has_peak).sum())}


def draw_samples(
    ranges: Ranges,
    count: int,
    method: str,
    seed: int,
    towards_edges: bool,
    first: int = 0,
    end: int | None = None,
) -> tuple[Rig, Impact]:
    """`count` points of the box, or those from `first` to before `end` of them.

    `towards_edges` gives them the Chebyshev density.

    u <- sin^2(pi u/2)

    A fit is worst at the edges and corners of its box, where an even density has next to no samples:
    within a tenth of one corner, in all six parameters, it has one in 1,000,000; this one has one in 14,000.
    """
    unit = _design(len(UNITS), count, method, seed, first, count if end is None else end)
    if towards_edges:
        unit = _towards_edges(unit)
    x = {}
    for column, name in zip(unit.T, UNITS, strict=True):
        range_ = getattr(ranges, name)
        if range_.scale == "log":
            x[name] = range_.low * (range_.high / range_.low) ** column
        else:
            x[name] = range_.low + (range_.high - range_.low) * column
    d = 2 * x["zeta"] * np.sqrt(x["m"] * (x["k_f"] + x["k_c"]))
    return Rig(m=x["m"], d=d, k_f=x["k_f"], k_c=x["k_c"]), Impact(v_e=x["v_e"], f_p=x["f_p"])


def draw_points(dimensions: int, samples: Samples, seed: int, purpose: str) -> np.ndarray:
    """The points of one purpose in the unit cube, (n, dimensions), in the density that `draw` gives them."""
    count, own, towards_edges = _plan(samples, seed, purpose)
    unit = _design(dimensions, count, samples.method, own, 0, count)
    return _towards_edges(unit) if towards_edges else unit


def _towards_edges(unit: np.ndarray) -> np.ndarray:
    return np.asarray(np.sin(np.pi / 2 * unit) ** 2)


def _plan(samples: Samples, seed: int, purpose: str) -> tuple[int, int, bool]:
    """Number, seed, and whether the density is the Chebyshev one, of a purpose's points."""
    count = getattr(samples, purpose.removesuffix("_edges"))
    own = int(np.random.SeedSequence([seed, PURPOSES.index(purpose)]).generate_state(1)[0])
    return count, own, purpose == "train" or purpose.endswith("_edges")


def _design(dimensions: int, count: int, method: str, seed: int, first: int, end: int) -> np.ndarray:
    """The points from `first` to before `end` of `count` in the unit cube, whatever is asked for beside them."""
    random = np.random.default_rng(seed)
    if method == "latin_hypercube":  # has no part without the whole
        return qmc.LatinHypercube(d=dimensions, rng=random).random(count)[first:end]
    design = qmc.Sobol(d=dimensions, rng=random)
    if first:
        return design.fast_forward(first).random(end - first)
    # Sobol points are balanced in powers of two; what is above `end` is dropped.
    return design.random(2 ** int(np.ceil(np.log2(end))))[:end]


def label_samples(rig: Rig, impact: Impact) -> Peak:
    """The labels: peak force and time of each sample."""
    return find_peaks(rig, impact)


def draw(config: Config, purpose: str, first: int = 0, end: int | None = None) -> tuple[Rig, Impact]:
    """The samples of one purpose, or those from `first` to before `end` of them."""
    count, seed, towards_edges = _plan(config.samples, config.seed, purpose)
    return draw_samples(config.ranges, count, config.samples.method, seed, towards_edges, first, end)


def make_data(config: Config, purpose: str) -> Labelled:
    """The samples of one purpose with their labels."""
    rig, impact = draw(config, purpose)
    return Labelled(rig, impact, label_samples(rig, impact))
