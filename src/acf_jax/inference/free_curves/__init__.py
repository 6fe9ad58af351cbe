"""The free curves: at each component a flexible function in place of the law of an unknown cause."""

import functools

from acf_jax.effects import AbstractEffect
from acf_jax.inference.free_curves.unknown_actuator import UnknownActuator
from acf_jax.inference.free_curves.unknown_contact import UnknownContact
from acf_jax.inference.free_curves.unknown_robot import UnknownRobot
from acf_jax.inference.free_curves.unknown_sensor import UnknownSensor

CONTINUED = (UnknownContact, UnknownSensor)  # they go on straight beyond a reach


@functools.cache
def free_curves() -> dict[str, type[AbstractEffect]]:
    """The free curves by id, in the order actuator, contact, robot, sensor."""
    return {cls.id(): cls for cls in (UnknownActuator, UnknownContact, UnknownRobot, UnknownSensor)}
