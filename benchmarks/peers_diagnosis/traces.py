"""What a method without our fits sees of a data set: the samples in contact, and what is known of the rig."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from acf_jax.dataset import assess_dataset, read_dataset
from acf_jax.errors import InputError
from acf_jax.inference.observations import TRIGGER, Observations, observe


@dataclass(frozen=True)
class Traces:
    """The traces of a data set, padded to the same length."""

    v_e: np.ndarray  # (trials,) m/s
    f_p: np.ndarray  # (trials,) N
    time: np.ndarray  # (trials, n) s after first contact
    force: np.ndarray  # (trials, n) N
    used: np.ndarray  # (trials, n) bool
    interval: np.ndarray  # (trials,) s
    noise: float  # N, standard deviation of a sample
    dependent: float  # how many neighbouring samples count as one independent one
    spread: tuple[float, float]  # relative, of velocity and pretension from trial to trial
    rig: np.ndarray  # (4,) nominal m, d, k_F, k_C, SI units
    rig_std: np.ndarray  # (4,)

    @property
    def impact_time(self) -> float:
        """Half a period of the nominal rig, s."""
        m, _, k_f, k_c = self.rig
        return float(np.pi * np.sqrt(m / (k_f + k_c)))

    @property
    def trigger(self) -> np.ndarray:
        """(trials,) standard deviation of a trigger, s."""
        return TRIGGER * self.interval


def read_traces(folder: Path) -> Traces:
    """The traces of a data set as our diagnosis would compare them.

    **Raises:** `InputError` where the data cannot be read, or no trial has a trace.
    """
    return traces_of(observe(assess_dataset(read_dataset(folder))), folder)


def traces_of(observed: Observations, folder: Path) -> Traces:
    """Those trials that have one."""
    o = observed.subset(~observed.peak_only)
    if not o.names:
        raise InputError(f"{folder}: no trial has a trace; name data sets with traces")
    return Traces(
        o.v_e,
        o.f_p,
        o.time,
        o.force,
        o.used,
        o.interval,
        o.noise.std,
        o.noise.samples_per_independent(float(np.median(o.interval))),
        o.rel_std,
        o.prior.values,
        o.prior.stds,
    )
