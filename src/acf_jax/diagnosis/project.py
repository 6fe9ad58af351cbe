"""What nominal parameters and nuisances cannot imitate: inner products of signatures with their part projected off."""

from dataclasses import dataclass

import numpy as np

from acf_jax.diagnosis.fit import N_OWN, Linearisation


@dataclass(frozen=True)
class Projector:
    """P = (I + A A')^-1 for the derivatives A of parameters and nuisances, in units of their priors.

    x' P y is the inner product of whitened signals after the best answer of parameters and nuisances, at the cost that
    their priors set. Signals have the shape (trials, n).
    """

    by_parameter: np.ndarray
    by_own: np.ndarray
    own_inverse: np.ndarray
    hessian_inverse: np.ndarray

    @classmethod
    def at(cls, linear: Linearisation) -> "Projector":
        """The projector at a linearisation."""
        j, own = linear.by_parameter, linear.by_own
        own_inverse = np.linalg.inv(np.einsum("ian,ibn->iab", own, own) + np.eye(N_OWN))
        cross = np.einsum("ipn,ian->ipa", j, own)
        reduced = np.einsum("ipa,iab,iqb->pq", cross, own_inverse, cross, optimize=True)
        hessian = np.einsum("ipn,iqn->pq", j, j, optimize=True) - reduced + np.eye(j.shape[1])
        return cls(j, own, own_inverse, np.linalg.inv(hessian))

    def gram(self, signals: np.ndarray) -> np.ndarray:
        """x' P y of all pairs of `signals` (k, trials, n): (k, k)."""
        on_own, plain = self._own_part(signals)
        on_parameters = self._parameter_part(signals, on_own)
        return plain - on_parameters @ self.hessian_inverse @ on_parameters.T

    def gram_of_nuisances(self, signals: np.ndarray) -> np.ndarray:
        """The same with only the trials' own nuisances projected off."""
        return self._own_part(signals)[1]

    def _own_part(self, signals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        on_own = np.einsum("ian,kin->kia", self.by_own, signals, optimize=True)
        taken = np.einsum("kia,iab,lib->kl", on_own, self.own_inverse, on_own, optimize=True)
        return on_own, np.einsum("kin,lin->kl", signals, signals, optimize=True) - taken

    def _parameter_part(self, signals: np.ndarray, on_own: np.ndarray) -> np.ndarray:
        cross = np.einsum("ipn,ian->ipa", self.by_parameter, self.by_own, optimize=True)
        direct = np.einsum("ipn,kin->kp", self.by_parameter, signals, optimize=True)
        return direct - np.einsum("ipa,iab,kib->kp", cross, self.own_inverse, on_own, optimize=True)
