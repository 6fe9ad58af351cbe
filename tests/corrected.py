"""A corrected model as a diagnosis would leave it, without the diagnosis."""

import numpy as np

from acf_jax.gap_model import SCHEMA, GapModel, Variant
from acf_jax.inference.parameters import parameters

RIG = (1.9, 60.0, 800.0, 8e4)
RIG_STD = (0.02, 6.0, 100.0, 1e3)


def variant(effects: tuple[str, ...], values: tuple[float, ...], probability: float) -> Variant:
    """An explanation with 3 % uncertainty of its effects' parameters."""
    std = np.array([*RIG_STD, *(0.03 * x for x in values)])
    return Variant(
        effects=effects,
        probability=probability,
        names=tuple(name for name, _ in parameters(effects)),
        theta=(*RIG, *values),
        covariance=tuple(map(tuple, np.diag(std**2).tolist())),
    )


def gap_model(
    effects: tuple[str, ...] = ("gravity",),
    values: tuple[float, ...] = (-8.0,),
    alternatives: tuple[Variant, ...] = (),
    form_error: float = 0.0,
) -> GapModel:
    """A model whose corrected variant has `effects` with the values `values`."""
    plain = variant((), (), 0.0)
    return GapModel(
        schema=SCHEMA,
        description="made for a test",
        nominal=plain,
        recalibrated=plain,
        corrected=variant(effects, values, 0.9),
        alternatives=alternatives,
        peak_form_error=form_error,
        step_s=1.25e-4,
        sample_rate_hz=8000.0,
        v_range=(0.05, 0.35),
        f_p_range=(50.0, 90.0),
    )
