"""The speed limit of ISO/TS 15066 itself, for comparison."""

import math


def robot_mass(moving: float, payload: float) -> float:
    """m_R = M/2 + m_L, kg: half of the moving parts' mass and the payload (ISO/TS 15066:2016, A.3.4)."""
    return moving / 2 + payload


def highest_speed(force: float, stiffness: float, body_mass: float, mass: float) -> float:
    """v_max = F/sqrt(mu k), mu = (1/m_H + 1/m_R)^-1, m/s (ISO/TS 15066:2016, A.3.4).

    It turns the robot's kinetic energy into the body's spring energy; neither pretension nor flange nor pad is in it.
    """
    mu = 1 / (1 / body_mass + 1 / mass)
    return force / math.sqrt(mu * stiffness)
