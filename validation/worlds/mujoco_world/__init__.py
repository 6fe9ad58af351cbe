"""A world in a physics engine: bodies on slide joints, tendons, limits, actuators and sensors of MuJoCo."""

from acf_jax.errors import InputError

try:
    import mujoco  # noqa: F401
except ImportError as error:
    raise InputError(
        "world 'mujoco' needs the package mujoco; install it with `pip install mujoco`"
    ) from error

from validation.worlds.mujoco_world.engine import MujocoWorld

world = MujocoWorld()
