"""`import.html`: every cut on the whole recording, on one self-contained page that drops, keeps and moves them."""

import json
from collections.abc import Sequence
from importlib.resources import files
from typing import Any

import numpy as np

from acf_jax import __version__
from acf_jax.recording.cut import Cut
from acf_jax.recording.impacts import Impacts
from acf_jax.recording.review import AUTO, SCHEMA
from acf_jax.recording.series import Array, Series
from acf_jax.recording.write import entry_of
from acf_jax.report.markup import Html, bullets, element, join, section, table, void
from acf_jax.report.page import Part, page, part
from acf_jax.report.plot import Drawn, Variant, axis, plain, plot, series
from acf_jax.report.trusted import trusted

BUCKETS = 3000  # of the whole recording; each shows its least and largest sample
MOST = 300  # cuts that the page carries sample by sample


def import_page(impacts: Impacts, review: str | None, dataset: str, origin: str = "") -> str:
    """The page.

    **Arguments:** `review`, `dataset`: where cuts.yaml, if there is one, and the data set lie, as the user calls them.
    `origin`: how it came about.
    """
    name = impacts.session.path.name
    cut = impacts.cuts
    parts = [
        part(
            "faults",
            "Faults",
            "Why no data set came of it",
            bullets(impacts.faults) if impacts.faults else None,
        ),
        Part("recording", "Recording", section("recording", "The whole recording", whole_recording(impacts))),
        Part(
            "cuts",
            "Cuts",
            section(
                "cuts",
                "Each cut",
                _decide(impacts),
                element("div", all_cuts(impacts), each_cut(impacts), class_="beside"),
                cuts_table(impacts, is_editable=True),
            ),
        )
        if cut
        else None,
        Part("notes", "Notes", section("notes", "What was taken, and from where", taken(impacts))),
        Part("next", "Next", section("next", "What to do next", _next(impacts, review, dataset))),
    ]
    foot = element(
        "p",
        f"acf-jax {__version__}. SI units; positive force compresses, positive velocity approaches; time 0 of a cut is"
        f" first contact. {origin}",
        class_="muted",
    )
    script = (files("acf_jax.recording") / "cuts.js").read_text("utf-8") if cut else ""
    return page(f"Import of {name}", _head(impacts), [part for part in parts if part], foot, script)


def _head(impacts: Impacts) -> Html:
    kept = impacts.kept
    found, used = len(impacts.cuts), len(kept)
    session = impacts.session
    conditions = len({cut.condition for cut in kept})
    step = np.median(np.diff(session.force.time[:100_000])) * 1e-9 if session.force.time.size > 1 else np.nan
    speeds = [v for c in kept or impacts.cuts if np.isfinite(v := c.velocity.value)]
    pretensions = [p for c in kept or impacts.cuts if np.isfinite(p := c.pretension.value)]
    noise = [c.contact.noise_std for c in kept or impacts.cuts]
    tiles = [
        ("Contacts" if impacts.faults else "Conditions", f"{found if impacts.faults else conditions}"),
        ("Contact velocity", _range(speeds, "m/s")),
        ("Pretension", _range(pretensions, "N")),
        ("Noise before contact", f"{np.median(noise):.2g} N" if noise else "–"),
        ("Force sampled at", f"{1.0 / step:.4g} Hz"),
    ]
    if impacts.faults:
        said = f"No data set: {impacts.faults[0]}"
    elif used == found:
        said = f"All {found} contacts go into the data set."
    else:
        said = f"{used} of {found} contacts are kept."
    minutes = f"{session.duration:.1f} s" if session.duration < 120 else f"{session.duration / 60:.1f} min"
    facts = (
        element("div", element("dt", term), element("dd", value, class_="value")) for term, value in tiles
    )
    return Html(
        element("h1", f"Import of {session.path.name}")
        + ("" if impacts.faults else trusted(impacts.trust))
        + element("p", said, class_="verdict")
        + element(
            "p", f"{minutes} of recording. Look at every cut before you trust the data set.", class_="muted"
        )
        + element("dl", *facts, class_="tiles")
    )


def _decide(impacts: Impacts) -> Html:
    """The button that saves cuts.yaml, and what cuts.js has to know: the cuts as cuts.yaml would have them."""
    cuts = []
    for cut in impacts.cuts:
        entry = entry_of(impacts, cut, None if impacts.faults else cut.keep)
        keep = AUTO if entry.keep is None else entry.keep
        cuts.append({"trial": entry.trial, "contact_s": entry.contact_s, "keep": keep, "shown": cut.keep})
    content = json.dumps({"schema": SCHEMA, "recording": impacts.session.path.name, "cuts": cuts})
    how = (
        "Click a mark to drop or keep a contact, or use the boxes of the table. Drag an upright line to move a"
        " contact, or type its time."
    )
    return join(
        [
            element("p", how, class_="muted"),
            element(
                "p",
                element(
                    "button", "Save cuts.yaml", type="button", id="save-cuts", class_="first", disabled=True
                ),
                " ",
                element("span", "Nothing is changed.", id="cuts-said", role="status", aria_live="polite"),
            ),
            element("script", Html(content.replace("<", "\\u003c")), type="application/json", id="cuts-data"),
        ]
    )


def whole_recording(impacts: Impacts) -> Drawn:
    """Force and robot over time, with a mark and a band for each cut."""
    session = impacts.session
    begin = int(session.force.time[0])
    shown: list[dict[str, Any]] = [_line(*envelope(session.force, begin), "force", "--recalibrated")]
    if kept := impacts.kept:
        name = "can be used" if impacts.faults else "kept"
        shown.append(_marks(kept, begin, name, "--corrected", "circle"))
    if dropped := [c for c in impacts.cuts if not c.keep]:
        shown.append(_marks(dropped, begin, "not kept", "--bad", "x"))
    layout: dict[str, Any] = {"xaxis": axis("time since the first force sample / s", domain=[0, 1])}
    layout["yaxis"] = axis("force / N")
    if isinstance(session.speed, Series):
        label = "position / m" if session.is_position else "velocity / m/s"
        shown.append({**_line(*envelope(session.speed, begin), label[:8], "--nominal"), "yaxis": "y2"})
        layout["xaxis"]["anchor"] = "y2"
        layout["yaxis"]["domain"], layout["yaxis2"] = [0.36, 1], axis(label, domain=[0, 0.28])
    spans = [
        _span(
            1e-9 * (c.contact.begin - begin + int(c.time[0])),
            1e-9 * (c.contact.begin - begin + int(c.time[-1])),
        )
        for c in impacts.cuts
        if c.keep and c.time.size
    ]
    handles = [
        _handle(1e-9 * (c.contact.begin - begin), c.trial) for c in impacts.cuts if c.keep and c.time.size
    ]
    caption = (
        "Each mark is a contact, at its largest force; the upright line is its first touch, the shaded band what was"
        f" cut. The curve runs through the least and the largest sample of {BUCKETS:,} equal parts."
        " Drag to zoom, double-click to return."
    )
    return plot(
        "whole",
        "Force and robot over time",
        caption,
        [Variant("", shown, {"shapes": [*spans, *handles]})],
        layout,
        480,
    )


def each_cut(impacts: Impacts) -> Drawn:
    """Every sample of a cut, with a choice among them."""
    cuts = impacts.cuts[:MOST]
    layout = {
        "xaxis": axis("time since first contact / ms"),
        "yaxis": axis("force / N"),
    }
    more = f" The first {MOST} can be chosen." if len(impacts.cuts) > MOST else ""
    caption = (
        "Every sample of the cut. The upright line is time 0, where contact was found; the dotted one is the force"
        f" before contact, with three standard deviations of its noise as a band.{more}"
    )
    variants = [_cut(cut) for cut in cuts]
    return plot("cut", "Force of one contact", caption, variants, layout, 420, "Cut")


def all_cuts(impacts: Impacts) -> Drawn:
    """All cuts over the time from contact; cuts.js takes their lines from the figure beside it."""
    layout = {
        "xaxis": axis("time since first contact / ms"),
        "yaxis": axis("force / N"),
        "showlegend": False,
    }
    caption = "A click on a line shows that cut alone. Dashed: not kept."
    return plot("all", "All cuts from contact", caption, [Variant("", [])], layout, 420)


def _cut(cut: Cut) -> Variant:
    ms = 1e-6 * cut.time
    offset = (
        0.0
        if cut.time.size == 0
        else float(np.median(cut.force[cut.time < 0] if (cut.time < 0).any() else 0.0))
    )
    samples = {
        "type": "scatter", "mode": "lines+markers", "x": series(ms, 8), "y": series(cut.force, 6), "name": "force",
        "line": {"color": "--recalibrated", "width": 1}, "marker": {"size": 4, "color": "--measured"},
        "hovertemplate": "%{x} ms: %{y} N<extra></extra>",
    }  # fmt: skip
    noise = 3.0 * cut.contact.noise_std
    shapes = [
        {"type": "line", "x0": 0, "x1": 0, "yref": "paper", "y0": 0, "y1": 1,
         "line": {"color": "--corrected", "width": 2}, "editable": True, "name": cut.trial},
        {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": offset, "y1": offset,
         "line": {"color": "--muted", "dash": "dot", "width": 1}, "layer": "below"},
        {"type": "rect", "xref": "paper", "x0": 0, "x1": 1, "y0": offset - noise, "y1": offset + noise,
         "fillcolor": "--band", "line": {"width": 0}, "layer": "below"},
    ]  # fmt: skip
    state = "" if cut.keep else "; not kept"
    label = f"{cut.trial}: {cut.words}{state}"
    problems = {
        "text": plain("; ".join(cut.remarks)), "xref": "paper", "yref": "paper", "x": 1, "y": 1, "xanchor": "right",
        "yanchor": "top", "showarrow": False, "font": {"color": "--bad"},
    }  # fmt: skip
    layout = {"shapes": shapes, "showlegend": False, "annotations": [problems] if cut.remarks else []}
    return Variant(label, [samples], layout)


def cuts_table(impacts: Impacts, is_editable: bool = False) -> Html:
    """A row a cut: what was measured, and whether it is kept; with fields for cuts.js where it is editable."""
    begin = int(impacts.session.force.time[0])
    rows = []
    for cut in impacts.cuts:
        word = "can be used" if impacts.faults else "kept"
        kept = element("span", word, class_="good") if cut.keep else element("span", "not kept", class_="bad")
        v_e, f_p = cut.condition
        seconds: Html | str = f"{1e-9 * (cut.contact.begin - begin):.6f} s"
        if is_editable:
            box = void(
                "input",
                type="checkbox",
                data_keep=cut.trial,
                aria_label=f"keep {cut.trial}",
                checked=cut.keep,
            )
            kept = join([box, " ", kept])
            seconds = _seconds_field(cut.trial, 1e-9 * (cut.contact.begin - begin))
        rows.append(
            (
                cut.trial,
                seconds,
                f"{cut.velocity.value:.5g} ± {cut.velocity.std:.2g} m/s"
                if np.isfinite(cut.velocity.value)
                else "–",
                f"{cut.pretension.value:.4g} N" if np.isfinite(cut.pretension.value) else "–",
                f"{v_e:g} m/s, {f_p:g} N" if cut.keep and not impacts.faults else "–",
                f"{cut.reading:.4g} N",
                join([kept, f": {'; '.join(cut.remarks)}" if cut.remarks else ""]),
            )
        )
    head = ("Cut", "First contact", "Measured velocity", "Pretension", "Condition", "Peak", "Data set")
    return table("As found in the recording; ± is one standard deviation", head, rows)


def _seconds_field(trial: str, seconds: float) -> Html:
    value = f"{max(seconds, 0.0):.6f}"
    label = f"first contact of {trial}, s"
    return join(
        [
            void(
                "input",
                type="number",
                step="0.0001",
                min="0",
                value=value,
                data_contact=trial,
                aria_label=label,
            ),
            " s",
        ]
    )


def taken(impacts: Impacts) -> Html:
    """Which signals were taken, and what a reader should know of them."""
    session = impacts.session
    words = {
        "force": "force",
        "speed": "position" if session.is_position else "velocity",
        "pretension": "pretension",
    }
    taken = [
        f"{word}: {session.labels[role]}"
        if role in session.labels
        else f"{word}: {getattr(session, role):g}, as given"
        for role, word in words.items()
    ]
    if (level := impacts.level) is not None:
        taken.append(
            f"threshold: {level.threshold:.3g} N above the force just before, whose noise is {level.noise_std:.2g} N"
        )
    varied = {"velocity": impacts.velocity_spread, "pretension": impacts.pretension_spread}
    taken += [f"repeats vary by {100 * v:.2g} % in {word}" for word, v in varied.items() if v is not None]
    return bullets([*taken, *impacts.notes])


def _next(impacts: Impacts, review: str | None, dataset: str) -> Html:
    file = f"Edit {review}" if review else "Edit that file"
    wrong = (
        "Is a cut wrong? Change it above, save cuts.yaml, then import again with --review"
        f" {review or 'cuts.yaml'}. {file} by hand to add a contact: a new line adds one."
    )
    if impacts.faults:
        return bullets(["Mend what stands above, then import again.", wrong])
    steps = (
        wrong,
        "Is its rig described? dataset.yaml wants mass, damping and stiffnesses with their standard deviations.",
        f"python -m acf_jax diagnose {dataset} --out diagnosis",
    )
    return bullets([*steps[:2], element("code", steps[2])])


def envelope(signal: Series, begin: int) -> tuple[Array, Array]:
    """Times since `begin` (ns), s, and values of a line that shows the least and largest sample of each part."""
    size = signal.time.size
    if size <= 4 * BUCKETS:
        return signal.seconds(begin), signal.value
    edges = np.linspace(0, size, BUCKETS + 1).astype(int)[:-1]
    least, largest = np.minimum.reduceat(signal.value, edges), np.maximum.reduceat(signal.value, edges)
    time = (signal.time[edges] - begin) * 1e-9
    return np.repeat(time, 2), np.stack([least, largest], 1).ravel()


def _line(time: Array, value: Array, name: str, color: str) -> dict[str, Any]:
    return {
        "type": "scatter", "mode": "lines", "x": series(time, 9),
        "y": series(value, 5), "name": plain(name), "line": {"color": color, "width": 1},
        "hovertemplate": "%{x} s: %{y}<extra></extra>",
    }  # fmt: skip


def _marks(cuts: Sequence[Cut], begin: int, name: str, color: str, symbol: str) -> dict[str, Any]:
    return {
        "type": "scatter", "mode": "markers", "name": name,
        "x": series([1e-9 * (c.contact.begin - begin) for c in cuts], 9), "y": series([c.contact.peak for c in cuts]),
        "customdata": [c.trial for c in cuts],
        "text": [plain(f"{c.trial}: {'; '.join(c.remarks) or f'{c.velocity.value:.4g} m/s'}") for c in cuts],
        "hovertemplate": "%{text}<extra></extra>", "marker": {"color": color, "symbol": symbol, "size": 8},
    }  # fmt: skip


def _handle(contact: float, trial: str) -> dict[str, Any]:
    """The line at a contact, which can be dragged."""
    return {
        "type": "line", "editable": True, "name": trial, "x0": contact, "x1": contact, "yref": "paper",
        "y0": 0, "y1": 1, "line": {"color": "--corrected", "width": 1},
    }  # fmt: skip


def _span(first: float, last: float) -> dict[str, Any]:
    return {
        "type": "rect", "x0": first, "x1": last, "yref": "paper", "y0": 0, "y1": 1,
        "fillcolor": "--band", "line": {"width": 0}, "layer": "below",
    }  # fmt: skip


def _range(values: Sequence[float], unit: str) -> str:
    if not values:
        return "–"
    low, high = f"{min(values):.3g}", f"{max(values):.3g}"
    return f"{low} to {high} {unit}" if low != high else f"{high} {unit}"
