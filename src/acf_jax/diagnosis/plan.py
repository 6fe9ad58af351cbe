"""Before any data: what a proposed set of trials could detect and tell apart on a rig."""

import numpy as np

from acf_jax.dataset import Measurement, Noise, RigPrior, Trial
from acf_jax.dataset.low_pass import is_kept, settling_time
from acf_jax.diagnosis.candidates import unfitted
from acf_jax.diagnosis.identifiability import Detectability, detectability
from acf_jax.effects import library
from acf_jax.inference.fit import RESOLVED
from acf_jax.inference.forward import SAMPLES, Grid, forward, step_for
from acf_jax.inference.interpolation import at_times, first_loss
from acf_jax.inference.observations import ONSET, Observations, compared_time


def plan(
    rig: RigPrior,
    measurement: Measurement,
    conditions: tuple[Trial, ...],
    sample_rate: float,
    noise_std: float,
) -> list[Detectability]:
    """What trials at these conditions could say of every effect, on the rig's prior values.

    **Arguments:** `conditions`: one a trial, repeats as further ones. `sample_rate`: Hz. `noise_std`: of one sample, N.

    **Returns:** one `Detectability` an effect, in alphabetical order.
    """
    observations = imagine(rig, measurement, conditions, sample_rate, noise_std)
    nominal = unfitted(observations)
    return detectability(observations, nominal, list(library()))


def imagine(
    rig: RigPrior,
    measurement: Measurement,
    conditions: tuple[Trial, ...],
    sample_rate: float,
    noise_std: float,
) -> Observations:
    """Noise-free trials of the paper's model, as they would be compared: behind a filter, up to the range's end."""
    low_pass, range_n = measurement.low_pass, measurement.range_n or np.inf
    end = compared_time(rig)
    # without phase shift a reading knows what follows it
    later = settling_time(low_pass) if low_pass and low_pass.zero_phase else 0.0
    resolved = RESOLVED / low_pass.cutoff_hz if low_pass else np.inf
    h = max(min(step_for(*rig.values), resolved), (end + later) / (SAMPLES - 4))
    steps = min(SAMPLES - 1, int((end + later) / h) + 3)
    grid = Grid(h, steps, low_pass=low_pass, tool_mass=measurement.tool_mass_kg)
    v_e = np.array([t.contact_velocity for t in conditions])
    f_p = np.array([t.pretension for t in conditions])
    forces = forward((), rig.values, v_e, f_p, grid)
    time = np.arange(1, int(end * sample_rate)) / sample_rate
    force = np.stack(
        [at_times(f, time, grid.h, c) for f, c in zip(forces.sensed, forces.contact, strict=True)]
    )
    lost = first_loss(forces.contact)
    until = np.where(lost < forces.contact.shape[1], lost * grid.h, end)
    in_contact = (time[None] < until[:, None]) & (time[None] > ONSET / sample_rate)
    if low_pass:
        in_contact &= is_kept(time, 1 / sample_rate, low_pass)
    in_contact &= force < range_n  # a lower bound tells nothing of what is just large enough to be seen
    numbers = {condition: k for k, condition in enumerate(dict.fromkeys(t.condition for t in conditions))}
    return Observations(
        names=tuple(t.name for t in conditions),
        v_e=v_e,
        f_p=f_p,
        condition=np.array([numbers[t.condition] for t in conditions]),
        time=np.tile(time, (len(conditions), 1)),
        force=force,
        used=in_contact,
        peak_only=np.zeros(len(conditions), bool),
        interval=np.full(len(conditions), 1 / sample_rate),
        rel_std=(measurement.contact_velocity_rel_std, measurement.pretension_rel_std),
        noise=Noise(noise_std),
        prior=rig,
        low_pass=low_pass,
        tool_mass=measurement.tool_mass_kg,
    )
