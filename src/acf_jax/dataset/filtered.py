"""A data set behind a low-pass that is applied now, to leave out what is faster than any cause that is asked for."""

from dataclasses import replace

import numpy as np

from acf_jax.dataset import units
from acf_jax.dataset.advice import BOUNDS
from acf_jax.dataset.low_pass import Filter, is_even_enough, low_passed, noise_behind
from acf_jax.dataset.quality import Quality, assess_dataset
from acf_jax.dataset.trials import GapDataset, LowPass
from acf_jax.errors import InputError

LEAST = 3  # trials


def assess_low_passed(dataset: GapDataset, low_pass: LowPass) -> Quality:
    """The quality of a data set whose traces are sent through a filter; its `dataset` holds what came out.

    Damage is told, and undone, in the traces as they were read: a filter would smear it. So a trial without trace, or
    whose force is cut off, is left out.

    **Raises:** `InputError` where the filter cannot be applied, or fewer than three trials are left.
    """
    where = f"{dataset.folder}: low-pass"
    if dataset.measurement.low_pass:
        raise InputError(
            f"{where}: dataset.yaml states measurement.low_pass, a filter that the traces have been through already;"
            " leave one of the two out"
        )
    if fault := units.low_pass_fault(low_pass, dataset.rig.impact_time, dataset.trials):
        raise InputError(f"{where}: {fault}")
    whole = assess_dataset(dataset)
    left_out, kept = dict(whole.excluded), []
    for trial, look in zip(whole.dataset.trials, whole.trials, strict=True):
        if trial.trace is None:
            left_out.setdefault(trial.name, "it has no trace that could be filtered")
        elif look.phase and look.phase.cut_off is not None:
            left_out.setdefault(trial.name, "its force is cut off, which a filter would smear")
        elif not is_even_enough(trial.trace):
            left_out.setdefault(trial.name, "its samples are too uneven in time to be filtered")
        if trial.name not in left_out and trial.trace is not None:
            kept.append(replace(trial, trace=low_passed(trial.trace, low_pass), peak_force=None))
    if len(kept) < LEAST:
        raise InputError(
            f"{where}: {len(kept)} of {len(whole.trials)} trials have a whole trace that can be filtered, and {LEAST}"
            " are needed; leave the filter out"
        )
    traces = [trial.trace for trial in kept if trial.trace]
    stated = whole.noise.source == "stated" or noise_behind(traces, low_pass) is None
    gain = Filter(low_pass, float(np.median([trace.step for trace in traces]))).gain
    slow = whole.noise.share  # of the noise, which passes
    left = whole.noise.std * float(np.sqrt((1 - slow) * gain**2 + slow))
    measurement = replace(
        dataset.measurement, low_pass=low_pass, range_n=None, force_noise_std_n=left if stated else None
    )
    again = assess_dataset(replace(whole.dataset, measurement=measurement, trials=tuple(kept)))
    names = {trial.name for trial in kept}
    doubts = (line for line in (*whole.doubts, *again.doubts) if BOUNDS not in line)
    lines = (f"trial {name} is left out: {reason}" for name, reason in left_out.items())
    doubts_once = tuple(dict.fromkeys(doubts))
    return replace(
        again,
        excluded=left_out | again.excluded,
        damaged=tuple(dict.fromkeys(n for n in (*whole.damaged, *again.damaged) if n in names)),
        doubts=doubts_once,
        warnings=tuple(dict.fromkeys((*doubts_once, *lines, *again.warnings))),
    )
