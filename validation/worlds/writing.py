"""Writing a case as a gap data set of the contract, with its answer beside it or apart."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from acf_jax.documents import yaml_text
from acf_jax.files import write_text
from acf_jax.folders import whole_folder
from validation.worlds.case import Case, Trial
from validation.worlds.interface import Array

RIG_KEYS = (
    "moving_mass_kg",
    "damping_n_s_per_m",
    "actuator_stiffness_n_per_m",
    "contact_stiffness_n_per_m",
)


def write_case(case: Case, folder: Path, answer: Path | None = None) -> None:
    """Write the data set whole or not at all; its answer goes to `answer`, or beside it where absent.

    Files: dataset.yaml, trials.csv, traces/, held_out_conditions.csv, held_out_traces/, answer.yaml.
    """
    with whole_folder(folder) as scratch:
        _write_data(case, scratch)
        if answer is None:
            write_text(scratch / "answer.yaml", yaml_text(answer_of(case)))
    if answer is not None:
        write_text(answer, yaml_text(answer_of(case)))


def write_data(case: Case, folder: Path) -> None:
    """The same without any answer."""
    with whole_folder(folder) as scratch:
        _write_data(case, scratch)


def _write_data(case: Case, folder: Path) -> None:
    write_text(folder / "dataset.yaml", yaml_text(_dataset(case)))
    write_text(folder / "trials.csv", _trials(case.trials))
    write_text(folder / "held_out_conditions.csv", _conditions(case.held_out))
    for trial in case.trials:
        write_text(folder / "traces" / f"{trial.name}.csv", _trace(trial.time, trial.force, 2))
    for trial in case.held_out:
        write_text(folder / "held_out_traces" / f"{trial.name}.csv", _trace(trial.time, trial.force, 3))


def answer_of(case: Case) -> dict[str, Any]:
    """The hidden truth: the keys that scores read first, then what the world knows besides."""
    rig = (case.setup.rig.m, case.setup.rig.d, case.setup.rig.k_f, case.setup.rig.k_c)
    asked = {name: cause for name, cause in case.causes.items() if name not in case.background}
    return {
        "effects": list(asked),
        "components": sorted({cause.component for cause in asked.values()}),
        **_lifelike(case),
        "noise": "coloured" if case.setup.noise.memory else "white",
        "held_out_peak_force_n": {trial.name: round(trial.peak, 3) for trial in case.held_out},
        "outside_library": case.outside_library,
        "world": case.world,
        "seed": case.seed,
        "whitened_distance": float(f"{case.distance:.4g}"),
        "sizes": {name: float(f"{size:.4g}") for name, size in case.sizes.items()},
        "rig": {key: float(f"{value:.6g}") for key, value in zip(RIG_KEYS, rig, strict=True)},
        "parameters": {name: _plain(asdict(cause)) for name, cause in case.causes.items()},  # type: ignore[call-overload]
        "trigger_jitter_samples": case.setup.jitter,
        "trigger_delay_samples": round(case.setup.delay, 4),
        "faulty_trials": {trial.name: trial.fault for trial in case.trials if trial.fault},
    }


def _lifelike(case: Case) -> dict[str, Any]:
    """What an answer says of a rig with small effects besides: the shares of the force, and whether trials ring."""
    if not case.background:
        return {}
    shares = {name: round(share, 4) for name, share in case.shares.items()}
    ring = case.setup.ring
    return {
        "background": {name: shares[name] for name in case.background},
        "shares": {name: share for name, share in shares.items() if name not in case.background},
        "ring_of_each_trial": ring is not None,
        **(
            {"ring": {"frequency_hz": ring.frequency, "decay_s": ring.decay, "share_of_peak": ring.share}}
            if ring
            else {}
        ),
    }


def _dataset(case: Case) -> dict[str, Any]:
    return {
        "schema": "acf-gap-dataset/1",
        "description": "impact tests on one rig",
        "rig": {
            key: {"value": value, "std": std}
            for key, (value, std) in zip(RIG_KEYS, case.setup.prior, strict=True)
        },
        "measurement": {
            "force_noise_std_n": round(case.setup.noise.std, 3),
            "contact_velocity_rel_std": case.setup.spread,
            "pretension_rel_std": case.setup.spread,
        },
    }


def _trials(trials: Sequence[Trial]) -> str:
    rows = [
        f"{t.name},{t.commanded.v_e:g},{t.commanded.f_p:.1f},{t.peak:.2f},traces/{t.name}.csv" for t in trials
    ]
    return "\n".join(["trial,contact_velocity_m_per_s,pretension_n,peak_force_n,trace", *rows, ""])


def _conditions(trials: Sequence[Trial]) -> str:
    rows = [f"{t.name},{t.commanded.v_e:g},{t.commanded.f_p:.1f}" for t in trials]
    return "\n".join(["trial,contact_velocity_m_per_s,pretension_n", *rows, ""])


def _trace(time: Array, force: Array, decimals: int) -> str:
    rows = [f"{t:.7f},{f:.{decimals}f}" for t, f in zip(time.tolist(), (force + 0.0).tolist(), strict=True)]
    return "\n".join(["time_s,force_n", *rows, ""])


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    return value.item() if isinstance(value, np.generic) else value
