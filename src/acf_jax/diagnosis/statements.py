"""What a diagnosis says beside its verdict: warnings, each with what it means or what to do."""

from acf_jax.diagnosis.claims import Comparison
from acf_jax.diagnosis.heldout import FORM_UNKNOWN
from acf_jax.evidence.posterior import CREDIBLE, UNKNOWN, Posterior, of_laws
from acf_jax.gap_model import FORM_MOST
from acf_jax.inference.discrepancy import FASTEST, FORMS
from acf_jax.inference.fit import Fit
from acf_jax.inference.observations import Observations
from acf_jax.inference.parameters import Explanation, is_free_curve, label, parameters
from acf_jax.inference.ring import Ring


def of_ring(ring: Ring) -> str:
    """What trials do not share."""
    return (
        f"each trial rings at {ring.frequency:.3g} Hz with a size, about {ring.size:.2g} N, and a phase of its own:"
        " no model predicts it, it counts as noise"
    )


def of_scatter(before: float, o: Observations) -> list[str]:
    """What is said where repeats differ by more than is known to scatter; `before`: N, noise of the approach."""
    within = o.noise.std
    if o.noise.source != "repeats" or within <= before:  # else it is what a simulation can tell
        return []
    rings = [ring.frequency for ring in o.rings if ring.frequency > 2 * FASTEST * o.measures.frequency]
    advice = "find out what differs from trial to trial"
    if rings and not o.low_pass:
        advice += f", or diagnose with --low-pass {min(rings) / 2:.0f}: half the lowest frequency that rings"
    return [
        f"repeats of a condition differ by {within:.3g} N a sample, {within / before:.0f} times the noise before"
        " contact, beyond rings, triggers, velocities and pretensions: it counts as noise, and hides every smaller"
        f" cause; {advice}"
    ]


def of_discrepancy(told: Posterior) -> list[str]:
    """What is said where the most probable explanation misses by more than forms that are a little wrong."""
    size = told.missed
    if size <= FORMS:
        return []
    return [
        f"the most probable explanation misses the traces by about {size:.0%} of the force, more than a law whose form"
        f" is a little wrong ({FORMS:.0%}): a cause is missing that none of the laws and free curves describes"
    ]


def of_minor(corrected: Fit, told: Posterior) -> list[str]:
    """Which laws of the corrected model are too small to be named, and which others may be there in their place."""
    named = told.scored[0].explanation
    others = tuple(name for name in corrected.explanation if name not in named)
    if not others or named == UNKNOWN or is_free_curve(corrected.explanation):
        return []
    behind = told.behind[named]
    share = of_laws(({*explanation} - {*named} for explanation in behind), behind.values())
    likely = sorted((name for name, p in share.items() if p >= 1 - CREDIBLE), key=lambda name: -share[name])
    odds = ", ".join(f"{label((name,)).lower()} {100 * share[name]:.0f} %" for name in likely)
    return [
        f"the corrected model also has {label(others).lower()}: too small to be told from other laws, so not"
        f" named{f'; probability beside the laws named: {odds}' if odds else ''}"
    ]


def of_model(comparison: Comparison | None, form: float) -> list[str]:
    """What the figures of held-out conditions say; `form`: relative standard deviation of the peak there."""
    found = [comparison.statement] if comparison and not comparison.is_better else []
    if form == FORM_MOST:
        found.append(f"peaks on held-out conditions are missed by {FORM_MOST:g} times their size and more")
    if form == FORM_UNKNOWN:
        found.append("no trial tells a peak: how far predicted peaks are off is unknown, and taken as 100 %")
    return found


def of_denial(named: Explanation) -> list[str]:
    """What is said where the laws named do not predict held-out conditions better than none."""
    return [
        f"what the fit did not see speaks against {label(named).lower()}: it is given no more than even odds, since"
        " another cause is as likely"
    ]


def of_bounds(corrected: Fit) -> list[str]:
    """Parameters that the trials do not tell."""
    names = [name for name, _ in parameters(corrected.explanation)]
    return [
        f"{name} ended at its bound ({value:.4g}): its value is not determined by these trials"
        for name, value, bound in zip(names, corrected.theta, corrected.at_bound, strict=False)
        if bound
    ]
