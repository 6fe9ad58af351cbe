"""The stated probability: forces among draws of everything uncertain, and the margin that keeps it."""

import math

import equinox as eqx
import numpy as np
from scipy.stats import norm

from acf_jax.contact.body import WALL
from acf_jax.contact.model import ContactModel, draw_forces
from acf_jax.designs.task import Margin, Task, upper_at

TO_SPARE = 2.0  # standard errors of the drawn probability by which the stated one is exceeded
FAILURES = 20  # draws, at least, that may break the limit: then `TO_SPARE` errors are less than half of them
BROKEN = 3.0  # standard errors below the stated probability: fresh draws that break it
RESTS = 1e-5  # standard deviations of the force by which rounds may stop short of the limit
FAR = 1e3  # standard deviations: so far away the branch of the force counts that is least certain
LEAST_RAISE, MOST_RAISE = 1.02, 2.0  # of the reach, at a time


class Draws(eqx.Module):
    """Forces of draws at one point, and how a design reads them."""

    force: np.ndarray  # (draws,) N
    exists: np.ndarray  # (draws,) whether the draw has a peak; one without breaks every limit

    def probability(self, limit: float) -> float:
        """The share of draws that hold a limit."""
        return float((self.exists & (self.force <= limit)).mean())

    def quantile(self, share: float) -> float:
        """The force that a share of the draws does not exceed; infinite where too many have no peak."""
        forces = np.sort(np.where(self.exists, self.force, np.inf))
        return float(forces[int(np.ceil(share * forces.size)) - 1])


def draw(model: ContactModel, z: np.ndarray, draws: int, seed: int) -> Draws:
    """Draws at z."""
    return Draws(*draw_forces(model, z, WALL, draws, seed))


def least_draws(probability: float) -> int:
    """How many draws a stated probability needs."""
    return math.ceil(round(FAILURES / (1 - probability), 6))


def draws_fault(model: ContactModel, probability: float, draws: int) -> str | None:
    """Why so many draws are too few, with the remedy; None where they are enough, or more cost next to nothing."""
    if not model.is_simulated or draws >= least_draws(probability):
        return None
    return (
        f"a probability of {probability:g} needs at least {least_draws(probability)} draws, here simulated, but are"
        f" {draws}; raise them, lower the probability, or train a surrogate on the model"
    )


def held_share(probability: float, draws: int, to_spare: float = TO_SPARE) -> float:
    """The share of draws that has to hold, so that the probability does."""
    error = np.sqrt(probability * (1 - probability) / draws)
    return float(probability + to_spare * error)


def is_kept(share: float, probability: float, draws: int) -> bool:
    """Whether a share of fresh draws agrees with the stated probability."""
    return share >= probability - BROKEN * np.sqrt(probability * (1 - probability) / draws)


def margin_at(task: Task, z: np.ndarray, margin: Margin, draws: int, seed: int) -> tuple[Margin, bool]:
    """The margin with which F + factor sigma is the stated quantile of the drawn forces at z, and whether z keeps it.

    Where too many draws have no peak there is no quantile, and the reach has to grow: for a peak that ends at a plane
    in b standard deviations, a share Phi(-b) of the draws has none.
    """
    _, force, exists, own = upper_at(task.model, z, Margin(FAR))
    std = float(own.std)
    if not std > 1e-12 * force:
        return margin, exists and force <= task.limit
    found, share = draw(task.model, z, draws, seed), held_share(task.probability, draws)
    quantile = found.quantile(share)
    if np.isfinite(quantile):
        is_held = quantile <= task.limit + RESTS * std
        return margin._replace(factor=_factor(task, z, quantile)), bool(is_held)
    if not exists:
        return margin, False  # no reach brings a peak
    wanted, there = norm.ppf(share), norm.ppf(found.exists.mean())
    raised = margin.reach * float(np.clip(wanted / there if there > 0 else np.inf, LEAST_RAISE, MOST_RAISE))
    return margin._replace(reach=raised or float(wanted)), False


def _factor(task: Task, z: np.ndarray, quantile: float) -> float:
    """The factor with which F + factor sigma is the quantile at z, by Newton's method.

    Of several branches the largest counts, so that F + factor sigma is convex in the factor and straight between the
    places where another takes over: from the second step on the factor falls, and rests.
    """

    def step(factor: float) -> float:
        _, force, _, own = upper_at(task.model, z, Margin(factor))
        return float((quantile - force) / own.std) if own.std > 0 else factor

    factor = step(FAR)
    while (lower := step(factor)) < factor:
        factor = lower
    return factor
