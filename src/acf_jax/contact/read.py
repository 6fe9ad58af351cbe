"""Contact models from what a user has: a rig's four values, a diagnosis, a surrogate."""

from collections.abc import Mapping

import numpy as np

from acf_jax.contact.model import ContactModel, Range, Variant
from acf_jax.contact.peak import RIG, AbstractPeak, ClosedForm, Learned, Simulated
from acf_jax.dataset import Measurement
from acf_jax.diagnosis.model_file import GapModel
from acf_jax.diagnosis.model_file import Variant as Saved
from acf_jax.diagnosis.space import LEAST_SHARE, parameters
from acf_jax.surrogate import Surrogate

IMPACT = ("v_e", "f_p")
UNITS = ("kg", "N s/m", "N/m", "N/m")


def of_rig(
    rig: Mapping[str, float],
    relative_std: Mapping[str, float],
    surrogate: Surrogate | None = None,
    tried: tuple[Range, Range] | None = None,
    source: str = "rig",
) -> ContactModel:
    """The paper's model at given values, each with a relative standard deviation (zero where none is given).

    `tried`: lowest and highest v_e and f_p that measurements stand behind, where there are any.
    """
    theta = np.array([float(rig[name]) for name in RIG])
    peak: AbstractPeak = ClosedForm() if surrogate is None else Learned(surrogate)
    names = (*RIG, *IMPACT)
    return ContactModel(
        names=names,
        units=(*UNITS, "m/s", "N"),
        main=Variant(peak, theta, np.zeros((4, 4)), LEAST_SHARE * theta, 1.0),
        others=(),
        relative=np.array([float(relative_std.get(name, 0.0)) for name in names]),
        form_error=0.0,
        tried=tried,
        source=source,
    )


def of_diagnosis(
    model: GapModel, relative_std: Mapping[str, float] | None = None, source: str = "diagnosis"
) -> ContactModel:
    """The corrected model of a diagnosis, the explanations beside it, and the fit's covariance.

    `relative_std`: of v_e and f_p about their commanded values; a data set's default where it is not given.
    """
    usual = Measurement()
    given = {"v_e": usual.contact_velocity_rel_std, "f_p": usual.pretension_rel_std} | dict(
        relative_std or {}
    )
    effects = model.corrected.effects
    own = parameters(effects)[len(RIG) :]
    names = (*RIG, *(name for name, _ in own), *IMPACT)
    return ContactModel(
        names=names,
        units=(*UNITS, *(p.unit for _, p in own), "m/s", "N"),
        main=_variant(model, model.corrected),
        others=tuple(_variant(model, v) for v in model.alternatives),
        relative=np.array([float(given.get(name, 0.0)) for name in names]),
        form_error=model.peak_form_error,
        tried=(model.v_range, model.f_p_range),
        source=source,
    )


def _variant(model: GapModel, saved: Saved) -> Variant:
    theta = np.array(saved.theta)
    own = [p.low for _, p in parameters(saved.effects)[len(RIG) :]]
    return Variant(
        Simulated(saved.effects, model.step_s),
        theta,
        np.array(saved.covariance),
        np.r_[LEAST_SHARE * theta[: len(RIG)], own],
        max(saved.probability, 1e-9),
    )
