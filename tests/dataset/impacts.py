"""Made-up gap data sets with known truth: the paper's closed form until contact is lost, and noise."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from acf_jax.dataset import GapDataset, Measurement, Prior, RigPrior, Trace, Trial

M, D, K_F, K_C = 2.1, 60.0, 800.0, 3.4e5
RIG = RigPrior(Prior(M, 0.04), Prior(D, 18.0), Prior(K_F, 500.0), Prior(K_C, 4e4))
CONDITIONS = [(v, p) for p in (60.0, 100.0) for v in (0.05, 0.1, 0.2, 0.3, 0.35)]
YAML = """\
schema: acf-gap-dataset/1
description: made up
rig:
  moving_mass_kg:             {value: 2.10, std: 0.04}
  damping_n_s_per_m:          {value: 60.0, std: 18.0}
  actuator_stiffness_n_per_m: {value: 800.0, std: 500.0}
  contact_stiffness_n_per_m:  {value: 3.4e5, std: 4.0e4}
measurement:
  force_noise_std_n: 1.0
"""


def contact_force(t, v, f_p, m=M, d=D, k_f=K_F, k_c=K_C):
    """Eqs. 5 to 8 of the paper for an underdamped rig, zero once contact is lost."""
    k, delta = k_f + k_c, d / (2 * m)
    nu = np.sqrt(k / m - delta**2)
    c, slope = f_p / k - d * k_c * v / k**2, k_c * v / k
    a, b = -c, (-delta * c - slope) / nu
    x = np.exp(-delta * t) * (a * np.cos(nu * t) + b * np.sin(nu * t)) + c + slope * t
    force = k_c * (v * t - x) + f_p
    lost = np.flatnonzero((t > 0.0) & (force <= 0.0))
    if lost.size:
        force[lost[0] :] = 0.0
    return np.where(t < 0.0, 0.0, force)


def sampled(v, f_p, rng, *, std=1.0, rate=8000.0, end=0.014, step=0.05, share=0.0, tau=1e-3, late=0.0):
    """One noisy, quantised trace, from 3 ms before contact to `end`; `late` shifts its trigger, s."""
    time = np.arange(-round(0.003 * rate), round(end * rate)) / rate
    slow = np.zeros_like(time)
    decay = np.exp(-1.0 / (rate * tau))
    drawn = rng.normal(size=(2, time.size))
    slow[0] = drawn[0, 0]
    for i in range(1, time.size):
        slow[i] = decay * slow[i - 1] + np.sqrt(1.0 - decay**2) * drawn[0, i]
    noise = std * (np.sqrt(share) * slow + np.sqrt(1.0 - share) * drawn[1])
    force = contact_force(time, v, f_p) + noise
    force = np.round(force / step) * step if step else force
    return Trace(time + late, force)


def made_up(seed=0, repeats=2, conditions=CONDITIONS, spread=0.004, stated=True, **options) -> GapDataset:
    """A healthy data set of the nominal rig."""
    rng = np.random.default_rng(seed)
    trials = []
    for v, f_p in conditions:
        for _ in range(repeats):
            true = (v, f_p) * (1.0 + spread * rng.normal(size=2))
            trace = sampled(*true, rng, **options)
            peak = float(trace.force[trace.time >= 0.0].max())
            trials.append(Trial(f"t{len(trials):03d}", v, f_p, peak, trace))
    measurement = Measurement(options.get("std", 1.0) if stated else None, 0.004, 0.004)
    return GapDataset(Path("made-up"), "made up", RIG, measurement, tuple(trials))


def with_trial(dataset: GapDataset, index: int, trial: Trial) -> GapDataset:
    """`dataset` with one trial replaced."""
    trials = list(dataset.trials)
    trials[index] = trial
    return replace(dataset, trials=tuple(trials))


def with_force(trial: Trial, force) -> Trial:
    """`trial` with another force, its peak column to match."""
    peak = float(force[trial.trace.time >= 0.0].max())
    return replace(trial, trace=Trace(trial.trace.time, force), peak_force=peak)


def write(folder: Path, count: int = 4) -> Path:
    """A small valid data set as files."""
    (folder / "traces").mkdir(parents=True)
    (folder / "dataset.yaml").write_text(YAML)
    rows = ["trial,contact_velocity_m_per_s,pretension_n,peak_force_n,trace"]
    for trial in made_up(repeats=1).trials[:count]:
        relative = f"traces/{trial.name}.csv"
        rows.append(f"{trial.name},{trial.contact_velocity},{trial.pretension},{trial.peak_force},{relative}")
        samples = zip(trial.trace.time, trial.trace.force, strict=True)
        lines = ["time_s,force_n", *(f"{t:.6f},{f:.2f}" for t, f in samples)]
        (folder / relative).write_text("\n".join(lines) + "\n")
    (folder / "trials.csv").write_text("\n".join(rows) + "\n")
    return folder
