"""The log score of each explanation: what its fit leaves, what it does to the rig, and its prior probability."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from acf_jax.inference.fit import Fit
from acf_jax.inference.parameters import RIG, Explanation, every_effect, is_free_curve

SAMPLES_A_PIECE = 10.0  # samples that count as one piece where there are few
LEAST_FREE, MOST_FREE = 0.5, 7.0  # log shares that are believed


@dataclass(frozen=True)
class Weights:
    """How evidence becomes probability, learnt on simulated cases (docs/method.md says how).

    An effect whose true form differs from the library's leaves some of the gap even when it is the cause. So the
    half chi-square x/2 that an explanation leaves above the best one counts as
    nu/2 log(1 + x / (nu + rho^2 G)), G the chi-square of the whole gap: the likelihood itself for a small gap, and
    for a large one about nu/2 for each factor of e by which it fits worse than form errors of the relative size rho.
    The paper's model alone has no form to be wrong: only noise that is not known exactly tempers what it leaves.
    Where the best explanation by as many effects leaves nothing but noise, its form is as good as exact; another one
    by as many then loses at least the share `exact` of the half chi-square by which it fits worse, and beside the best
    of all named ones and free curves the share `exact_of_all`.
    What the rig's own parameters had to leave their priors counts under a Student prior with heavy tails.
    """

    nu: float = 34.0  # how many independent pieces a misfit of form has
    nu_noise: float = 60.0  # the same for noise that is not as it is said to be
    rho_squared: float = 0.052  # the share of the gap that a wrong form leaves
    exact: float = 0.5  # share of the likelihood that always counts beside a form that leaves only noise
    exact_of_all: float = 0.1  # the same beside the best of all, free curves among them
    effect: float = 5.3  # cost of one effect, in log probability
    rare: float = 1.85  # the same, where it is known how free it was to explain what it does
    second: float = 5.0  # cost of each further one
    noise: float = 1.1  # further cost of one that finds something of its kind in any noise
    free_curve: float = 13.5  # cost of a free curve
    small: float = 2.3  # further cost of a free curve, and of each further effect, to explain a small gap
    nameless: float = 28.0  # cost of a cause that neither the library nor the free curves can imitate
    in_series: float = (
        1.8  # further cost of a free curve that all forces pass, in telling where an unknown cause acts
    )
    strain_told: float = 0.5  # share of what a rig's strain costs that counts there
    freedom: float = 14.0  # degrees of freedom of the Student prior of the rig's parameters
    margin: float = 0.05  # by which the chi-square of a sample may exceed 1: noise is not known exactly


WEIGHTS = Weights()


def cost(
    explanation: Explanation,
    weights: Weights = WEIGHTS,
    volume: float | None = None,
    is_small: bool = False,
) -> float:
    """Log probability that an explanation has less than the paper's model before any data.

    Where it is known how free the effect was, `volume`, that takes the place of what its freedom costs on average.
    Where the gap is small, `is_small`, that is known of single effects only; free curves and further effects cost more
    there.
    """
    if not explanation:
        return 0.0
    if volume is not None:
        return weights.rare + float(np.clip(-volume, LEAST_FREE, MOST_FREE))
    dearer = weights.small * is_small
    if is_free_curve(explanation):
        return weights.free_curve + dearer
    known = [every_effect()[name] for name in explanation]
    fits_noise = sum(cls.fits_noise for cls in known)
    # of one that may act either way, half of what it can do lies on the other side of what it did
    either_way = np.log(2) * sum(cls.acts_either_way() for cls in known)
    among_effects = weights.effect + (weights.second + dearer) * (len(explanation) - 1)
    return float(among_effects + weights.noise * fits_noise + either_way)


class Evidence(NamedTuple):
    """What of a fit counts: chi-square of the data and of the trials' nuisances, and what became of the rig."""

    explanation: Explanation
    chi_square: float
    strain: tuple[float, ...]  # squared deviations of m, d, k_F, k_C from their priors, in prior std
    volume: float | None = (
        None  # log share of what a single effect can do that explains as much, where it is known
    )
    optimism: float = 0.0  # chi-square that the fit would leave more of conditions that it has not seen


def evidence_of(fitted: Fit) -> Evidence:
    """The evidence of a fit, without what takes the observations to tell."""
    strain = fitted.u[: len(RIG)] ** 2
    return Evidence(fitted.explanation, float(2 * fitted.objective - strain.sum()), tuple(strain.tolist()))


def noise_level(samples: int, weights: Weights = WEIGHTS, noise_doubt: float = 0.0) -> float:
    """The chi-square that noise alone may leave, a little more than is known of it."""
    return float(samples * (1 + weights.margin + noise_doubt + 3 * np.sqrt(2 / samples)))


def log_scores(
    evidence: Sequence[Evidence], samples: int, weights: Weights = WEIGHTS, noise_doubt: float = 0.0
) -> np.ndarray:
    """Unnormalised log probability of each explanation, the paper's model first, then of a nameless cause.

    The nameless cause would leave nothing but noise, here a little more than the noise as known, and by the share
    `noise_doubt` more where its colour is hardly known (`acf_jax.dataset.Noise.doubt`).

    Each explanation counts by what it would leave of conditions that it has not seen, `Evidence.optimism` included. Not
    so where the gap is small: there the prices say what an explanation's freedom is worth.
    """
    noise = noise_level(samples, weights, noise_doubt)
    is_small = any(e.volume is not None for e in evidence)
    chi2 = np.append([e.chi_square + e.optimism * (not is_small) for e in evidence], noise)
    gap, excess = chi2[0] - chi2.min(), chi2 - chi2.min()
    misfit = misfit_cost(excess, weights.rho_squared * gap, weights.nu, samples)
    misfit[0] = misfit_cost(gap, 0.0, weights.nu_noise, samples)
    for alike, share, left in _told_apart(evidence, chi2[:-1], weights):
        if left.min() < noise:
            told = 0.5 * share * (left - left.min())
            misfit[alike] = np.maximum(misfit[alike], misfit[alike].min() + told)
    strained = strain_cost(evidence, weights)
    costs = [cost(e.explanation, weights, e.volume, is_small) for e in evidence]
    return -misfit - np.append(strained, strained.min()) - np.array([*costs, weights.nameless])


def _told_apart(
    evidence: Sequence[Evidence], unseen: np.ndarray, weights: Weights
) -> Iterator[tuple[np.ndarray, float, np.ndarray]]:
    """The explanations by one effect, by two, and so on, and all: their places, the share that counts, what they leave.

    A form that has to strain the rig is not exact: that counts as left. All, free curves among them, are told apart by
    what they leave of conditions that they have not seen, `unseen`.
    """
    left = np.array([e.chi_square for e in evidence])
    rig = np.array([sum(e.strain) for e in evidence])
    many = np.array([0 if is_free_curve(e.explanation) else len(e.explanation) for e in evidence])
    for n in np.unique(many[many > 0]):
        alike = np.flatnonzero(many == n)
        yield alike, weights.exact, (left + rig)[alike]
    if many.any():
        every = np.flatnonzero([bool(e.explanation) for e in evidence])
        yield every, weights.exact_of_all, (unseen + rig)[every]


def misfit_cost(excess: np.ndarray, wrong: float, nu: float, samples: int) -> np.ndarray:
    """Log probability that a form loses by the chi-square that it leaves above the best one.

    `wrong` is the chi-square that even the right form may leave, `nu` how many independent pieces of it there are.
    """
    pieces = min(nu, samples / SAMPLES_A_PIECE)
    return np.asarray(0.5 * pieces * np.log1p(excess / (pieces + wrong)))


def strain_cost(evidence: Sequence[Evidence], weights: Weights) -> np.ndarray:
    """Log probability that each explanation loses because the rig's own parameters left their priors."""
    rig = np.array([e.strain for e in evidence])
    return np.asarray(0.5 * weights.freedom * np.log1p(rig / weights.freedom).sum(1))
