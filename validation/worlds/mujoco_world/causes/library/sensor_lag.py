"""Finite bandwidth of the force measurement: an integrating converter behind an anti-aliasing filter.

Source: the sinc response of integrating converters, Kester, Data Conversion Handbook (2005), ch. 3.
"""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from validation.worlds.filters import low_pass
from validation.worlds.interface import Array, Rig
from validation.worlds.mujoco_world.scene import AbstractSceneCause, Scene


@dataclass(frozen=True)
class SensorLag(AbstractSceneCause):
    """The mean of a first-order lag's output over a window; its delay at low frequencies is `delay`."""

    component: ClassVar[str] = "sensor"

    delay: float  # s
    window_share: float  # of the delay that the window causes, half its length

    @classmethod
    def draw(cls, rng: np.random.Generator, rig: Rig, size: float) -> Self:
        return cls(0.15 * size * rig.half_period, rng.uniform(0.1, 0.6))

    def build(self, scene: Scene) -> None:
        pass

    def read(self, time: Array, reading: Array, record: dict[str, Array]) -> Array:
        smooth = low_pass(time, reading, [1.0], [(1.0 - self.window_share) * self.delay, 1.0])
        area = np.concatenate([[0.0], np.cumsum(0.5 * (smooth[1:] + smooth[:-1]) * np.diff(time))])
        window = 2.0 * self.window_share * self.delay
        return np.asarray((area - np.interp(time - window, time, area)) / window)
