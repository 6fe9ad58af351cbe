"""The forward program of an explanation against JAX's own derivatives of the simulation."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from acf_jax.inference.forward import BLOCKS, Grid, block_for, forward, unpack
from acf_jax.inference.free_curves import free_curves
from acf_jax.inference.parameters import every_effect
from acf_jax.model import Impact
from acf_jax.simulator import simulate
from tests.effects.contract import QUICK

RIG = [2.0, 60.0, 800.0, 3e5]
V_E, F_P = np.array([0.1, 0.2]), np.array([60.0, 20.0])
GRID = Grid(2e-4, 120)
REACH = 25.0  # N, which both impacts exceed
LOW = {"level_n": 15.0, "level_m": 1e-4, "delay_s": 1e-3}  # within what the impacts reach


MANY = ("unknown_contact", "unknown_robot")  # parameters, which JAX compiles for long


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.long) if name in MANY else name
        for name in (*free_curves(), "pad_mass", "coulomb_friction")
    ],
)
def test_derivatives_are_those_of_jax(name: str) -> None:
    """With every strength at work, beyond the reach of a curve."""
    known = every_effect()[name].parameters()
    theta = np.array([*RIG, *(LOW.get(p.name, p.scale) if p.shape else 0.05 * p.scale for p in known)])
    forces = forward((name,), theta, V_E, F_P, GRID, REACH)

    def sensed(z: Array) -> tuple[Array, Array]:
        rig, effects = unpack((name,), z[:-2], REACH)
        response = simulate(rig, Impact(z[-2], z[-1]), effects, GRID.h, GRID.steps + 1)
        return response.sensed, response.contact

    z = jnp.column_stack([jnp.tile(theta, (2, 1)), V_E, F_P])
    both = jax.jit(jax.vmap(jax.jacfwd(sensed, has_aux=True)), compiler_options=QUICK)
    slopes, contact = (np.asarray(one) for one in both(z))
    assert (contact.max(axis=1) > REACH).all()
    np.testing.assert_allclose(forces.contact, contact, rtol=0, atol=1e-9 * contact.max())
    scale = np.abs(slopes).max(axis=1)[:, :, None]
    assert (scale > 0).any(axis=0).all()  # every parameter matters
    assert (np.abs(forces.tangents - slopes.swapaxes(1, 2)) <= 1e-9 * scale).all()


def test_an_effect_of_the_program_without_strength_changes_nothing() -> None:
    own, wider = ("gravity",), ("gravity", "pad_mass")
    theta = np.array([*RIG, 8.0])
    alone = forward(own, theta, V_E, F_P, GRID)
    within = forward(own, theta, V_E, F_P, GRID._replace(program=wider))
    assert within.rows.shape == alone.rows.shape
    scale = np.abs(alone.rows).max(axis=(0, 2))[:, None]
    assert (np.abs(within.rows - alone.rows) <= 1e-9 * scale).all()
    np.testing.assert_allclose(within.contact, alone.contact, rtol=0, atol=1e-9 * alone.contact.max())


@pytest.mark.parametrize("block", BLOCKS)
def test_trials_that_need_fewer_steps_are_the_same_up_to_there(block: int) -> None:
    """More trials than one call takes, in no order of their lengths."""
    rng = np.random.default_rng(0)
    v_e, f_p, steps = rng.uniform(0.05, 0.3, 30), rng.uniform(20, 100, 30), rng.integers(20, 120, 30)
    theta = np.array([*RIG, 8.0])
    whole = forward(("gravity",), theta, v_e, f_p, GRID)
    found = forward(("gravity",), theta, v_e, f_p, GRID._replace(block=block), steps=steps)
    scale = np.abs(whole.rows).max(axis=(0, 2))[:, None]
    for i, last in enumerate(steps + 1):
        np.testing.assert_allclose(found.contact[i, :last], whole.contact[i, :last], rtol=1e-9, atol=1e-9)
        assert (np.abs(found.rows[i, :, :last] - whole.rows[i, :, :last]) <= 1e-9 * scale).all()


@pytest.mark.parametrize(
    "steps, block",
    [([300] * 20, 24), ([300] * 30, 16), ([300] * 6, 8), ([1000] * 4 + [100] * 16, 8)],
    ids=["as many as fit", "two calls", "few", "few long ones"],
)
def test_as_many_trials_a_call_as_are_simulated_soonest(steps: list[int], block: int) -> None:
    assert block_for(np.array(steps)) == block
