"""A world integrated by LSODA, whose forms are richer than those of the candidate effects."""

from validation.worlds.scipy_world.plant import ScipyWorld

world = ScipyWorld()
