"""Which effects explain the gap, how probable each is, and which cannot be told apart."""

from typing import Any

import numpy as np

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.diagnosis.identifiability import BAYES_ERROR
from acf_jax.evidence.posterior import UNKNOWN
from acf_jax.inference.fit import Fit
from acf_jax.inference.parameters import parameters
from acf_jax.report.markup import Html, bullets, details, element, formula, join, table
from acf_jax.report.plot import Variant, axis, bars, plot
from acf_jax.report.words import headed, likelihood, listed, name_of, percent, si

BARS = 6  # explanations that the figure shows
WIDTH = 22  # characters of a line of a bar's label


def probabilities(content: dict[str, Any]) -> Html:
    """Probability of each explanation."""
    explanations = [(tuple(e["effects"]), e["probability"]) for e in content["explanations"]]
    shown = explanations[:BARS] + [e for e in explanations[BARS:] if e[0] in ((), UNKNOWN)]
    shown = shown[::-1]
    labels = [f"{_wrapped(headed(name_of(e)))}<br><i>{likelihood(p)}</i>" for e, p in shown]
    data = bars(labels, [p for _, p in shown])
    layout = {"xaxis": axis("probability", range=[0, 1], tickformat=".0%"), "yaxis": {"type": "category"}}
    caption = "‘Nothing unmodelled’: parameter error and noise alone. Words as the IPCC uses them."
    return plot("evidence", "Explanations", caption, [Variant("", [data])], layout, 80 + 60 * len(shown))


def in_words(diagnosis: Diagnosis) -> Html:
    """The credible set and the classes."""
    d = diagnosis
    names = [name_of(e) for e in d.credible]
    total = sum(s.probability for s in d.scored if s.explanation in d.credible)
    lines = [
        f"The credible set, the smallest that holds 95 %, is {listed(names)}: together {percent(total)}."
        if len(names) > 1
        else f"The credible set, the smallest that holds 95 %, has one member: {names[0]} ({percent(total)})."
    ]
    if d.indistinguishable:
        lines += [
            f"These trials cannot tell {listed([name_of(e) for e in pair.effects])} apart at the fitted size: even the"
            f" best possible rule would be wrong in {percent(pair.bayes_error)} of cases."
            for pair in d.indistinguishable
        ]
    elif d.verdict in ("identified", "ambiguous"):
        lines.append(
            "No rival with as many effects could imitate the first explanation at its fitted size: the error of the"
            f" best rule between the two stays below {percent(BAYES_ERROR)} for each."
        )
    return bullets(lines)


def tried(diagnosis: Diagnosis) -> Html:
    """Every fit with its misfit."""
    d = diagnosis
    n = d.observations.n_used
    rows = [
        (
            headed(name_of(f.explanation)),
            percent(p, 1),
            f"{f.chi2.sum() / n:.3g}",
            si(2 * f.objective),
            _sizes(f),
        )
        for f, p in sorted(zip(d.fits, d.probability, strict=True), key=lambda item: -item[1])
    ]
    head = ("Explanation", "Probability", "χ² per sample", "χ² with priors", "Its parameters")
    note = element(
        "p",
        "χ² per sample is 1 where only noise is left. A true cause whose form differs from the library's leaves more,"
        " so the probabilities count a share of the force as a form that is a little wrong.",
        class_="muted",
    )
    return details(
        f"All {len(rows)} explanations that were fitted", table("Most probable first", head, rows), note
    )


def _sizes(fitted: Fit) -> Html:
    """The parameters of effects with their bounds flagged."""
    known = parameters(fitted.explanation)
    lines = [
        f"{p.name} = {si(value, 3, p.unit)}{' (at bound)' if bound else ''}"
        for (name, p), value, bound in zip(known, fitted.theta, np.asarray(fitted.at_bound), strict=False)
        if "." in name
    ]
    return join(element("div", formula(line)) for line in lines)


def _wrapped(name: str) -> str:
    lines = [""]
    for word in name.split():
        if len(lines[-1]) + len(word) > WIDTH:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return "<br>".join(lines)
