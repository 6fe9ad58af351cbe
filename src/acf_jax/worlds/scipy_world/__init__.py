"""A world integrated by LSODA, whose forms are richer than those of the candidate effects."""

from acf_jax.worlds.scipy_world.plant import ScipyWorld

world = ScipyWorld()
