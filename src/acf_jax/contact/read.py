"""Contact models from what a user has: a rig's four values, a diagnosis, a surrogate."""

from collections.abc import Mapping
from dataclasses import replace

import equinox as eqx
import numpy as np

from acf_jax.contact.model import ContactModel, Variant
from acf_jax.contact.peak import RIG, AbstractPeak, ClosedForm, Learned, Simulated, Trained
from acf_jax.dataset.tried import Range, Tried
from acf_jax.errors import InputError
from acf_jax.gap_model import GapModel, Which
from acf_jax.gap_model import Variant as Saved
from acf_jax.inference.parameters import LEAST_SHARE, parameters
from acf_jax.predict import tried_reach
from acf_jax.surrogate import CorrectedSurrogate, Surrogate

IMPACT = ("v_e", "f_p")
UNITS = ("kg", "N s/m", "N/m", "N/m")


def of_rig(
    rig: Mapping[str, float],
    relative_std: Mapping[str, float],
    surrogate: Surrogate | None = None,
    tried: Tried | None = None,
    source: str = "rig",
    stds: Mapping[str, float] | None = None,
) -> ContactModel:
    """The paper's model at given values, each with a relative standard deviation (zero where none is given).

    **Arguments:** `rig`: m in kg, d in N s/m, k_f and k_c in N/m. `relative_std`: standard deviation over value, of
    these and of v_e and f_p. `surrogate`: answers in place of the closed form. `tried`: which v_e and f_p measurements
    stand behind, where there are any. `stds`: standard deviations in the unit of the value, where no relative one is
    given.
    """
    theta = np.array([float(rig[name]) for name in RIG])
    std = np.array([float((stds or {}).get(name, 0.0)) for name in RIG])
    # a deviation of a value of zero is a share of nothing
    relative_std = {n: s / x for n, s, x in zip(RIG, std, theta, strict=True) if s and x} | dict(relative_std)
    covariance = np.diag(np.where(theta == 0, std, 0.0) ** 2)
    peak: AbstractPeak = ClosedForm() if surrogate is None else Learned(surrogate)
    names = (*RIG, *IMPACT)
    return ContactModel(
        names=names,
        units=(*UNITS, "m/s", "N"),
        main=Variant(peak, theta, covariance, LEAST_SHARE * theta, 1.0),
        others=(),
        relative=np.array([float(relative_std.get(name, 0.0)) for name in names]),
        form_error=0.0,
        tried=tried,
        source=source,
    )


def of_diagnosis(
    model: GapModel,
    relative_std: Mapping[str, float] | None = None,
    source: str = "diagnosis",
    which: Which | None = None,
) -> ContactModel:
    """The corrected model of a diagnosis, the explanations beside it, and the fit's covariance.

    Where it is known to be no better than the recalibrated model on held-out conditions, that one answers, with the
    same weight as the corrected one and what stands beside it together: their spread is uncertainty.

    `relative_std`: of v_e and f_p about their commanded values; where it is not given the trials', and a data set's
    default for files of earlier versions. `which`: one model alone, the corrected one with what stands beside it.
    """
    given = dict(zip(IMPACT, model.scatter, strict=True)) | dict(relative_std or {})
    which = which or model.preferred
    chosen: Saved = getattr(model, which)
    main = _variant(model, chosen)
    others = tuple(_variant(model, v) for v in model.alternatives if which == "corrected")
    if which == model.preferred == "recalibrated":
        others = tuple(_variant(model, v) for v in (model.corrected, *model.alternatives))
        main = replace(main, weight=sum(v.weight for v in others))
    effects = chosen.effects
    known = parameters(effects)[len(RIG) :]
    names = (*RIG, *(name for name, _ in known), *IMPACT)
    return ContactModel(
        names=names,
        units=(*UNITS, *(p.unit for _, p in known), "m/s", "N"),
        main=main,
        others=others,
        relative=np.array([float(given.get(name, 0.0)) for name in names]),
        form_error=model.form_error(which),
        tried=model.tried,
        source=source,
        verdict=model.verdict,
        better=model.better,
        missing=model.missing,
    )


def by_surrogate(model: ContactModel, surrogate: CorrectedSurrogate) -> ContactModel:
    """A diagnosis' model with a surrogate for its main explanation; what stands beside it is simulated all the same.

    **Raises:** `InputError` for a model or a surrogate that does not fit.
    """
    law, domain, source = model.main.peak, surrogate.domain, model.source
    if not isinstance(law, Simulated) or domain.names[:-1] != model.names or surrogate.which != "contact":
        raise InputError(f"{source}: the surrogate stands for another model than it carries; train it again")
    for name in domain.names:
        if (span := domain.span(name)) and (fault := possible_fault(model, name, span)):
            raise InputError(f"{source}: header: domain: {name} {fault.partition(';')[0]}; train it again")
    return eqx.tree_at(lambda m: m.main.peak, model, Trained(surrogate, law))


def learnt_range(model: ContactModel, name: str) -> Range | None:
    """Where a surrogate knows a quantity of the model; None for a model without one.

    The paper's surrogate knows d by the damping ratio, `zeta`.
    """
    law = model.main.peak
    if isinstance(law, Learned):
        return law.surrogate.box.span(name)
    return law.surrogate.domain.span(name) if isinstance(law, Trained) else None


def possible_fault(model: ContactModel, name: str, span: Range) -> str | None:
    """Why a parameter of an effect cannot lie anywhere in a range; None where it can, and for any other quantity."""
    law = model.main.peak.original()
    known = dict(parameters(law.effects)[len(RIG) :]) if isinstance(law, Simulated) else {}
    if name not in known or known[name].low <= span[0] <= span[1] <= known[name].high:
        return None
    return f"leaves what it can be, {known[name].low:g} to {known[name].high:g}; narrow it"


def zeta_span(model: ContactModel, spans: Mapping[str, Range]) -> Range:
    """Lowest and highest damping ratio zeta = d/(2 sqrt(m (k_F + k_C))) over ranges; what has none is as fitted."""
    m, d, k_f, k_c = (spans.get(name, (x, x)) for name, x in zip(RIG, model.main.theta, strict=True))
    return (
        float(d[0] / (2 * np.sqrt(m[1] * (k_f[1] + k_c[1])))),
        float(d[1] / (2 * np.sqrt(m[0] * (k_f[0] + k_c[0])))),
    )


def _variant(model: GapModel, saved: Saved) -> Variant:
    theta = np.array(saved.theta)
    lowest = [p.low for _, p in parameters(saved.effects)[len(RIG) :]]
    return Variant(
        Simulated(saved.effects, model.step_s, tried_reach(model, saved)),
        theta,
        np.array(saved.covariance),
        np.r_[LEAST_SHARE * theta[: len(RIG)], lowest],
        max(saved.probability, 1e-9),
    )
