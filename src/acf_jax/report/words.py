"""A diagnosis in words."""

from collections.abc import Sequence

import numpy as np

from acf_jax.dataset.trust import Trust
from acf_jax.diagnosis.contributions import BACKGROUND, SCATTER, Contribution
from acf_jax.diagnosis.damage import statements
from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.results import gap_model
from acf_jax.diagnosis.statements import of_discrepancy
from acf_jax.diagnosis.strain import statement, strains
from acf_jax.evidence.posterior import UNKNOWN, Scored
from acf_jax.inference.parameters import Explanation, component_of, every_effect

MODELS = {
    "nominal": "the paper's model with the rig's nominal parameters",
    "recalibrated": "the paper's model with its own parameters refitted",
    "corrected": "the model with what explains the gap",
}
THIN_SPACE, FIXED_SPACE = "\u202f", "\u00a0"  # neither breaks a line
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
VERDICTS = {
    "no_gap": ("No gap", "good"),
    "identified": ("Identified", "good"),
    "ambiguous": ("Ambiguous", "open"),
    "unknown": ("Unknown cause", "open"),
    "insufficient_data": ("Insufficient data", "bad"),
}
# words as in Mastrandrea et al., 'Guidance note on consistent treatment of uncertainties' (IPCC, 2010)
LIKELIHOOD = (
    (0.99, "virtually certain"),
    (0.90, "very likely"),
    (0.66, "likely"),
    (0.33, "about as likely as not"),
    (0.10, "unlikely"),
    (0.01, "very unlikely"),
    (0.00, "exceptionally unlikely"),
)
LIKELY = 0.66  # as above: what is less so is said to be open


def likelihood(probability: float) -> str:
    """A probability in words."""
    return next(word for least, word in LIKELIHOOD if probability >= least)


def percent(share: float | None, digits: int = 0, signed: bool = False) -> str:
    """A share in percent; close to 0 and 100 % it says no more than that."""
    if share is None:
        return "–"
    least = 10.0**-digits
    value = 100 * share
    if signed:
        return f"{value:+.{digits}f} %".replace("-", "−")
    if 0 <= value < least:
        return f"< {least:g} %"
    if 100 - least < value <= 100:
        return f"> {100 - least:g} %"
    return f"{value:.{digits}f} %".replace("-", "−")


def name_of(explanation: Explanation) -> str:
    """An explanation as a person says it."""
    if explanation == UNKNOWN:
        return "a cause outside the library"
    if not explanation:
        return "nothing unmodelled"
    titles = [every_effect()[name].title for name in explanation]
    return " and ".join(title[:1].lower() + title[1:] for title in titles)


def headed(phrase: str) -> str:
    """The phrase with a capital letter, unless it begins with a symbol or a name such as k_C."""
    return phrase if "_" in phrase.split(" ")[0] else phrase[:1].upper() + phrase[1:]


def listed(items: Sequence[str], last: str = "and") -> str:
    """`a, b and c`."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} {last} {items[-1]}" if items else ""


def condition(v_e: float, f_p: float) -> str:
    """A condition of a trial."""
    return f"{v_e:.3g} m/s, {f_p:.3g} N"


def has_held_out(diagnosis: Diagnosis) -> bool:
    """Whether there is a condition that a fit to the others does not see."""
    return len(np.unique(diagnosis.observations.condition)) > 1


def si(value: float, digits: int = 4, unit: str = "1") -> str:
    """A number as an engineer writes it, with its unit on the same line."""
    behind = "" if unit in ("", "1") else f"{FIXED_SPACE}{unit.replace(' ', FIXED_SPACE)}"
    rounded = float(f"{value:.{digits}g}")
    if rounded == 0 or 1e-4 <= abs(rounded) < 1e7:
        shown = f"{rounded:,}".removesuffix(".0").replace(",", THIN_SPACE)
    else:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        shown = f"{mantissa}·10{str(int(exponent)).translate(RAISED)}"
    return shown.replace("-", "−") + behind


def sentence(diagnosis: Diagnosis) -> str:
    """The verdict in one sentence, and how far the gap shrinks in a second."""
    return f"{verdict(diagnosis)} {shrunk(diagnosis)}".strip()


def verdict(diagnosis: Diagnosis) -> str:
    """The verdict in one sentence."""
    d = diagnosis
    standing = [s for s in d.scored if s.explanation in d.credible]
    match d.verdict:
        case "no_gap":
            return "No gap: parameter error and noise explain all that these trials show."
        case "identified":
            places = listed(list(dict.fromkeys(_at(s.explanation) for s in standing)), "or")
            alike = ", which these trials cannot tell apart" if len(standing) > 1 else ""
            return f"Identified: {_named(standing)}{alike}, {places}."
        case "ambiguous":
            return f"Ambiguous: these trials leave {len(d.credible)} explanations standing: {_named(standing[:3])}."
        case "unknown":
            gap = f"no effect of the library explains the gap ({percent(d.scored[0].probability)})"
            return f"Unknown: {gap}; {_acting(d.component)}."
        case _:
            return "Insufficient data: these trials could not have told what causes the gap."


def _acting(component: dict[str, float]) -> str:
    """Where an unknown cause acts, as far as that is known."""
    first, second = sorted(component, key=lambda c: -component[c])[:2]
    if component[first] > LIKELY:
        return f"it acts at the {first}"
    shown = [f"the {name} ({percent(component[name])})" for name in (first, second)]
    return f"where it acts is open, {listed(shown, 'or')} before others"


def _at(explanation: Explanation) -> str:
    """At which components an explanation acts."""
    return f"at the {listed(list(dict.fromkeys(component_of(name) for name in explanation)))}"


def _named(standing: Sequence[Scored]) -> str:
    return listed([f"{name_of(s.explanation)} ({percent(s.probability)})" for s in standing], "or")


def of_removed(low: float, high: float) -> str:
    """The 95 % interval of the share that is removed; by how much an error may grow says no more."""
    if low < 0:
        return f"95 % interval up to {percent(high)}; it may also grow"
    return f"95 % interval {percent(low)} to {percent(high)}"


def shrunk(diagnosis: Diagnosis) -> str:
    """How much of the gap the correction removes, of the force if there are traces, else of the peak."""
    d = diagnosis
    if d.comparison and not d.comparison.is_better:
        return f"{headed(d.comparison.statement)}."
    cause = "the most probable one" if d.verdict == "ambiguous" else "it"
    for shrinkage, what in ((d.shrinkage_force, "force"), (d.shrinkage_peak, "peak")):
        if shrinkage is not None and d.verdict in ("identified", "ambiguous", "unknown"):
            return (
                f"Correcting for {cause} removes {percent(shrinkage.value)} of the {what} error on conditions that the"
                f" fit did not see ({of_removed(*shrinkage.ci95)})."
            )
    return ""


def part_of(contribution: Contribution) -> str:
    """What of the gap a contribution is, in words."""
    if contribution.name == SCATTER:
        return "scatter between trials"
    if contribution.name == BACKGROUND:
        where = contribution.component or {}
        place = max(where, key=lambda name: where[name]) if where else ""
        return f"unexplained, at the {place}" if where and where[place] > LIKELY else "unexplained"
    return name_of((contribution.name,))


def made_of(diagnosis: Diagnosis) -> str:
    """What the recalibrated model's gap is made of, in a sentence; empty where there is none."""
    d = diagnosis
    if not d.contributions or d.gap["recalibrated"].force_rms_n is None:
        return ""
    parts = ", ".join(f"{part_of(c)} {percent(c.share)}" for c in d.contributions)
    nominal, left = d.gap["nominal"].force_rms_n, d.gap["recalibrated"].force_rms_n
    hidden = statement(strains(d.fits[0], d.observations.prior))
    return (
        f"The nominal model misses by {nominal:.3g} N RMS, refitted by {left:.3g} N: {parts}."
        f"{' ' + headed(hidden) + '.' if hidden else ''}"
    )


def advice(diagnosis: Diagnosis) -> str:
    """What to do about the most probable cause on the machine; empty where no law is named."""
    d = diagnosis
    named = d.scored[0].explanation
    if d.verdict not in ("identified", "ambiguous") or not named or named == UNKNOWN:
        return ""
    first = "On the machine: " if len(d.credible) == 1 else "On the machine, if it is the first of these: "
    return first + "; ".join(f"{every_effect()[name].remedy} ({name_of((name,))})" for name in named) + "."


def next_step(diagnosis: Diagnosis) -> str:
    """What to do next where the verdict leaves something open, or nothing to correct; empty where a cause is found."""
    d, e = diagnosis, diagnosis.next_experiment
    if d.verdict == "insufficient_data":
        return f"Next: {gap_model(d).missing}."
    if d.verdict == "no_gap":
        return "Next: nothing to correct; go on with `speed` or `check`."
    if d.verdict != "identified" and e is not None:
        apart = " from ".join(name_of(x) for x in e.separates)
        return (
            f"Next: measure {e.repeats} trials at {condition(e.v_e, e.f_p)}, and diagnose them with the others: that"
            f" separates {apart} best."
        )
    if d.verdict == "unknown":
        return f"Next: look at the {max(d.component, key=lambda c: d.component[c])} for what no effect describes."
    return ""


def told(diagnosis: Diagnosis) -> str:
    """What a terminal tells: whether to trust the data, the verdict, what the gap is made of, what to do about it."""
    notes = [f"note: {line}" for line in (*doubts(diagnosis), *of_discrepancy(diagnosis.told))]
    lines = [trust(diagnosis).headline, *notes]
    lines += [sentence(diagnosis), made_of(diagnosis), advice(diagnosis), next_step(diagnosis)]
    return "\n".join(filter(None, lines))


def trust(diagnosis: Diagnosis) -> Trust:
    """Whether the trials that were compared can be trusted."""
    return diagnosis.quality.trust(diagnosis.excluded)


def doubts(diagnosis: Diagnosis) -> list[str]:
    """What of the data should make a reader doubt the verdict, a line each."""
    d = diagnosis
    return [*trust(d).lines, *statements(d.quality, d.observations.names, d.highest)]
