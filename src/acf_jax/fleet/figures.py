"""The figures of the page over all rigs."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

from acf_jax.fleet.changes import Trend
from acf_jax.fleet.record import Fleet, Rig
from acf_jax.report.markup import Html
from acf_jax.report.plot import Variant, axis, plain, plot, series
from acf_jax.report.words import VERDICTS, name_of

SHOWN = 100  # trends that can be looked at, the surest first
OCTAVE = 0.30103  # between ticks of a logarithmic axis, in decades
WIDE = 1.959964  # standard deviations to each side of a 95 % interval
COLOURS = dict(zip(VERDICTS, ("--muted", "--corrected", "--nominal", "--contact", "--bad"), strict=True))
SYMBOLS = dict(zip(VERDICTS, ("circle-open", "circle", "diamond", "triangle-up", "x"), strict=True))


def trend(fleet: Fleet, trends: Sequence[Trend]) -> Html | None:
    """A parameter of a rig over the runs, with its interval."""
    if not trends:
        return None
    labels = [*fleet.since, fleet.label]
    variants = [
        Variant(
            f"{t.rig}: {t.parameter} ({t.sigmas:+.1f} σ)".replace("(-", "(−"),
            [
                {
                    "type": "scatter", "mode": "lines+markers", "x": t.run.tolist(), "y": series(t.value),
                    "error_y": {"type": "data", "array": series(WIDE * t.std), "thickness": 1.5, "width": 6},
                    "line": {"color": "--corrected", "width": 2}, "marker": {"size": 9}, "showlegend": False,
                    "hovertemplate": "%{x}: %{y:.4g}<extra></extra>",
                }
            ],
            {"yaxis": axis(plain(t.parameter if t.unit == "1" else f"{t.parameter}, {t.unit}"))},
        )
        for t in trends[:SHOWN]
    ]  # fmt: skip
    ticks = {"tickvals": list(range(len(labels))), "ticktext": [plain(label) for label in labels]}
    layout = {"xaxis": axis("run", range=[-0.4, len(labels) - 0.6], **ticks), "yaxis": axis("")}
    caption = (
        "Value of the corrected model's parameter with its 95 % interval, over the runs whose first explanation was the"
        f" present one. {'All' if len(trends) <= SHOWN else f'The {SHOWN} surest of'} {len(trends)} trends are there."
    )
    return plot("trend", "A parameter over time", caption, variants, layout, 340, "Rig and parameter")


def causes(rigs: Sequence[Rig]) -> Html | None:
    """How often each explanation is the most probable one."""
    if not rigs:
        return None
    names = Counter(name_of(rig.first) for rig in rigs)
    order = [name for name, _ in names.most_common()][::-1]
    bars = [
        {
            "type": "bar", "orientation": "h", "name": tag, "marker": {"color": COLOURS[v]},
            "y": order, "x": [sum(r.verdict == v and name_of(r.first) == name for r in rigs) for name in order],
            "hovertemplate": f"%{{y}}, {tag}: %{{x}}<extra></extra>",
        }
        for v, (tag, _) in VERDICTS.items()
        if any(r.verdict == v for r in rigs)
    ]  # fmt: skip
    whole = {"dtick": 1} if max(names.values()) <= 10 else {}  # no parts of a rig
    layout = {
        "barmode": "stack",
        "xaxis": axis("rigs", rangemode="tozero", **whole),
        "yaxis": axis("", automargin=True),
    }
    return plot(
        "causes",
        "Most probable explanations",
        "How many rigs have each, by verdict.",
        [Variant("", bars)],
        layout,
        120 + 34 * len(order),
    )


def gaps(rigs: Sequence[Rig]) -> Html | None:
    """The force error of each rig before and after the correction."""
    known = [(rig, rig.recalibrated_rms_n, rig.corrected_rms_n) for rig in rigs]
    errors = [(rig, before, after) for rig, before, after in known if before and after]
    if not errors:
        return None
    ends = [pick(before for _, before, _ in errors) for pick in (min, max)]
    line = {"color": "--muted", "dash": "dot", "width": 1.5}
    data: list[dict[str, Any]] = [
        {"type": "scatter", "mode": "lines", "x": ends, "y": ends, "name": "nothing removed", "hoverinfo": "skip",
         "line": line}
    ]  # fmt: skip
    for verdict, (tag, _) in VERDICTS.items():
        if alike := [error for error in errors if error[0].verdict == verdict]:
            data.append(
                {"type": "scatter", "mode": "markers", "name": tag, "text": [plain(rig.rig) for rig, *_ in alike],
                 "x": series([before for _, before, _ in alike]), "y": series([after for *_, after in alike]),
                 "marker": {"color": COLOURS[verdict], "symbol": SYMBOLS[verdict], "size": 9},
                 "hovertemplate": "%{text}: %{x:.3g} → %{y:.3g} N<extra></extra>"}
            )  # fmt: skip
    layout = {
        "xaxis": axis("force error of the recalibrated model, N", type="log", dtick=OCTAVE),
        "yaxis": axis("of the corrected model, N", type="log", dtick=OCTAVE),
    }
    caption = "RMS force error on held-out conditions; the further below the line, the more of the gap is explained."
    title = "Force error before and after the correction"
    return plot("gaps", title, caption, [Variant("", data)], layout, 420)
