"""The box that a surrogate of a corrected model learns: given ranges, and what the fit leaves open."""

from collections.abc import Collection

import numpy as np

from acf_jax.contact.model import ContactModel
from acf_jax.contact.peak import RIG, Simulated
from acf_jax.contact.read import IMPACT, possible_fault
from acf_jax.errors import InputError
from acf_jax.inference.parameters import parameters
from acf_jax.surrogate.box import sign_fault
from acf_jax.surrogate.corrected import Domain
from acf_jax.training.config import CorrectedConfig

MOBILITY = ("mobility", "1/kg")


def words(domain: Domain, given: Collection[str], deviations: float) -> str:
    """What a surrogate learns over, a line each quantity; `given`: those whose range was given."""
    lines = ["it learns over"]
    rows = zip(domain.names, domain.units, domain.low, domain.high, strict=True)
    for name, unit, low, high in rows:
        if name in given:
            why = "given"
        elif name in IMPACT:
            why = "tried"
        else:
            why = (
                "a wall" if name == MOBILITY[0] else f"fitted, {deviations:g} standard deviations either way"
            )
        span = f"{low:.6g} to {high:.6g}" if low < high else f"{low:.6g}"
        lines.append(f"  {name:28} {span + ('' if unit == '1' else f' {unit}'):26} {why}")
    return "\n".join(lines)


def to_blame(domain: Domain, unit: np.ndarray, is_right: np.ndarray) -> tuple[str, str] | None:
    """The range towards one end of which samples are wrong most often, and the remedy; None where no range tells.

    **Arguments:** `unit`: samples in the unit cube (n, inputs). `is_right`: of each (n,).
    """
    pull = (unit - 0.5).T @ (is_right - is_right.mean())
    worst = int(np.argmax(np.abs(pull)))
    if not pull[worst]:
        return None
    i = domain.free[worst]
    span = f"ranges.{domain.names[i]}: {domain.low[i]:g} to {domain.high[i]:g} {domain.units[i]}"
    return span, "lower its high end" if pull[worst] < 0 else "raise its low end"


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
