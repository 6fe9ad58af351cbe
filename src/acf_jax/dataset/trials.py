"""What a gap data set holds: the rig as known beforehand, how it was measured, and the trials."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Prior:
    """A quantity known beforehand: a normal distribution, cut off at zero."""

    value: float
    std: float


@dataclass(frozen=True)
class RigPrior:
    """The rig's parameters (paper, Eqs. 1 and 2) as known before the trials."""

    m: Prior  # kg, moving mass
    d: Prior  # N s/m, damping
    k_f: Prior  # N/m, actuator stiffness
    k_c: Prior  # N/m, contact stiffness

    @property
    def values(self) -> Array:
        """Prior values of (m, d, k_f, k_c), shape (4,)."""
        return np.array([self.m.value, self.d.value, self.k_f.value, self.k_c.value])

    @property
    def stds(self) -> Array:
        """Prior standard deviations of (m, d, k_f, k_c), shape (4,)."""
        return np.array([self.m.std, self.d.std, self.k_f.std, self.k_c.std])

    @property
    def impact_time(self) -> float:
        """Half a period of the undamped oscillation, pi sqrt(m/(k_F + k_C)): how long an impact lasts, s."""
        return float(np.pi * np.sqrt(self.m.value / (self.k_f.value + self.k_c.value)))

    def undamped_peak(self, v_e: Array, f_p: Array) -> Array:
        """Peak of the undamped impact at a velocity in m/s and a pretension in N, sqrt(F_P^2 + k_C m v^2), N."""
        return np.sqrt(f_p**2 + self.k_c.value * self.m.value * v_e**2)


@dataclass(frozen=True)
class LowPass:
    """A Butterworth filter; `zero_phase`: applied forwards and backwards, so that its order counts twice."""

    cutoff_hz: float
    order: int = 2
    zero_phase: bool = False


@dataclass(frozen=True)
class Measurement:
    """How the trials were measured."""

    force_noise_std_n: float | None = None  # N, of one sample; None: to be estimated from the approach
    contact_velocity_rel_std: float = 0.005  # spread of the true value about the commanded one
    pretension_rel_std: float = 0.005
    range_n: float | None = (
        None  # N, of the sensor: readings at it are lower bounds; None: told from flat tops
    )
    low_pass: LowPass | None = None  # that the readings have been through
    tool_mass_kg: float | None = (
        None  # of the moving mass, between contact and a sensor on the robot's side; None: the part's side
    )
    robot_velocity_std_m_per_s: float | None = None  # of a sample of `motion`; None: to be estimated, too


@dataclass(frozen=True)
class Trace:
    """Sensed force against time; first contact is at time 0."""

    time: Array  # s, increasing, shape (N,)
    force: Array  # N, shape (N,)

    @property
    def step(self) -> float:
        """Usual time between two samples, s."""
        return float(np.median(np.diff(self.time)))


@dataclass(frozen=True)
class RobotVelocity:
    """The robot's measured velocity over an impact, at its own rate; first contact is at time 0."""

    time: Array  # s, increasing, shape (N,)
    value: Array  # m/s, towards the part, shape (N,)

    @property
    def step(self) -> float:
        """Usual time between two samples, s."""
        return float(np.median(np.diff(self.time)))


@dataclass(frozen=True)
class Trial:
    """One impact: its condition, and the peak, the trace or both; how the robot moved, where that was measured."""

    name: str
    contact_velocity: float  # m/s
    pretension: float  # N
    peak_force: float | None = None  # N, largest sample of the sensed force within the impact phase
    trace: Trace | None = None
    other: Mapping[str, str] = field(default_factory=dict)  # further columns of trials.csv, as written
    motion: RobotVelocity | None = None

    @property
    def condition(self) -> tuple[float, float]:
        """Commanded contact velocity, m/s, and pretension, N."""
        return self.contact_velocity, self.pretension


@dataclass(frozen=True)
class GapDataset:
    """Impact trials of one rig, as read from a folder."""

    folder: Path
    description: str
    rig: RigPrior
    measurement: Measurement
    trials: tuple[Trial, ...]

    @cached_property
    def condition_of(self) -> tuple[int, ...]:
        """The number of each trial's condition, in the order of their first appearance.

        Trials are repeats where their velocities and pretensions differ by no more than the stated spread of either: a
        robot that is told the same says 0.1007 m/s now and 0.1018 m/s then.
        """
        seen: list[tuple[float, float]] = []
        numbers = []
        for trial in self.trials:
            same = (k for k, first in enumerate(seen) if self._are_repeats(first, trial.condition))
            number = next(same, len(seen))
            if number == len(seen):
                seen.append(trial.condition)
            numbers.append(number)
        return tuple(numbers)

    @property
    def conditions(self) -> dict[tuple[float, float], tuple[int, ...]]:
        """The trials (by index) of each condition, which is called by its first trial's."""
        groups: dict[int, list[int]] = {}
        for index, number in enumerate(self.condition_of):
            groups.setdefault(number, []).append(index)
        return {self.trials[group[0]].condition: tuple(group) for group in groups.values()}

    def _are_repeats(self, a: tuple[float, float], b: tuple[float, float]) -> bool:
        spreads = self.measurement.contact_velocity_rel_std, self.measurement.pretension_rel_std
        return all(abs(x - y) <= s * x for x, y, s in zip(a, b, spreads, strict=True))

    @property
    def digest(self) -> str:
        """SHA-256 of all that a diagnosis takes from the files."""
        digest = hashlib.sha256(repr((self.description, self.rig, self.measurement)).encode())
        for t in self.trials:
            digest.update(repr((t.name, t.contact_velocity, t.pretension, t.peak_force)).encode())
            if t.trace is not None:
                digest.update(np.stack([t.trace.time, t.trace.force]).tobytes())
            if t.motion is not None:
                digest.update(np.stack([t.motion.time, t.motion.value]).tobytes())
        return digest.hexdigest()
