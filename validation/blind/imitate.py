"""Which effects of the library could be taken for a cause that the diagnosis cannot know, computed before it runs."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from acf_jax.dataset import GapDataset, Measurement, Noise, Prior, RigPrior, Trace, Trial, assess_dataset
from acf_jax.diagnosis.candidates import fit_nominal, fit_single
from acf_jax.diagnosis.identifiability import BAYES_ERROR, bayes_error, misfit
from acf_jax.effects import library
from acf_jax.inference.baseline import Ground
from acf_jax.inference.observations import Observations, observe
from validation.worlds import Case, find_world


def imitators(case: Case, without: str = "") -> dict[str, float]:
    """The effects that imitate the case's cause so well that the best method would confuse them with it.

    Each is fitted, with the rig under its priors, to the forces of the world without noise; what it cannot imitate is
    the whitened distance d, and the Bayes error Q(d/2) that of an even decision between the two.

    **Returns:** Bayes error by effect, where it exceeds 10 %.
    """
    observations = _quiet(case)
    ground = Ground.of(observations, fit_nominal(observations))
    errors = {}
    for name in library():
        if name != without:
            fitted = fit_single(ground, name)
            errors[name] = bayes_error(np.sqrt(max(0.0, misfit(fitted))))
    return {name: round(error, 4) for name, error in errors.items() if error > BAYES_ERROR}


def _quiet(case: Case) -> Observations:
    """The case's trials as they would be compared, free of noise, scatter and faults."""
    setup, world = case.setup, find_world(case.world)
    trials: list[Trial] = []
    for impact in setup.conditions:
        response = world.respond(setup.rig, list(case.causes.values()), impact, setup.time, setup.after_loss)
        trace = Trace(np.asarray(response.time, float), np.asarray(response.sensed, float))
        trials += [
            Trial(f"t{len(trials) + k}", impact.v_e, impact.f_p, None, trace) for k in range(setup.repeats)
        ]
    std, memory = setup.noise.std, setup.noise.memory
    # about the truth: what the prior's error costs is no question of the cause
    rig = (setup.rig.m, setup.rig.d, setup.rig.k_f, setup.rig.k_c)
    prior = RigPrior(*(Prior(value, std) for value, (_, std) in zip(rig, setup.prior, strict=True)))
    measurement = Measurement(std, setup.spread, setup.spread)
    dataset = GapDataset(Path("quiet"), "", prior, measurement, tuple(trials))
    noise = Noise(std, share=1.0, correlation_time=-setup.interval / np.log(memory)) if memory else Noise(std)
    return replace(observe(assess_dataset(dataset)), noise=noise)
