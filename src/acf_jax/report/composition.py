"""What the gap is made of: a bar a cause."""

from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.report.markup import Html, details, element, table
from acf_jax.report.plot import LEAST, Variant, axis, plot, series
from acf_jax.report.words import condition, headed, made_of, part_of, percent, si


def in_words(diagnosis: Diagnosis) -> Html | None:
    """What the bars say, and whether refitting hides something."""
    said = made_of(diagnosis)
    return element("p", said) if said else None


def bars(diagnosis: Diagnosis) -> Html | None:
    """The share of each cause with its interval; None where there is no gap to share out."""
    parts = list(diagnosis.contributions)[::-1]  # the last one is on top
    if not parts:
        return None
    shares = [max(p.share, LEAST) for p in parts]
    data = {
        "type": "bar",
        "orientation": "h",
        "y": [headed(part_of(p)) for p in parts],
        "x": series(shares),
        "ids": [p.name for p in parts],  # a click on a cause switches it in the figure of causes
        "marker": {"color": "--bar"},
        "error_x": {
            "type": "data",
            "symmetric": False,
            "array": series(p.ci95[1] - p.share for p in parts),
            "arrayminus": series(p.share - p.ci95[0] for p in parts),
            "color": "--measured",
        },
        "customdata": [
            f"{percent(p.share)}, 95 % interval {percent(p.ci95[0])} to {percent(p.ci95[1])};"
            f" {si(p.force_rms_n, 2, 'N')} RMS, {si(p.peak_n, 2, 'N')} at the peak"
            for p in parts
        ],
        "hovertemplate": "%{y}: %{customdata}<extra></extra>",
    }
    layout = {"xaxis": axis("share of the mean square force error", range=[0, 1.02], tickformat=".0%")}
    caption = (
        "Of what the refitted model misses on conditions that it did not see. ‘Unexplained’ is what the explanation"
        " leaves beyond scatter; no model can predict the scatter between trials."
    )
    return plot(
        "made-of-bars", "Share of each part", caption, [Variant("", [data])], layout, 110 + 34 * len(parts)
    )


def figures(diagnosis: Diagnosis) -> Html | None:
    """The same in newtons, over all and at each condition."""
    d = diagnosis
    if not d.contributions:
        return None
    head = ("Part", "Share", "95 % interval", "Force, RMS", "At the peak")
    rows = [
        (
            headed(part_of(c)),
            percent(c.share),
            f"{percent(c.ci95[0])} to {percent(c.ci95[1])}",
            si(c.force_rms_n, 2, "N"),
            si(c.peak_n, 2, "N"),
        )
        for c in d.contributions
    ]
    at_each = [
        (condition(c.v_e, c.f_p), *(si(part.of_condition[k], 2, "N") for part in d.contributions))
        for k, c in enumerate(d.gap_map.conditions)
    ]
    names = ("Condition", *(headed(part_of(c)) for c in d.contributions))
    return details(
        "In newtons, and at each condition",
        table("over all conditions", head, rows),
        table("force, RMS, at each condition", names, at_each),
    )
