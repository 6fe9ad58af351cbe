"""What the data themselves look like: noise, offsets, triggers, loss of contact, trials left out."""

from collections.abc import Callable

import numpy as np

from acf_jax.dataset import TrialQuality
from acf_jax.diagnosis.diagnose import Diagnosis
from acf_jax.report.markup import Html, bullets, details, element, join, table
from acf_jax.report.words import condition, headed, percent, si

CLEAR = 5.0  # standard deviations of a drift that count as clear
SOURCES = {
    "stated": "as stated in dataset.yaml",
    "approach": "from the samples before contact",
    "differences": "from differences of neighbouring samples",
    "repeats": "from repeated conditions",
    "assumed": "assumed, for nothing tells it",
}


def warnings(diagnosis: Diagnosis) -> Html:
    """What a reader should know before trusting the rest."""
    d = diagnosis
    if not d.warnings:
        return element("p", "None.")
    return bullets(headed(w).removesuffix(".") + "." for w in d.warnings)


def overview(diagnosis: Diagnosis) -> Html:
    """Quality of the data set in a few lines, and what was left out."""
    d = diagnosis
    looks = d.quality.trials
    lines = [_noise(d)]
    approaches = [x.approach for x in looks if x.approach]
    if approaches:
        drifting = sum(abs(a.drift) > CLEAR * a.drift_std for a in approaches)
        lines.append(
            f"Sensor before contact: offset {_range([a.offset for a in approaches], 'N')}; a drift clear of the noise"
            f" in {drifting} of {len(approaches)} trials."
        )
    triggers = [1e3 * x.trigger_offset for x in looks if x.trigger_offset is not None]
    if triggers:
        lines.append(f"Trigger against the other trials: {_range(triggers, 'ms')}.")
    rates = [x.sample_rate for x in looks if x.sample_rate]
    if rates:
        same = np.ptp(rates) < 1e-3 * max(rates)
        lines.append(f"Sampled at {si(rates[0], 3, 'Hz')}." if same else f"Sampled at {_range(rates, 'Hz')}.")
    phases = [x.phase for x in looks if x.phase]
    if phases:
        whole = [p.missed_peak / p.height for p in phases if p.height > 0 and p.cut_off is None]
        lost, again = (
            sum(getattr(p, k) is not None for p in phases) for k in ("contact_lost", "second_contact")
        )
        ratios = [p.impulse_ratio for p in phases if p.impulse_ratio is not None]
        if whole:
            lines.append(f"Sampling may have missed {max(0.1, 100 * max(whole)):.1f} % of a peak at most.")
        lines.append(
            f"Contact is lost within the trace in {lost} of {len(phases)} trials; a second contact follows in {again}."
        )
        lines.append(
            f"Impulse over the impact: {_range([p.impulse for p in phases], 'N s')}"
            + (f"; after the crest {_range(ratios, '')} of that before it." if ratios else ".")
        )
    else:
        lines.append("Peaks only: there are no traces to look at.")
    return join([bullets(lines), _left_out(d), _trials(d)])


def _noise(d: Diagnosis) -> str:
    noise = d.quality.noise
    colour = (
        "white: samples are independent"
        if noise.is_white
        else f"coloured: {percent(noise.share)} of its variance lasts about {si(1e3 * noise.correlation_time, 2, 'ms')}"
    )
    spread = d.dataset.measurement
    return (
        f"Noise of the force: {si(noise.std, 3, 'N')} ({SOURCES.get(noise.source, noise.source)}), {colour}. Trial to"
        f" trial, velocity varies by {percent(spread.contact_velocity_rel_std, 1)} and pretension by"
        f" {percent(spread.pretension_rel_std, 1)} (standard deviations, as stated)."
        + (
            f" The sensor reads behind a tool of {si(tool, 3, 'kg')}."
            if (tool := spread.tool_mass_kg)
            else ""
        )
    )


def _left_out(d: Diagnosis) -> Html:
    if not d.excluded:
        return element("p", "All trials were used.")
    rows = list(d.excluded.items())
    return table("Trials left out", ("Trial", "Reason"), rows)


def _trials(d: Diagnosis) -> Html:
    commanded = {t.name: t for t in d.dataset.trials}
    head = (
        "Trial", "Condition", "Peak", "Missed, at most", "Impulse", "Contact lost", "Second contact",
        "Offset", "Trigger",
    )  # fmt: skip
    rows = []
    for x in d.quality.trials:
        t, phase = commanded[x.name], x.phase
        peak = phase.peak_force if phase else t.peak_force
        bound = "≥ " if x.peak_is_bound or (phase and phase.cut_off is not None) else ""
        rows.append(
            (
                x.name + (" (left out)" if x.name in d.excluded else ""),
                condition(t.contact_velocity, t.pretension),
                bound + _or_none(peak, lambda v: f"{v:.1f} N"),
                _or_none(phase.missed_peak if phase else None, lambda v: f"{v:.2f} N"),
                _or_none(phase.impulse if phase else None, lambda v: f"{v:.3g} N s"),
                _or_none(phase.contact_lost if phase else None, _milliseconds),
                _or_none(phase.second_contact if phase else None, _milliseconds),
                _or_none(_offset(x), lambda v: f"{v:+.2f} N"),
                _or_none(x.trigger_offset, lambda v: f"{1e3 * v:+.3f} ms"),
            )
        )
    return details("Each trial", table("As the data show it, before any fit", head, rows))


def _offset(x: TrialQuality) -> float | None:
    return x.approach.offset if x.approach else None


def _milliseconds(seconds: float) -> str:
    return f"{1e3 * seconds:.2f} ms"


def _or_none(value: float | None, show: Callable[[float], str]) -> str:
    return "–" if value is None else show(value + 0.0).replace("-", "−")


def _range(values: list[float], unit: str) -> str:
    low, high = si(min(values), 2, unit), si(max(values), 2, unit)
    return high if low == high else f"{si(min(values), 2)} to {high}"
