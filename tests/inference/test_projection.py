"""A fit's surroundings to second order, against SciPy's bounded least squares."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from acf_jax.inference.fit import Fit, fit
from acf_jax.inference.parameters import begin
from acf_jax.inference.projection import Projector
from tests.imagined import RIG, imagined

RANDOM = np.random.default_rng(0)


@pytest.fixture(scope="module")
def astray() -> Fit:
    """A fit that ended early, beside data of an effect, k_F close to its bound."""
    observations = imagined("gravity", (12.0,))
    theta = begin(RIG.values * [1.01, 0.9, 0.05, 1.02])
    return fit(observations, (), theta, warm=True, iterations=0)


def augmented(fitted: Fit) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The whole linear problem: derivatives by parameters and by every nuisance, what is left, and lower bounds."""
    linear = fitted.linearised()
    trials, p, n = linear.by_parameter.shape
    nuisance = np.zeros((trials, n, trials, 3))
    for i in range(trials):
        nuisance[i, :, i] = linear.by_nuisance[i].T
    design = np.concatenate(
        [linear.by_parameter.transpose(0, 2, 1).reshape(-1, p), nuisance.reshape(-1, 3 * trials)], axis=1
    )
    left = np.concatenate([linear.residual.ravel(), -fitted.u, -fitted.nuisance.ravel()])
    low = np.concatenate([fitted.coordinates.low - fitted.u, np.full(3 * trials, -np.inf)])
    return np.concatenate([design, np.eye(design.shape[1])]), left, low


def padded(signal: np.ndarray, left: np.ndarray) -> np.ndarray:
    return np.concatenate([signal.ravel(), np.zeros(left.size - signal.size)])


def test_a_promise_is_no_merit_of_what_the_parameters_alone_would_explain(astray: Fit) -> None:
    """A signature that the mass imitates wholly promises no more than the mass's prior costs."""
    imitated = astray.linearised().by_parameter[:, 0]
    assert (astray.linearised().residual * imitated).sum() ** 2 / (imitated**2).sum() > 1e5
    assert Projector.of(astray).promise(imitated)[1] < 100.0


def test_a_promise_is_the_gain_of_a_least_squares_problem(astray: Fit) -> None:
    """With the signal as one more column, which has no prior."""
    design, left, _ = augmented(astray)
    signal = RANDOM.standard_normal(astray.linearised().residual.shape) + astray.linearised().residual
    free = replace(astray, coordinates=astray.coordinates._replace(low=np.full(6, -np.inf)))
    amount, gain = Projector.of(free).promise(signal)

    def cost(columns: np.ndarray) -> float:
        return float(lsq_linear(columns, left, tol=1e-12).cost)

    both = np.column_stack([design, padded(signal, left)])
    assert gain == pytest.approx(2 * (cost(design) - cost(both)), rel=1e-6)
    assert amount == pytest.approx(lsq_linear(both, left, tol=1e-12).x[-1], rel=1e-6)
