"""The model about one point: trials of one condition are simulated once."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.inference.fit import grid_for
from acf_jax.inference.linear import predict
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import COMMON
from tests.imagined import RIG, imagined


def repeated(effect: str, values: tuple[float, ...]) -> tuple[Observations, Observations]:
    """Four trials of each of three conditions, and the same as twelve conditions."""
    apart = imagined(effect, values)
    first = 3 * (np.arange(len(apart.names)) % 3)
    same = replace(apart, v_e=apart.v_e[first], f_p=apart.f_p[first])
    return replace(same, condition=first), replace(same, condition=np.arange(len(first)))


def forces(o: Observations, effect: str, values: tuple[float, ...], nuisance: np.ndarray) -> np.ndarray:
    theta = np.array([*RIG.values, *values, *np.zeros(COMMON)])
    return np.where(o.used, predict(o, (effect,), theta, nuisance, grid_for(o, (effect,))), 0.0)


@pytest.mark.parametrize(
    "effect, values, most",
    [
        ("gravity", (12.0,), 0.02),  # the force is linear in velocity and pretension until contact is lost
        ("contact_hardening", (0.3, 0.0, 1.9), 0.1),
        ("coulomb_friction", (15.0, 0.05, 0.02), 0.1),
    ],
)
def test_repeats_are_simulated_once_and_differ_as_if_each_were(
    effect: str, values: tuple[float, ...], most: float
) -> None:
    """To a share of the noise."""
    together, apart = repeated(effect, values)
    assert together.simulated.max() == 2 and apart.simulated.max() == len(apart.names) - 1
    nuisance = np.random.default_rng(0).standard_normal((len(apart.names), apart.n_nuisances))
    found, exact = (forces(o, effect, values, nuisance) for o in (together, apart))
    bare = forces(together, effect, values, 0 * nuisance)
    assert np.abs(found - bare).max() > 5 * apart.noise.std  # what nuisances change is to be seen
    rms = np.sqrt(((found - exact)[apart.used] ** 2).mean())
    assert rms < most * apart.noise.std
