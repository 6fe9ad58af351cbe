"""The report of a training run: one HTML file with everything in it, for a phone as for a desk."""

import re
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from acf_jax.files import write_text
from acf_jax.provenance import PROGRAM, Origin
from acf_jax.style import stylesheet
from acf_jax.surrogate.features import FEATURES
from acf_jax.training.charts import Axis, Series, chart, colour_bar, decades, heat_map, power
from acf_jax.training.config import AnyConfig, Config, to_yaml

_STYLE = Path(__file__).with_name("report.css")
_AXES = {
    "zeta": "damping ratio ζ",
    "kappa": "κ = k_C/(k_F + k_C)",
    "share": "p/√(p² + κ)",
    "u": "distance u from the fold",
}
_TITLES = {
    ("u", "zeta"): "Fold and damping",
    ("kappa", "zeta"): "Stiffness and damping",
    ("zeta", "share"): "Damping and pretension",
}


def write_report(
    path: Path,
    config: Config,
    metrics: dict[str, Any],
    timings: dict[str, float],
    origin: Origin | None = None,
) -> None:
    """Write report.html from what metrics.json and timings.json hold; `origin`: how the run came about."""
    head = _headline(config, metrics, timings)
    parts = [
        _features(config, metrics),
        _table1(metrics) if metrics["table1"] else "",
        _where(config, metrics),
        _worst(metrics),
        _run(config, metrics, timings),
    ]
    write_page(path, config.output.name, head, parts, origin)


def write_page(path: Path, name: str, head: str, parts: Sequence[str], origin: Origin | None) -> None:
    """Write one self-contained HTML file: head, sections, foot."""
    made = f" {escape(str(origin))}" if origin else ""
    write_text(
        path,
        f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="generator" content="{PROGRAM}">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Peak force surrogate: {escape(name)}</title>
<style>
{stylesheet()}{_STYLE.read_text(encoding="utf-8")}</style>
</head>
<body>
{head}
<main>
{"".join(f"<section>{part}</section>" for part in parts if part)}
</main>
<footer><p class="muted">{PROGRAM}. SI units.{made}</p></footer>
</body>
</html>
""",
    )


def _headline(config: Config, metrics: dict[str, Any], timings: dict[str, float]) -> str:
    error = metrics["errors"][config.features]["box"]
    relative, newton, drawn = error["relative"], error["newton"], metrics["samples"]["box"]
    share = drawn["without_peak"] / (drawn["without_peak"] + drawn["with_peak"])
    cards = (
        (power(relative["max"]), f"largest relative error on {drawn['with_peak']:,} fresh samples", "good"),
        (power(relative["p99_9"]), "relative error that 99.9 % of them stay below", ""),
        (
            f"{power(newton['largest_under_prediction'])} N",
            "largest under-prediction, the error that would be unsafe",
            "",
        ),
        (
            f"{timings[f'train_{config.features}_s']:.0f} s",
            f"of training, {config.optimiser.steps:,} steps",
            "",
        ),
        (f"{metrics['errors'][config.features]['parameters']:,}", "weights and biases", ""),
        (f"{100 * share:.2g} %", "of the box has no peak: set apart, counted, refused by the surrogate", ""),
    )
    return (
        f"<header><h1>Surrogate {escape(config.output.name)}</h1>"
        '<p class="verdict">Peak contact force, by a network</p>'
        "<p>Trained on the analytic model's peak force and judged against it, on samples that training never "
        f"saw. Feature set: <b>{config.features}</b> ({lowered(FEATURES[config.features].meaning)}).</p>"
        f"{show_cards(cards)}</header>"
    )


def show_cards(cards: Sequence[tuple[str, str, str]]) -> str:
    """Figures with what they mean: value, text, kind."""
    shown = (
        f'<div><dd class="value {kind}">{value}</dd><dt>{text}</dt></div>' for value, text, kind in cards
    )
    return f'<dl class="tiles">{"".join(shown)}</dl>'


def _features(config: Config, metrics: dict[str, Any]) -> str:
    curves, losses = [], []
    for colour, name in enumerate(config.all_features):
        spread = metrics["distribution"][name]
        curves.append(Series(name, spread["error"], spread["share"], colour))
        history = metrics["losses"][name]
        steps = [
            min((i + 1) * config.optimiser.steps_per_checkpoint, config.optimiser.steps)
            for i in range(len(history))
        ]
        losses.append(Series(name, steps, history, colour))
    names, errors = config.all_features, [metrics["errors"][name] for name in config.all_features]

    def row(label: str, *path: str) -> list[str]:
        cells = [label]
        for value in errors:
            for key in path:
                value = value[key]
            cells.append(power(value))
        return cells

    rows = [
        ["inputs", *(str(len(FEATURES[name].inputs)) for name in names)],
        row("median", "box", "relative", "median"),
        row("p99", "box", "relative", "p99"),
        row("p99.9", "box", "relative", "p99_9"),
        row("max", "box", "relative", "max"),
        row("max, edges", "edges", "relative", "max"),
        row("max under", "box", "relative", "largest_under_prediction"),
        row("p99.9, N", "box", "newton", "p99_9"),
        row("max, N", "box", "newton", "max"),
        row("max under, N", "box", "newton", "largest_under_prediction"),
    ]
    meanings = "; ".join(f"<b>{name}</b>: {lowered(FEATURES[name].meaning)}" for name in config.all_features)
    return (
        "<h2>What the physics buys</h2>"
        "<p>The same network, samples, optimiser and number of steps; only what it sees and predicts "
        f"differs. {meanings}.</p>"
        + f'<div class="figures"><div>{table(("error", *names), rows)}</div>'
        + chart(
            "How often is the error larger?",
            curves,
            Axis("relative error", log=True),
            Axis("share of samples above it", log=True),
        )
        + chart("Training", losses, Axis("step"), Axis("loss (its own target, scaled)", log=True))
        + "</div><p class=note>Relative errors are |surrogate/model - 1|; 'under': under-predictions only; "
        "'edges': a second set of fresh samples, dense towards the faces and corners of the box. "
        "The losses have different targets: compare the errors, not the losses.</p>"
    )


def _table1(metrics: dict[str, Any]) -> str:
    rows = metrics["table1"]
    v = [row["v_e"] for row in rows]
    cells = [
        [
            f"{row['v_e']:.2f}",
            f"{row['measured']:.0f}",
            f"{row['paper_model']:.0f}",
            f"{row['model']:.2f}",
            f"{row['surrogate']:.2f}",
            "outside" if row["bound"] is None else power(row["bound"]),
        ]
        for row in rows
    ]
    head = ("v_E, m/s", "measured", "paper", "model", "surrogate", "bound")
    picture = chart(
        "Table 1 as a picture",
        [
            Series("surrogate", v, [row["surrogate"] for row in rows], 0),
            Series("paper's model", v, [row["paper_model"] for row in rows], 2, "points"),
            Series("measured", v, [row["measured"] for row in rows], 1, "points"),
        ],
        Axis("contact velocity v_E, m/s", low=0, high=0.4),
        Axis("peak force, N", low=0, high=350),
    )
    return (
        "<h2>Table 1 of the paper</h2><p>Peak force in N at a pretension of 100 N: "
        "measured, the paper's model column, this repository's model, the surrogate, and the error bound "
        "that the surrogate states. What is left between model and measurement is the model's gap to the "
        "real flange; the surrogate adds nothing visible to it.</p>"
        f'<div class="figures">{picture}<div>{table(head, cells)}</div></div>'
    )


def _where(config: Config, metrics: dict[str, Any]) -> str:
    values = [cell for m in metrics["map"] for row in m["largest"] for cell in row if cell is not None]
    typical = sorted(values)
    span = decades([typical[len(typical) // 50], typical[-1]])
    maps = "".join(
        heat_map(
            _TITLES[m["up"], m["across"]],
            m["largest"],
            Axis(_AXES[m["across"]], low=m["range"][0][0], high=m["range"][0][1]),
            Axis(_AXES[m["up"]], low=m["range"][1][0], high=m["range"][1][1]),
            span,
        )
        for m in metrics["map"]
    )
    bound, error = metrics["bound"], metrics["errors"][config.features]
    steps = chart(
        "Error bound the surrogate states",
        [Series("relative bound", [0, *bound["u"]], [*bound["relative"], bound["relative"][-1]], 0, "step")],
        Axis("distance from the fold u (0: the peak disappears)", low=0, high=1),
        Axis("relative error", log=True),
    )
    above = " and ".join(f"{error[d]['above_bound']:,} of {error[d]['samples']:,}" for d in ("box", "edges"))
    return (
        "<h2>Where the error is</h2><p>The largest error in each cell of the dimensionless groups; cells "
        "without colour hold no sample with a peak.</p>"
        f"{colour_bar('largest relative error in a cell', span)}"
        f'<div class="figures many">{maps}{steps}</div>'
        "<p class=note>The bound is the largest error that held-out samples had at this distance from the "
        "fold or farther: experience, not proof. On the fresh samples (even density, and dense at the edges) "
        f"{above} were above it.</p>"
    )


def _worst(metrics: dict[str, Any]) -> str:
    head = ("error", "peak, N", "m, kg", "ζ", "k_F, N/m", "k_C, N/m", "v_E, m/s", "F_P, N", "u")
    rows = [
        [
            power(row["relative_error"]),
            f"{row['f_max']:.1f}",
            f"{row['m']:.3g}",
            f"{row['zeta']:.3g}",
            *(f"{row[key]:,.0f}" for key in ("k_f", "k_c")),
            *(f"{row[key]:.3g}" for key in ("v_e", "f_p", "u")),
        ]
        for row in metrics["worst"]
    ]
    return "<h2>The ten worst samples</h2>" + table(head, rows)


def _run(config: Config, metrics: dict[str, Any], timings: dict[str, float]) -> str:
    names = {"train": "training", "box": "test, even density", "edges": "test, dense at the edges"}
    samples = [
        [names[name], f"{n['with_peak']:,}", f"{n['without_peak']:,}"]
        for name, n in metrics["samples"].items()
    ]
    return show_run(table(("samples", "with a peak", "without"), samples), config, metrics, timings)


def show_run(samples: str, config: AnyConfig, metrics: dict[str, Any], timings: dict[str, float]) -> str:
    """Samples, timings, configuration and versions."""
    clocks = [[key.removesuffix("_s").replace("_", " "), f"{value:.1f}"] for key, value in timings.items()]
    versions = " · ".join(f"{escape(k)} {escape(v)}" for k, v in metrics["versions"].items())
    return (
        f'<h2>The run</h2><div class="figures"><div>{samples}</div><div>'
        + table(("timing of this session", "s"), clocks)
        + f"</div></div><details><summary>Configuration</summary>"
        f"<pre>{escape(to_yaml(config))}</pre></details>"
        f"<p class=note>{versions}</p>"
    )


def lowered(text: str) -> str:
    """Text with its subscripts (F_P, k_C) set low."""
    return re.sub(r"_(\w+)", r"<sub>\1</sub>", text)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """An HTML table; the cells are HTML already."""
    top = "".join(f"<th>{lowered(cell)}</th>" for cell in head)
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return f'<div class="numbers"><table><tr>{top}</tr>{body}</table></div>'
