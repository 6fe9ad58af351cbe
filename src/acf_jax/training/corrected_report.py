"""The report on a surrogate of a corrected model, as one HTML file."""

from html import escape
from pathlib import Path
from typing import Any

from acf_jax.provenance import Origin
from acf_jax.surrogate.corrected import Domain
from acf_jax.training.charts import Axis, Series, chart, power
from acf_jax.training.config import CorrectedConfig
from acf_jax.training.report import lowered, show_cards, show_run, table, write_page

SYMBOLS = ("k_f", "k_c", "v_e", "f_p")


def write_corrected_report(
    path: Path,
    config: CorrectedConfig,
    domain: Domain,
    effects: tuple[str, ...],
    metrics: dict[str, Any],
    timings: dict[str, float],
    origin: Origin | None = None,
) -> None:
    """Write report.html from what metrics.json and timings.json hold; `origin`: how the run came about."""
    head = _headline(config, effects, metrics, timings)
    parts = [
        _errors(config, metrics),
        _box(domain),
        _worst(metrics),
        _run(config, metrics, timings),
    ]
    write_page(path, config.output.name, head, parts, origin)


def _headline(
    config: CorrectedConfig, effects: tuple[str, ...], metrics: dict[str, Any], timings: dict[str, float]
) -> str:
    error, counts = metrics["errors"]["box"], metrics["samples"]["box"]
    left = counts["left_out"]
    cards = (
        (
            power(error["relative"]["max"]),
            f"largest relative error on {error['samples']:,} fresh samples",
            "good",
        ),
        (
            power(metrics["bounds"]["force"]),
            "the relative bound that it states and that check and design use",
            "",
        ),
        (
            f"{power(error['newton']['largest_under_prediction'])} N",
            "largest under-prediction, the error that would be unsafe",
            "",
        ),
        (
            f"{1e3 * metrics['time_s']['box']['p99']:.2g} ms",
            "error of the peak's time that 99 % stay below",
            "",
        ),
        (f"{sum(timings.values()):.0f} s", "in all: simulating, training, judging", ""),
        (f"{100 * left / (left + error['samples']):.2g} %", "of the box is left to the simulation", ""),
    )
    force = "contact force" if config.labels.force == "contact" else "force that the sensor reads"
    model = escape(" and ".join(effects) or "no effect")
    return (
        f'<header><h1>Surrogate {escape(config.output.name)}</h1><p class="verdict">Peak {force}, by a network</p>'
        f"<p>Trained on simulations of the corrected model ({model}) and judged against them, on samples that training "
        f"never saw.</p>{show_cards(cards)}</header>"
    )


def _errors(config: CorrectedConfig, metrics: dict[str, Any]) -> str:
    kinds = {
        "median": ("relative", "median"),
        "p99": ("relative", "p99"),
        "p99.9": ("relative", "p99_9"),
        "max": ("relative", "max"),
        "max under": ("relative", "largest_under_prediction"),
        "max, N": ("newton", "max"),
        "max under, N": ("newton", "largest_under_prediction"),
    }
    rows = [
        [label, *(power(metrics["errors"][density][kind][key]) for density in ("box", "edges"))]
        for label, (kind, key) in kinds.items()
    ]
    spread, losses = metrics["distribution"], metrics["losses"]
    settings = config.optimiser
    steps = [min((i + 1) * settings.steps_per_checkpoint, settings.steps) for i in range(len(losses))]
    above = " and ".join(
        f"{metrics['errors'][d]['above_bound']:,} of {metrics['errors'][d]['samples']:,}"
        for d in ("box", "edges")
    )
    return (
        "<h2>How wrong it is</h2>"
        f'<div class="figures"><div>{table(("error", "even density", "edges"), rows)}</div>'
        + chart(
            "How often is the error larger?",
            [Series("relative error of the force", spread["error"], spread["share"], 0)],
            Axis("relative error", log=True),
            Axis("share of samples above it", log=True),
        )
        + chart("Training", [Series("loss", steps, losses, 0)], Axis("step"), Axis("loss", log=True))
        + "</div><p class=note>'Edges': fresh samples, dense towards the faces and corners of the box. The bound "
        "is 1.2 times the largest error on training and held-out samples and in a search for the worst "
        f"({metrics['search']['tried']:,} tries, {power(metrics['search']['largest'])}): experience, not proof. On the "
        f"fresh samples {above} were above it.</p>"
    )


def _box(domain: Domain) -> str:
    rows = [
        [_called(name), f"{low:.5g}", f"{high:.5g}", escape(unit)]
        for name, low, high, unit in zip(domain.names, domain.low, domain.high, domain.units, strict=True)
    ]
    return f"<h2>The box</h2>{table(('quantity', 'from', 'to', 'unit'), rows)}"


def _worst(metrics: dict[str, Any]) -> str:
    names = list(metrics["worst"][0])
    rows = [[f"{row[name]:.4g}" for name in names] for row in metrics["worst"]]
    head = [_called(name) for name in names]
    return "<h2>The ten worst samples</h2>" + table(head, rows)


def _called(name: str) -> str:
    """A quantity as it is printed: symbols such as k_c with their index set low, other names in words."""
    own = name.split(".")[-1]
    return lowered(escape(own)) if own in SYMBOLS else escape(own.replace("_", " "))


def _run(config: CorrectedConfig, metrics: dict[str, Any], timings: dict[str, float]) -> str:
    names = {"box": "test, even density", "edges": "test, dense at the edges"}
    rows = [
        [names[name], f"{n['answered']:,}", f"{n['left_out']:,}"] for name, n in metrics["samples"].items()
    ]
    head = ("samples", "answered", "left to the simulation")
    return show_run(table(head, rows), config, metrics, timings)
