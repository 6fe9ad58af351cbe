"""What the paper's model can imitate of forces with a cause, by any rig and any trials that are still credible."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from validation.worlds.interface import Array, Rig
from validation.worlds.paper import contact_force
from validation.worlds.setup import DELAY, Setup

ADJUSTMENTS = 12  # of the imitating rig, at most
HALVINGS = 6  # of a step that makes the imitation worse
ENOUGH = 1e-4  # share by which a further adjustment has to lower the squared distance
STEP = 1e-3  # standard deviations over which a derivative is taken
LEAST = 0.02  # share of its true value below which no constant of the imitating rig goes
COMMON = 5  # parameters that all trials share
Trace = tuple[Array, Array]  # time s, force N


class Point(NamedTuple):
    """Everything that a fit may adjust, in standard deviations."""

    common: Array  # (COMMON,) m, d, k_F, k_C and the delay of all triggers
    nuisance: Array  # (conditions, 3) velocity, pretension and trigger of the trials

    def moved(self, common: Array, nuisance: Array, share: float = 1.0) -> "Point":
        """The point further along a direction."""
        return Point(self.common + share * common, self.nuisance + share * nuisance)


class Misfit(NamedTuple):
    """What a point leaves, whitened, and how it changes; zero where nothing is recorded."""

    left: Array  # (conditions, samples)
    by_common: Array  # (conditions, samples, COMMON)
    by_nuisance: Array  # (conditions, samples, 3)


class Imitation:
    """The paper's model under the priors of a setup, next to one noise-free trace of each of its conditions."""

    def __init__(self, setup: Setup, traces: Sequence[Trace]):
        self.setup = setup
        self.value = np.array([setup.rig.m, setup.rig.d, setup.rig.k_f, setup.rig.k_c])
        self.std = np.array([std for _, std in setup.prior])
        self.low = np.append((LEAST - 1) * self.value / self.std, -np.inf)
        self.delay_std = DELAY * setup.interval / np.sqrt(3.0)
        self.trigger_std = max(setup.jitter, 0.5) * setup.interval / np.sqrt(3.0)
        self.v_e, self.f_p = np.array(setup.conditions).T[:, :, None]
        lengths = np.array([force.size for _, force in traces])
        self.time = max(traces, key=lambda trace: trace[0].size)[0]
        self.recorded = np.arange(self.time.size) < lengths[:, None]
        self.measured = np.stack([np.pad(force, (0, self.time.size - force.size)) for _, force in traces])

    @property
    def truth(self) -> Point:
        """The true rig, every trial as commanded."""
        return Point(np.zeros(COMMON), np.zeros((len(self.setup.conditions), 3)))

    def force(self, at: Point) -> Array:
        """Force without causes, N, (conditions, samples), where the two-sided law would pull none.

        Not none ever after: of a trial that almost loses contact, the rest would jump between all and nothing.
        """
        rig = Rig(*(self.value + self.std * at.common[:4]))
        v, f, late = at.nuisance.T[:, :, None]
        spread = self.setup.spread
        time = self.time + self.delay_std * at.common[4] + self.trigger_std * late
        return np.maximum(
            contact_force(rig, self.v_e * (1 + spread * v), self.f_p * (1 + spread * f), time), 0.0
        )

    def misfit(self, at: Point) -> Misfit:
        """What the point leaves of the traces, and the derivatives of its force."""
        here, none = self.force(at), self.truth
        common, nuisance = np.eye(COMMON), np.eye(3)
        beside = [at.moved(common[i], none.nuisance, STEP) for i in range(COMMON)]
        beside += [at.moved(none.common, nuisance[i], STEP) for i in range(3)]
        rows = [self.measured - here, *((self.force(p) - here) / STEP for p in beside)]
        white = self.setup.noise.whiten(np.stack(rows, axis=-1).swapaxes(0, 1)).swapaxes(0, 1)
        white = white * self.recorded[..., None]
        return Misfit(white[..., 0], white[..., 1 : 1 + COMMON], white[..., 1 + COMMON :])

    def squared(self, at: Point, misfit: Misfit) -> float:
        """Squared whitened distance of the traces from the point's forces, and of the point from the priors."""
        of_trials = float((misfit.left**2).sum() + (at.nuisance**2).sum())
        return self.setup.repeats * of_trials + float(at.common @ at.common)

    def _step(self, at: Point, misfit: Misfit) -> tuple[Array, Array]:
        """One step of Gauss and Newton: the nuisances are eliminated, the rig stays within its bounds."""
        left, j, k = misfit
        repeats = self.setup.repeats
        inverse = np.linalg.inv(np.einsum("cna,cnb->cab", k, k) + np.eye(3))
        on_nuisance = np.einsum("cna,cn->ca", k, left) - at.nuisance
        cross = np.einsum("cna,cnp->cap", k, j)
        reduced = np.einsum("cap,cab->cpb", cross, inverse)
        normal = np.einsum("cnp,cnq->pq", j, j) - np.einsum("cpb,cbq->pq", reduced, cross)
        gradient = np.einsum("cnp,cn->p", j, left) - np.einsum("cpb,cb->p", reduced, on_nuisance)
        step = _within(np.eye(COMMON) + repeats * normal, repeats * gradient - at.common, at.common, self.low)
        return step, np.einsum("cab,cb->ca", inverse, on_nuisance - cross @ step)

    def best(self) -> tuple[Point, float]:
        """The point whose forces come nearest to the traces, and the squared distance that is left."""
        at = self.truth
        misfit = self.misfit(at)
        value = self.squared(at, misfit)
        for _ in range(ADJUSTMENTS):
            step = self._step(at, misfit)
            for halving in range(HALVINGS):
                tried = at.moved(*step, 0.5**halving)
                with np.errstate(over="ignore", invalid="ignore"):  # of a step too far, which is halved
                    misfit = self.misfit(tried)
                    lower = self.squared(tried, misfit)
                if lower < value:
                    break
            else:
                break
            is_enough = value - lower < ENOUGH * value
            at, value = tried, lower
            if is_enough:
                break
        return at, value

    def left(self) -> list[Array]:
        """What the best imitation leaves of the traces, N, one array (n,) a condition."""
        at, _ = self.best()
        left = self.measured - self.force(at)
        return [row[recorded] for row, recorded in zip(left, self.recorded, strict=True)]

    def gram(self, signals: Sequence[Sequence[Array]]) -> Array:
        """Inner products (k, k) of what no small adjustment removes from k signals, each one array (n,) a condition, N.

        Of a condition the part counts that all of the signals have.
        """
        misfit, weight = self.misfit(self.truth), np.sqrt(self.setup.repeats)
        columns, targets = [np.eye(COMMON)], [np.zeros((COMMON, len(signals)))]
        for c in range(len(self.setup.conditions)):
            n = min(len(signal[c]) for signal in signals)
            # The unit rows are the priors, in standard deviations.
            basis, _ = np.linalg.qr(np.vstack([misfit.by_nuisance[c, :n], np.eye(3)]))

            def off_nuisance(rows: Array, basis: Array = basis) -> Array:
                padded = np.concatenate([rows, np.zeros((3, rows.shape[1]))])
                return np.asarray(padded - basis @ (basis.T @ padded))

            white = self.setup.noise.whiten(np.stack([signal[c][:n] for signal in signals], axis=1))
            columns.append(weight * off_nuisance(misfit.by_common[c, :n]))
            targets.append(weight * off_nuisance(white))
        design, target = np.concatenate(columns), np.concatenate(targets)
        theta, *_ = np.linalg.lstsq(design, target)
        left = target - design @ theta
        return np.asarray(left.T @ left)


def _within(normal: Array, gradient: Array, theta: Array, low: Array) -> Array:
    """The Gauss-Newton step that leaves no parameter below its bound: those that would fall are held there."""
    step = np.linalg.solve(normal, gradient)
    held = np.zeros(theta.size, bool)
    while (falling := ~held & (theta + step < low)).any():
        held |= falling
        step[held] = (low - theta)[held]
        free = ~held
        rest = gradient[free] - normal[np.ix_(free, held)] @ step[held]
        step[free] = np.linalg.solve(normal[np.ix_(free, free)], rest)
    return step
