"""Which strengths act: against fits without the others, of a linear model whose second order is exact."""

from itertools import product

import numpy as np
import pytest

from acf_jax.effects import Parameter, library
from acf_jax.evidence.strengths import _Known, of_size, ways
from acf_jax.inference.free_curves import free_curves
from acf_jax.inference.parameters import every_effect
from tests.imagined import imagined

STRENGTHS, REST = np.arange(3), np.arange(3, 5)
EVERY = np.eye(3, dtype=bool)


def _linear(kept: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Objective, solution and curvature of a linear model with some of its five columns, under normal priors."""
    rng = np.random.default_rng(4)
    columns = rng.normal(size=(40, 5)) * 0.6
    data = columns @ [2.0, 0.1, -1.5, 0.4, -0.3] + rng.normal(size=40)
    j = columns[:, kept]
    curvature = j.T @ j + np.eye(len(kept))
    u = np.linalg.solve(curvature, j.T @ data)
    left = data - j @ u
    return 0.5 * float(left @ left + u @ u), u, curvature


def _known(of: np.ndarray, is_positive: bool = False) -> tuple[_Known, float]:
    """The strengths of the fit with all columns, and the log evidence of all else."""
    objective, u, h = _linear(np.arange(5))
    others, across = h[np.ix_(REST, REST)], h[np.ix_(REST, STRENGTHS)]
    curvature = h[np.ix_(STRENGTHS, STRENGTHS)] - across.T @ np.linalg.solve(others, across)
    positive = np.full(3, is_positive)
    known = _Known(STRENGTHS, u[STRENGTHS], curvature, of, EVERY, np.ones(3, bool), positive)
    return known, -objective - 0.5 * np.linalg.slogdet(others)[1]


@pytest.mark.parametrize("acts", [a for a in product([True, False], repeat=3) if any(a)])
@pytest.mark.parametrize("of", [(0, 0, 0), (0, 0, 1)])
def test_strengths_that_are_taken_out_leave_what_a_fit_without_them_has(
    acts: tuple[bool, ...], of: tuple[int, ...]
) -> None:
    known, rest = _known(np.array(of))
    chosen = np.flatnonzero(acts)
    objective, u, h = _linear(np.concatenate([chosen, REST]))
    variance = np.linalg.inv(h)
    each = [np.flatnonzero(np.array(of)[chosen] == k) for k in sorted(set(of))]
    sizes = sum(of_size(u[k], variance[np.ix_(k, k)]) for k in each)
    refitted = sizes - objective - 0.5 * np.linalg.slogdet(h)[1]
    assert rest + known.log_evidence(np.array(acts)) == pytest.approx(refitted, abs=1e-9)


def test_a_strength_of_one_sign_does_not_take_the_other() -> None:
    """The third strength is negative: no way of one sign has it."""
    known, _ = _known(np.zeros(3, int), is_positive=True)
    assert known.log_evidence(np.array([True, True, True])) == -np.inf
    assert np.isfinite(known.log_evidence(np.array([True, False, False])))


def test_a_shape_of_nothing_costs_nothing() -> None:
    """Without its strength what data told of it, and how far from its prior that was, count no more."""
    u, curvature = np.array([1.0, 3.0, 0.7]), np.diag([50.0, 0.5, 400.0])
    needs = np.array([[True, False, False], [False, True, False], [False, True, False]])
    is_strength = np.array([True, True, False])
    at, of, positive = np.arange(3), np.zeros(3, int), np.zeros(3, bool)
    known = _Known(at, u, curvature, of, needs, is_strength, positive)
    first = np.array([True, False, False])
    alone = of_size(u[:1], np.array([[1 / 50]])) - 0.5 * np.log(50.0)
    assert known.log_evidence(first) == pytest.approx(alone - 0.5 * 0.5 * 3.0**2 + 0.5 * 0.7**2)


def test_ways_are_all_signs_of_all_choices() -> None:
    for name in ("sensor_scale", "contact_damping", "contact_hardening", "pretension_error"):
        known = [p for p in library()[name].parameters() if p.is_size]
        signs = product(*[[0, 1, -1] if p.low < 0 else [0, 1] for p in known])
        assert ways(name) == sum(any(each) for each in signs)


NEEDY = [(name, p) for name, effect in every_effect().items() for p in effect.parameters() if p.needs]


@pytest.mark.long  # every free curve is compiled
@pytest.mark.parametrize(("name", "needy"), NEEDY, ids=[f"{name}-{p.name}" for name, p in NEEDY])
def test_a_parameter_says_something_beside_what_it_needs_alone(name: str, needy: Parameter) -> None:
    known = every_effect()[name].parameters()

    def force(acting: Parameter, factor: float) -> np.ndarray:
        """With a little of one strength alone, and a multiple of the parameter."""
        values = [p.scale if p.shape else 0.1 * p.scale * (p == acting) for p in known]
        values[known.index(needy)] = factor * _middle(needy)
        return imagined(name, tuple(values)).force

    for p in (p for p in known if p.is_size):
        says = not np.allclose(force(p, 1.0), force(p, 1.5), rtol=0, atol=1e-9)
        assert says == (p.name in needy.needs), p.name


def _middle(p: Parameter) -> float:
    """A value that trials see: levels and reaches lie within what an impact has."""
    return {"m": 5e-4, "N": 60.0, "s": 2e-3, "Hz": 100.0}.get(p.unit, p.scale)


def test_every_free_curve_says_what_its_shapes_need() -> None:
    for curve in free_curves().values():
        assert all(p.needs for p in curve.parameters() if p.shape)
