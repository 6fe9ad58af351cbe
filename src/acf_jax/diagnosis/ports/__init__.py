"""The four ports through which an unknown cause can act, each with a flexible discrepancy instead of a physical law."""

from acf_jax.diagnosis.ports.actuator import UnknownActuator
from acf_jax.diagnosis.ports.contact import UnknownContact
from acf_jax.diagnosis.ports.robot import UnknownRobot
from acf_jax.diagnosis.ports.sensor import UnknownSensor
from acf_jax.effects import AbstractEffect

CONTINUED = (UnknownContact, UnknownSensor)  # their curves go on straight beyond a reach


def ports() -> dict[str, type[AbstractEffect]]:
    """The port's discrepancy by its name, in the order actuator, contact, robot, sensor."""
    return {
        f"unknown_{cls.component}": cls
        for cls in (UnknownActuator, UnknownContact, UnknownRobot, UnknownSensor)
    }
