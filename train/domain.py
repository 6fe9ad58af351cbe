"""The box that a surrogate of a corrected model learns: given ranges, and what the fit leaves open."""

import numpy as np

from acf_jax.contact.model import ContactModel
from acf_jax.contact.peak import RIG, Simulated
from acf_jax.contact.read import possible_fault
from acf_jax.errors import InputError
from acf_jax.inference.parameters import parameters
from acf_jax.surrogate.box import sign_fault
from acf_jax.surrogate.corrected import Domain
from train.config import CorrectedConfig

MOBILITY = ("mobility", "1/kg")


def make_domain(config: CorrectedConfig, model: ContactModel, law: Simulated) -> Domain:
    """The range of every quantity of the model: the given one, or else

    - of contact velocity and pretension, what the trials covered;
    - of a fitted parameter, `labels.deviations` standard deviations to either side, within its bounds;
    - of a body's mobility, zero: a wall.

    **Raises:** `InputError` with every range that cannot be.
    """
    names, units = (*model.names, MOBILITY[0]), (*model.units, MOBILITY[1])
    theta, std = model.main.theta, np.sqrt(np.diag(model.main.covariance))
    half = config.labels.deviations * std
    assert model.tried is not None  # every diagnosis names its trials
    (v_low, v_high), (f_low, f_high) = model.tried.v_e, model.tried.f_p
    low = [*np.maximum(theta - half, model.main.low), v_low, f_low, 0.0]
    highest = [np.inf] * len(RIG) + [p.high for _, p in parameters(law.effects)[len(RIG) :]]
    high = [*np.minimum(theta + half, highest), v_high, f_high, 0.0]
    logarithmic = [False] * len(names)
    known = dict(zip(names, units, strict=True))
    faults = [
        f"ranges.{name}: is no quantity of the model; known are {', '.join(names)}"
        for name in config.ranges
        if name not in known
    ]
    for name, given in config.ranges.items():
        if name not in known:
            continue
        i = names.index(name)
        if given.unit != known[name]:
            faults.append(
                f"ranges.{name}: unit must be {known[name]}, but is {given.unit}; convert the range"
            )
        if fault := sign_fault(name, given.low):
            faults.append(f"ranges.{name}: {fault}")
        if i < len(theta) and not given.low <= theta[i] <= given.high:
            faults.append(
                f"ranges.{name}: {given.low:g} to {given.high:g} {given.unit} leaves out the fitted {theta[i]:g}; "
                "widen it"
            )
        if fault := possible_fault(model, name, (given.low, given.high)):
            faults.append(f"ranges.{name}: {given.low:g} to {given.high:g} {given.unit} {fault}")
        low[i], high[i], logarithmic[i] = given.low, given.high, given.scale == "log"
    if faults:
        raise InputError(faults)
    return Domain(names, units, tuple(map(float, low)), tuple(map(float, high)), tuple(logarithmic))
