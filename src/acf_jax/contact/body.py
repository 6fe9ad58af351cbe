"""What the flange meets: a stiffness in series with the contact's, and a mass that can recoil."""

from typing import NamedTuple

from jaxtyping import Array, Float

Scalar = Float[Array, ""] | float


class Body(NamedTuple):
    """A spring before a mass, both by their inverses: zero and zero is a rigid wall."""

    compliance: Scalar = 0.0  # m/N, 1/k_H
    mobility: Scalar = 0.0  # 1/kg, 1/m_H; zero where the body cannot recoil


WALL = Body()


def series_stiffness(k_c: Scalar, body: Body) -> Scalar:
    """k = 1/(1/k_C + 1/k_H), N/m."""
    return k_c / (1 + k_c * body.compliance)


def reduced_mass(m: Scalar, body: Body) -> Scalar:
    """mu = 1/(1/m + 1/m_H), kg.

    With w = x + y, y the body's recoil, m_H y'' = F_C turns Eq. (1) into mu w'' + (mu/m)(d x' + k_F x) = F_C: the
    paper's model with mu for m, exactly so for d = k_F = 0. Otherwise d w' + k_F w in place of
    (mu/m)(d x' + k_F x) holds the flange back more than it is, so the peak force is an upper bound.
    """
    return m / (1 + m * body.mobility)
