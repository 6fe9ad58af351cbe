"""What to measure next, and what these trials could have seen at all."""

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.identifiability import DETECTABLE
from acf_jax.inference.parameters import component_of, every_effect
from acf_jax.report.markup import Html, details, element, formula, join, table
from acf_jax.report.words import condition, listed, name_of, percent, si


def next_experiment(diagnosis: Diagnosis) -> Html:
    """The trial that best separates what is still standing."""
    d = diagnosis
    e = d.next_experiment
    if e is not None:
        first, second = (name_of(x) for x in e.separates)
        return join(
            [
                element(
                    "p",
                    "Measure ",
                    element("strong", f"{e.repeats} trials at {condition(e.v_e, e.f_p)}"),
                    f": of what was considered, this separates {first} from {second} best. The probability of choosing"
                    f" the wrong one of the two goes from {percent(e.error_before)} to {percent(e.error_after)}.",
                ),
                element("p", _outside(d, e.v_e, e.f_p), class_="muted"),
            ]
        )
    if d.observations.peak_only.all():
        return element(
            "p",
            formula(
                "Record force traces: peaks alone fix little more than √(k_C m), so most effects look alike in them."
                " Trials at the same conditions, sampled at 5 kHz or faster and with 20 samples before contact, would"
                " tell most."
            ),
        )
    if d.verdict == "no_gap":
        return element("p", "None is needed: nothing but the paper's model is standing.")
    return element(
        "p", "None is proposed: no second explanation stands that a trial could separate from the first."
    )


def _outside(d: Diagnosis, v: float, f: float) -> str:
    o = d.observations
    beyond = [
        what
        for what, value, tried in (("velocity", v, o.v_e), ("pretension", f, o.f_p))
        if value > 1.001 * tried.max() or value < 0.999 * tried.min()
    ]
    return (
        f"This is in {listed(beyond)} beyond the tried range: check that the rig bears it." if beyond else ""
    )


def detectable(diagnosis: Diagnosis) -> Html:
    """For each effect, the smallest size these trials could have detected, and what it would be confused with."""
    d = diagnosis
    found = sorted(d.detectability, key=lambda x: -x.distance_at_typical)
    clear = [x for x in found if x.distance_at_typical >= DETECTABLE]
    missed = [every_effect()[x.effect].title.lower() for x in found if x.distance_at_typical < DETECTABLE]
    says = f"At a typical size, these trials could detect {len(clear)} of {len(found)} effects"
    says += f"; too weak for them: {listed(missed)}." if missed else "."
    confused = [x for x in clear if x.confused_with]
    if confused:
        says += f" {len(confused)} of the detectable ones could be taken for another effect."
    rows = [
        (
            every_effect()[x.effect].title,
            component_of(x.effect),
            _size(x.smallest, x.unit, x.effect),
            _strength(x.distance_at_typical),
            listed([every_effect()[name].title.lower() for name in x.confused_with]) or "none",
            percent(x.absorbed),
        )
        for x in found
    ]
    head = (
        "Effect", "Component", "Smallest detectable", "At a typical size", "Could be taken for", "Imitated by the rig",
    )  # fmt: skip
    note = element(
        "p",
        formula(
            "Computed from the design of the trials and their noise, whatever the data say. Smallest detectable: three"
            " standard deviations, within the effect's range; where its first strength alone changes nothing, with its"
            " other strengths in proportion. Imitated by the rig: the share of the effect's signature that m, d, k_F"
            " and k_C could produce as well, within what is known of them; refitting hides that much."
        ),
        class_="muted",
    )
    body = details("Each effect", table("Most visible effect first", head, rows), note)
    return join([element("p", says), body])


def _size(smallest: float | None, unit: str, effect: str) -> Html | str:
    meaning = every_effect()[effect].parameters()[0].meaning
    if smallest is None:
        return "none"
    return formula(f"{si(smallest, 2, unit)} ({meaning})")


def _strength(distance: float) -> str:
    word = "clear" if distance >= 3 * DETECTABLE else "visible" if distance >= DETECTABLE else "hidden"
    return f"{word}, {si(distance, 2)} σ"
