"""Dry friction of guide and seals: LuGre bristles, or a smooth Stribeck curve with a viscous part.

Sources: Canudas de Wit et al., IEEE Trans. Autom. Control 40 (1995) 419; Armstrong-Helouvry et al.,
Automatica 30 (1994) 1083. Measured half-widths on pneumatic cylinders are 4 to 11 N; `size` 1 is 40 N at a pretension
of 80 N, a dry seal. Seals press harder under pressure: up to half of that grows with the pretension, as on printed
cylinders, whose O-ring went from 5.6 to 10.9 N over 1 to 7 bar (TU Delft, EvaZillen/3D-printed-pneumatic-actuator).
"""

from dataclasses import dataclass
from math import exp, tanh
from typing import Self

import numpy as np

from validation.worlds.interface import Impact, Rig
from validation.worlds.scipy_world.hooks import AbstractActuatorCause, Motion, State

USUAL = 80.0  # N, pretension


@dataclass(frozen=True)
class CoulombFriction(AbstractActuatorCause):
    """LuGre: z' = v - |v| z/z_max(v), F = F_c z/presliding + b v; Stribeck: F = F(v) tanh(v/v_0) + b v.

    F_c = force_n (1 - pressed + pressed F_P/80 N).
    """

    force_n: float
    static_ratio: float  # F_s/F_c
    stribeck_velocity: float  # m/s
    viscous: float  # N s/m
    presliding: float  # m; zero chooses the Stribeck form
    pressed: float  # share that grows with the pretension

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        force = 40.0 * size
        bristles = rng.random() < 0.5
        return cls(
            force_n=force,
            static_ratio=rng.uniform(1.0, 1.4),
            stribeck_velocity=rng.uniform(0.01, 0.05),
            viscous=force * rng.uniform(0.0, 0.3),
            presliding=rng.uniform(3e-6, 15e-6) * bristles,
            pressed=rng.uniform(0.0, 0.5),
        )

    def initial(self, rig: Rig, s: float, force: float) -> tuple[float, ...]:
        return (0.0,) if self.presliding else ()

    def _curve(self, v: float) -> float:
        return self.force_n * (1.0 + (self.static_ratio - 1.0) * exp(-((v / self.stribeck_velocity) ** 2)))

    def rates(self, z: State, rig: Rig, impact: Impact, now: Motion) -> tuple[float, ...]:
        if not self.presliding:
            return ()
        longest = self.presliding * self._curve(now.x_rate) / max(self.force_n, 1e-12)
        return (now.x_rate - abs(now.x_rate) * z[0] / longest,)

    def opposing(self, z: State, rig: Rig, impact: Impact, now: Motion) -> float:
        dry = (
            self.force_n * z[0] / self.presliding
            if self.presliding
            else self._curve(now.x_rate) * tanh(now.x_rate / 0.002)
        )
        grown = 1.0 + self.pressed * (impact.f_p / USUAL - 1.0)
        return grown * dry + self.viscous * now.x_rate
