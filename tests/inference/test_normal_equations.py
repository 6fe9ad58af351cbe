"""Normal equations with the nuisances eliminated, against the whole least-squares problem."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.inference.discrepancy import discrepancy
from acf_jax.inference.fit import fit
from acf_jax.inference.linear import normal_equations
from acf_jax.inference.parameters import begin
from tests.imagined import RIG, imagined


@pytest.mark.parametrize("size", [None, 0.03])
def test_a_step_is_that_of_the_whole_problem(size: float | None) -> None:
    """With and without waves, of each trial and of all, whose products are made once."""
    plain = imagined("gravity", (12.0,))
    o = replace(plain, discrepancy=size and discrepancy(plain, size))
    rng = np.random.default_rng(0)
    nuisance = 0.1 * rng.standard_normal((len(o.names), o.n_nuisances))
    fitted = fit(o, ("gravity",), begin(RIG.values * 1.02, [5.0]), nuisance, warm=True, iterations=0)
    linear = fitted.linearised()
    trials, p, n = linear.by_parameter.shape
    q = nuisance.shape[1]
    own = np.zeros((trials, n, trials, q))
    for i in range(trials):
        own[i, :, i] = linear.by_nuisance[i].T
    design = np.concatenate(
        [linear.by_parameter.transpose(0, 2, 1).reshape(-1, p), own.reshape(-1, trials * q)], axis=1
    )
    whole = np.concatenate([design / np.sqrt(1.7), np.eye(design.shape[1])])
    left = np.concatenate([linear.residual.ravel() / np.sqrt(1.7), -fitted.u, -nuisance.ravel()])
    step, *_ = np.linalg.lstsq(whole, left, rcond=None)
    normal = normal_equations(linear, fitted.u, nuisance, 1.7)
    found = -np.linalg.solve(normal.hessian, normal.gradient)
    np.testing.assert_allclose(found, step[:p], rtol=1e-6, atol=1e-9)
    gain = 0.5 * ((left**2).sum() - ((left - whole @ step) ** 2).sum())
    assert normal.expected(found) == pytest.approx(gain, rel=1e-6)
    assert 0.5 * normal.gain == pytest.approx(gain, rel=1e-6)
