"""The verdict of a diagnosis, as the contract defines its five words."""

from collections.abc import Sequence

from acf_jax.diagnosis.identifiability import DETECTABLE, Detectability, Pair
from acf_jax.evidence.posterior import UNKNOWN, Scored
from acf_jax.gap_model import Lack
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import Explanation

# explanations of the credible set, the first and those that lack a law of it: these trials have not answered
TOO_MANY = 6


def judge(
    scored: Sequence[Scored],
    credible: Sequence[Explanation],
    pairs: Sequence[Pair],
    detectability: Sequence[Detectability],
    observations: Observations,
    harmless: bool,
) -> str:
    """The verdict; `harmless` says that no explanation that stands changes a peak beyond its uncertainty."""
    first = scored[0].explanation
    if shows_nothing(first, detectability, observations) is not None:
        return "insufficient_data"
    if first == () and harmless:
        return "no_gap"
    if 1 + sum(not first or not set(first) <= set(e) for e in credible if e != first) >= TOO_MANY:
        return "insufficient_data"
    if first == ():
        return "ambiguous"
    if first == UNKNOWN:
        return "unknown"
    same = {first} | {p.effects[1] for p in pairs}
    return "identified" if set(credible) <= same else "ambiguous"


def shows_nothing(
    first: Explanation, detectability: Sequence[Detectability], observations: Observations
) -> Lack | None:
    """What the trials lack to show a cause at all; None where they would have shown most of them."""
    if observations.peak_only.all():
        return "traces"
    hidden = sum(d.distance_at_typical < DETECTABLE for d in detectability)
    return "detection" if first == () and hidden > len(detectability) / 2 else None
