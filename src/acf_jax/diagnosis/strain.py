"""A rig that refitting has strained: parameters far from what is known of them hide a cause."""

from collections.abc import Sequence
from typing import NamedTuple

from acf_jax.dataset import RigPrior
from acf_jax.effects import Parameter
from acf_jax.inference.fit import Fit
from acf_jax.inference.parameters import RIG

FAR = 3.0  # stated standard deviations: one true parameter in 370 lies as far


class Strain(NamedTuple):
    """One parameter of the rig that a fit has moved too far."""

    parameter: Parameter
    fitted: float  # SI units
    stated: float
    deviations: float  # between them, in stated standard deviations


def strains(fitted: Fit, prior: RigPrior) -> tuple[Strain, ...]:
    """The parameters farther than `FAR` from what the data set states, the farthest first."""
    moved = (fitted.theta[: len(RIG)] - prior.values) / prior.stds
    rows = zip(RIG, fitted.theta[: len(RIG)], prior.values, moved, strict=True)
    found = [Strain(p, float(x), float(x_0), float(d)) for p, x, x_0, d in rows if abs(d) > FAR]
    return tuple(sorted(found, key=lambda s: -abs(s.deviations)))


def statement(found: Sequence[Strain]) -> str:
    """What refitting alone has done, in words; empty where no parameter is strained."""
    return f"refitting hides a part of the gap in the rig: it makes {_listed(found)}" if found else ""


def doubt(found: Sequence[Strain], name: str) -> str:
    """What speaks against the laws that are named, in words; empty where no parameter is strained."""
    if not found:
        return ""
    again = "measure that again; if it is as stated, another cause acts besides"
    return f"{name} fits only with {_listed(found)}: {again}"


def _listed(found: Sequence[Strain]) -> str:
    return "; ".join(
        f"the {s.parameter.meaning} {_figures(s.fitted)} {s.parameter.unit}, {abs(s.deviations):.0f} standard"
        f" deviations from the stated {_figures(s.stated)}"
        for s in found
    )


def _figures(value: float) -> str:
    return f"{float(f'{value:.3g}'):,.9g}"
