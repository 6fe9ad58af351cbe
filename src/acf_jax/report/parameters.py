"""The corrected model's parameters, with intervals and what they mean."""

import numpy as np

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.effects import Parameter
from acf_jax.inference.fit import Fit
from acf_jax.inference.parameters import RIG, every_effect, is_free_curve, parameters
from acf_jax.report.markup import Html, element, formula, join, table
from acf_jax.report.words import headed, si

WIDE = 1.959964  # standard deviations to each side of a 95 % interval
FAR = 2.5  # prior standard deviations from the prior at which a reader should look
LITTLE = 0.2  # share by which the data narrowed the prior below which they said little
RIG_MEANS = {
    "moving_mass_kg": "moving mass m; with k_C it sets how hard an impact is, √(k_C m) v",
    "damping_n_s_per_m": "damping d of the flange's guide",
    "actuator_stiffness_n_per_m": "stiffness k_F of the actuator behind the mass",
    "contact_stiffness_n_per_m": "stiffness k_C of the contact, tool and workpiece",
}


def parameter_table(diagnosis: Diagnosis) -> Html:
    """Every parameter of the corrected model."""
    d = diagnosis
    fitted = d.corrected
    wide_u = np.sqrt((fitted.root**2).sum(1))  # as in diagnosis.json
    std_u = wide_u / np.sqrt(fitted.misfit)
    std = np.sqrt(np.diag(fitted.covariance))
    rows = [
        (
            _name(name, p),
            _fitted(fitted, k, p),
            _interval(fitted, k, p, wide_u[k], std[k]),
            _prior(d, k, p),
            join([formula(headed(RIG_MEANS.get(p.name, p.meaning))), *_flags(fitted, k, std_u[k])]),
        )
        for k, (name, p) in enumerate(parameters(fitted.explanation))
    ]
    head = ("Parameter", "Value", "95 % interval", "Known before", "What it means")
    return join([_lead(fitted), table("Corrected model", head, rows), _recalibrated(d)])


def _lead(fitted: Fit) -> Html:
    if not fitted.explanation:
        return element("p", "The corrected model is the paper's model with its own parameters refitted.")
    said = [
        element(
            "p",
            element("strong", f"{every_effect()[name].title}: "),
            formula(_first_sentence(every_effect()[name])),
        )
        for name in fitted.explanation
    ]
    if is_free_curve(fitted.explanation):
        said.append(
            element("p", "Its coefficients describe a shape, not a mechanism; look at the curve above.")
        )
    return join(said)


def _first_sentence(cls: type) -> str:
    return (cls.__doc__ or "").strip().splitlines()[0]


def _name(name: str, p: Parameter) -> Html:
    return element(
        "span", headed(p.name.rsplit("_" + _suffix(p), 1)[0].replace("_", " ")), " ", element("code", name)
    )


def _suffix(p: Parameter) -> str:
    """The unit as a name carries it: `n_s_per_m` for N s/m."""
    return p.unit.lower().replace("/", "_per_").replace(" ", "_").replace("^", "")


def _fitted(fitted: Fit, k: int, p: Parameter) -> str:
    """The value, without the rounding error that a bound at zero leaves."""
    value = float(fitted.theta[k])
    return si(0.0 if abs(value) < 1e-9 * fitted.coordinates.width[k] else value, unit=p.unit)


def _interval(fitted: Fit, k: int, p: Parameter, std_u: float, std: float) -> str:
    """Symmetric for a strength, in the logarithm for a shape, cut off at the bounds."""
    at = fitted.coordinates
    if at.logarithmic[k]:
        u = fitted.u.copy()
        ends = []
        for sign in (-1, 1):
            u[k] = np.clip(fitted.u[k] + sign * WIDE * std_u, at.low[k], at.high[k])
            ends.append(float(at.value(u)[k]))
    else:
        ends = [fitted.theta[k] - WIDE * std, fitted.theta[k] + WIDE * std]
    low, high = max(ends[0], p.low), min(ends[1], p.high)
    return f"{si(low)} to {si(high)}"


def _prior(d: Diagnosis, k: int, p: Parameter) -> str:
    if k < len(RIG):
        return f"{si(d.dataset.rig.values[k])} ± {si(d.dataset.rig.stds[k], 2)}"
    if p.within:
        return f"at most {headed(p.within)}"
    return f"order of {si(p.scale, 2)}" if p.shape else f"0 ± {si(d.corrected.coordinates.width[k], 2)}"


def _flags(fitted: Fit, k: int, std_u: float) -> list[Html]:
    """What a reader has to know before using the value."""
    flags = []
    if fitted.at_bound[k]:
        flags.append("at its bound: not determined by these trials")
    elif std_u > 1 - LITTLE:
        flags.append("these trials say little about it: what was known before stands")
    if abs(fitted.u[k]) > FAR and k < len(RIG):
        flags.append(f"{abs(fitted.u[k]):.1f} standard deviations from what was known before")
    return [element("div", headed(flag), class_="open") for flag in flags]


def _recalibrated(d: Diagnosis) -> Html:
    values = [f"{p.name} = {_fitted(d.fits[0], k, p)}" for k, p in enumerate(RIG)]
    text = "Refitting the paper's model alone gives " + ", ".join(values) + "."
    return element("p", text, class_="muted") if d.corrected is not d.fits[0] else Html("")
