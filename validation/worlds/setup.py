"""A test campaign drawn at random: the rig, what is known of it, the trials and the measuring chain."""

from dataclasses import dataclass

import numpy as np

from validation.worlds.interface import Array, Impact, Rig

LONGEST = 0.06  # s, where contact is not lost
APPROACH = 0.003  # s
DELAY = 0.25  # samples by which all triggers of a campaign are late or early alike, at most
SAMPLE_RATES = (4000.0, 5000.0, 8000.0, 10000.0, 16000.0, 20000.0)  # Hz
VELOCITIES = (  # m/s
    (0.05, 0.1, 0.2, 0.3, 0.35),
    (0.05, 0.1, 0.2, 0.3, 0.4),
    (0.05, 0.15, 0.25, 0.35),
    (0.08, 0.16, 0.24, 0.32, 0.4),
    (0.06, 0.12, 0.2, 0.28),
)
PRETENSIONS = ((60.0, 100.0), (60.0, 100.0), (50.0, 90.0), (40.0, 80.0, 120.0))  # N
HELD_OUT = ((0.075, 0.15, 0.25, 0.4), (80.0, 120.0))  # m/s, N


@dataclass(frozen=True)
class Noise:
    """Autoregressive noise of the first order; white where `memory` is zero."""

    std: float  # N
    memory: float

    def draw(self, rng: np.random.Generator, n: int) -> Array:
        """`n` samples of the stationary process, N."""
        samples = rng.normal(0.0, self.std, n)
        for i in range(1, n):
            samples[i] = self.memory * samples[i - 1] + np.sqrt(1.0 - self.memory**2) * samples[i]
        return samples

    def whiten(self, residual: Array) -> Array:
        """The residual as independent samples of unit variance, shape as given: (n, ...)."""
        white = residual.copy()
        white[1:] = (residual[1:] - self.memory * residual[:-1]) / np.sqrt(1.0 - self.memory**2)
        return white / self.std


@dataclass(frozen=True)
class Ring:
    """A decaying oscillation of the fixture that every impact starts anew, at another amplitude and phase."""

    frequency: float  # Hz
    decay: float  # s, time constant
    share: float  # of the trial's peak: standard deviation of the cosine and of the sine part

    def draw(self, rng: np.random.Generator, time: Array, peak: float) -> Array:
        """Of one trial, N, at instants after first contact; zero before. `time`: s, shape (n,). `peak`: N."""
        cosine, sine = self.share * peak * rng.standard_normal(2)
        phase = 2.0 * np.pi * self.frequency * time
        swing = np.exp(-np.maximum(time, 0.0) / self.decay) * (cosine * np.cos(phase) + sine * np.sin(phase))
        return np.where(time > 0.0, swing, 0.0)


@dataclass(frozen=True)
class Setup:
    """One campaign on one rig."""

    rig: Rig  # the truth
    prior: tuple[tuple[float, float], ...]  # value and standard deviation known of m, d, k_F, k_C
    conditions: tuple[Impact, ...]
    repeats: int
    held_out: tuple[Impact, ...]
    interval: float  # s, between samples
    noise: Noise
    spread: float  # relative standard deviation of velocity and pretension, trial to trial
    jitter: float  # the trigger of a trial is off by at most this many samples
    delay: float  # samples by which all triggers are late besides
    quantum: float  # N
    after_loss: float  # s, for how long a recording goes on once contact is lost
    fault: str  # of one trial: "", "dropout", "loose_cable" or "wrong_label"
    ring: Ring | None = None

    @property
    def time(self) -> Array:
        """Sampling instants of a trial, s; 0 is first contact."""
        before = round(APPROACH / self.interval)
        return self.interval * np.arange(-before, round(LONGEST / self.interval) + 1)

    def late(self, rng: np.random.Generator) -> float:
        """By how much the trigger of one trial is late, s."""
        return float(self.interval * (self.delay + self.jitter * rng.uniform(-1.0, 1.0)))


def draw_rig(rng: np.random.Generator) -> Rig:
    """A rig from the range in which flanges and pads are found; impacts last 4 to 30 ms."""
    m = np.exp(rng.uniform(np.log(1.0), np.log(5.0)))
    k_c = np.exp(rng.uniform(np.log(5e4), np.log(6e5)))
    zeta = np.exp(rng.uniform(np.log(0.03), np.log(0.25)))
    k_f = k_c * rng.uniform(0.0, 0.03)
    return Rig(m=float(m), d=float(2.0 * zeta * np.sqrt(m * (k_c + k_f))), k_f=float(k_f), k_c=float(k_c))


def draw_prior(rng: np.random.Generator, rig: Rig) -> tuple[tuple[float, float], ...]:
    """What is known beforehand: values about the truth, each with the deviation it was drawn with."""
    stds = (
        0.02 * rig.m,
        rig.d * rng.uniform(0.2, 0.4),
        rig.k_c * rng.uniform(0.004, 0.015),
        rig.k_c * rng.uniform(0.09, 0.14),
    )
    prior = []
    for truth, std in zip((rig.m, rig.d, rig.k_f, rig.k_c), stds, strict=True):
        value = -1.0
        while value <= 0.0:  # the prior is cut off at zero
            value = rng.normal(truth, std)
        prior.append((float(f"{value:.6g}"), float(f"{std:.6g}")))
    return tuple(prior)


def draw_setup(rng: np.random.Generator, coloured: bool) -> Setup:
    """A campaign as laboratories run them: a grid of velocities and pretensions with repeats."""
    rig = draw_rig(rng)
    samples_per_impact = rng.uniform(50.0, 120.0)
    rate = min(SAMPLE_RATES, key=lambda f: abs(np.log(f * rig.half_period / samples_per_impact)))
    velocities = VELOCITIES[rng.integers(len(VELOCITIES))]
    pretensions = PRETENSIONS[rng.integers(len(PRETENSIONS))]
    return Setup(
        rig=rig,
        prior=draw_prior(rng, rig),
        conditions=tuple(Impact(v, f) for f in pretensions for v in velocities),
        repeats=int(rng.choice([1, 2, 3], p=[0.1, 0.75, 0.15])),
        held_out=tuple(Impact(v, f) for f in HELD_OUT[1] for v in HELD_OUT[0]),
        interval=1.0 / rate,
        noise=Noise(float(rng.uniform(0.5, 1.5)), float(rng.uniform(0.4, 0.85)) * coloured),
        spread=0.004,
        jitter=float(rng.choice([0.0, 0.5, 1.0], p=[0.4, 0.3, 0.3])),
        quantum=float(rng.choice([0.01, 0.05, 0.2], p=[0.2, 0.6, 0.2])),
        after_loss=float(rng.uniform(0.001, 0.004) * (rng.random() < 0.25)),
        fault=str(rng.choice(["", "dropout", "loose_cable", "wrong_label"], p=[0.91, 0.03, 0.03, 0.03])),
        delay=float(rng.uniform(-DELAY, DELAY)),
    )
