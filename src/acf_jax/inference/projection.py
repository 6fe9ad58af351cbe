"""A fit's surroundings to second order: what its parameters and nuisances cannot imitate of a signal, and what of the
residual a signal explains."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from acf_jax.inference.fit import Fit
from acf_jax.inference.linear import Linearisation, Normal, half_chi_square, normal_equations


class Reduced(NamedTuple):
    """Signals (k, trials, n) with the nuisances eliminated."""

    plain: np.ndarray  # (k, k) inner products
    on_residual: np.ndarray  # (k,) with the residual
    on_parameters: np.ndarray  # (k, p) with the derivatives by the parameters


@dataclass(frozen=True)
class Projector:
    """P = (I + A A')^-1 for the derivatives A of parameters and nuisances, in units of their priors.

    x' P y is the inner product of whitened signals after the best answer of parameters and nuisances, at the cost that
    their priors set. Signals have the shape (trials, n). The point need not be an optimum: what a step of the
    parameters would still explain is no signal's merit.
    """

    linear: Linearisation
    normal: Normal
    left: float  # objective that a step of parameters and nuisances leaves, to first order
    low: np.ndarray  # (p,) how far each parameter is from its lower bound, negative
    high: np.ndarray

    @classmethod
    def of(cls, fitted: Fit) -> "Projector":
        """The projector at a fit."""
        return cls._at(fitted, fitted.linearised(), np.ones(len(fitted.u), bool))

    def without(self, fitted: Fit, taken: np.ndarray, change: np.ndarray) -> "Projector":
        """The same where parameters (by index) are taken out of the fit, all else as it is.

        `change`: (trials, n) of the residual.
        """
        linear, kept = self.linear, np.ones(len(fitted.u), bool)
        kept[taken] = False
        by_law = linear.by_law[:, kept[: linear.by_law.shape[1]]]
        return self._at(fitted, replace(linear, residual=linear.residual + change, by_law=by_law), kept)

    @classmethod
    def _at(cls, fitted: Fit, linear: Linearisation, kept: np.ndarray) -> "Projector":
        u, at = fitted.u[kept], fitted.coordinates
        normal = normal_equations(linear, u, fitted.nuisance)
        left = half_chi_square(linear, u, fitted.nuisance) - 0.5 * normal.gain
        return cls(linear, normal, left, at.low[kept] - u, at.high[kept] - u)

    def reduce(self, signals: np.ndarray) -> Reduced:
        """The inner products of signals (k, trials, n) that everything else follows from."""
        linear, normal = self.linear, self.normal
        on_nuisance = np.einsum("ian,kin->kia", linear.by_nuisance, signals, optimize=True)
        answered = np.einsum("iab,kib->kia", normal.nuisance_inverse, on_nuisance)
        plain = np.einsum("kin,lin->kl", signals, signals, optimize=True)
        direct = np.einsum("ipn,kin->kp", linear.by_parameter, signals, optimize=True)
        return Reduced(
            plain - np.einsum("kia,lia->kl", on_nuisance, answered),
            np.einsum("in,kin->k", linear.residual, signals)
            + np.einsum("ia,kia->k", normal.nuisance_gradient, answered),
            direct - np.einsum("ipa,kia->kp", normal.cross, answered, optimize=True),
        )

    def gram(self, signals: np.ndarray) -> np.ndarray:
        """x' P y of all pairs of `signals` (k, trials, n): (k, k)."""
        return self._gram(self.reduce(signals))

    def _gram(self, reduced: Reduced) -> np.ndarray:
        answer = np.linalg.solve(self.normal.hessian, reduced.on_parameters.T)
        return np.asarray(reduced.plain - reduced.on_parameters @ answer)

    def gram_of_nuisances(self, signals: np.ndarray) -> np.ndarray:
        """The same with only the nuisances projected off."""
        return self.reduce(signals).plain

    def promise(self, signal: np.ndarray) -> tuple[float, float]:
        """How much of a signal (trials, n) explains most of the residual, and the chi-square that this would gain.

        A parameter that presses against its bound is held there.
        """
        pressing = ((self.low > -1e-6) & (self.normal.gradient > 0)) | (
            (self.high < 1e-6) & (self.normal.gradient < 0)
        )
        free = ~pressing
        plain, on_residual, on_parameters = (part[0] for part in self.reduce(signal[None]))
        answer = np.linalg.solve(self.normal.hessian[free][:, free], on_parameters[free])
        size = float(plain[0] - on_parameters[free] @ answer)
        taken = float(on_residual + self.normal.gradient[free] @ answer)
        return (taken / size, taken**2 / size) if size > 0 else (0.0, 0.0)
